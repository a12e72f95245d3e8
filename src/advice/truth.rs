//! Two independent references of one view, with which the errors of a race are measured.

use crate::metrics::error::{SquaredErrors, median_ratio};
use crate::metrics::statistics::Estimate;
use crate::scene::lights::luminance;

/// Two path-traced pictures of one view, from different samples.
pub struct Truth {
    halves: [Vec<[f32; 3]>; 2],
    /// The mean over the picture of each channel, with its standard error.
    means: [Estimate; 3],
}

/// The measurements of one frame, or their means over several.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observed {
    /// The relMSE, free of the noise of the references.
    pub relmse: f64,
    /// The median over the lit pixels of their luminance, divided by that of the references.
    pub median: f64,
    /// The mean of each channel over the picture.
    pub mean: [f64; 3],
}

impl Truth {
    /// Takes two pictures, each with the standard error of each value; all have one RGB value for each pixel.
    pub fn new(halves: [Vec<[f32; 3]>; 2], errors: &[Vec<[f32; 3]>; 2], samples: u32) -> Self {
        let means = [0, 1, 2].map(|c| {
            let of = |picture: &[[f32; 3]]| -> f64 {
                picture.iter().map(|p| f64::from(p[c])).sum::<f64>() / picture.len() as f64
            };
            let variance: f64 = (errors.iter().flatten())
                .map(|e| f64::from(e[c]).powi(2))
                .sum();
            let pixels = halves[0].len() as f64;
            Estimate {
                mean: 0.5 * (of(&halves[0]) + of(&halves[1])),
                standard_error: 0.5 * variance.sqrt() / pixels,
                samples: u64::from(2 * samples),
            }
        });
        Self { halves, means }
    }

    /// The mean over the picture of each channel, with its standard error.
    pub fn means(&self) -> &[Estimate; 3] {
        &self.means
    }

    /// The mean of the two references: one linear RGB value per pixel.
    pub fn reference(&self) -> Vec<[f32; 3]> {
        let pixels = self.halves[0].iter().zip(&self.halves[1]);
        pixels.map(mean_of_two).collect()
    }

    /// For each pixel, the squared difference of two pictures relative to the references, as relMSE has it: the mean over the
    /// channels of (a − b)² / (r² + 0.01), where r is the mean of the references.
    pub fn relative_squares(&self, first: &[[f32; 3]], second: &[[f32; 3]]) -> Vec<f32> {
        let of_pixel = |((a, b), r): ((&[f32; 3], &[f32; 3]), [f32; 3])| {
            let of_channel = |c: usize| (a[c] - b[c]).powi(2) / (r[c] * r[c] + 0.01);
            (of_channel(0) + of_channel(1) + of_channel(2)) / 3.0
        };
        let pixels = first.iter().zip(second).zip(self.reference());
        pixels.map(of_pixel).collect()
    }

    /// For each pixel, the difference of its luminance from that of each reference, divided by √(r² + 0.01), where r is the
    /// luminance of the mean of the references.
    pub fn relative_differences(&self, picture: &[[f32; 3]]) -> [Vec<f64>; 2] {
        let of = |pixel: [f32; 3]| luminance(pixel.into());
        let reference: Vec<f64> = self.reference().into_iter().map(of).collect();
        [0, 1].map(|half| {
            let pixels = picture.iter().zip(&self.halves[half]).zip(&reference);
            let relative = pixels.map(|((a, b), r)| (of(*a) - of(*b)) / (r * r + 0.01).sqrt());
            relative.collect()
        })
    }

    /// Measures one frame.
    pub fn observe(&self, picture: &[[f32; 3]]) -> Observed {
        let [first, second] = &self.halves;
        let of = |pixel: &[f32; 3]| luminance((*pixel).into());
        let pixels = picture.iter().zip(first.iter().zip(second));
        let ratios = pixels.map(|(p, (a, b))| (of(p), 0.5 * (of(a) + of(b))));
        let mean =
            |c: usize| picture.iter().map(|p| f64::from(p[c])).sum::<f64>() / picture.len() as f64;
        Observed {
            relmse: SquaredErrors::between(picture, &self.halves).relmse,
            median: median_ratio(ratios),
            mean: [0, 1, 2].map(mean),
        }
    }
}

fn mean_of_two((a, b): (&[f32; 3], &[f32; 3])) -> [f32; 3] {
    [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]))
}

impl Observed {
    /// The mean of several observations.
    pub fn mean_of(all: &[Self]) -> Self {
        let count = all.len().max(1) as f64;
        let sum = |value: &dyn Fn(&Self) -> f64| all.iter().map(value).sum::<f64>() / count;
        Self {
            relmse: sum(&|o| o.relmse),
            median: sum(&|o| o.median),
            mean: [0, 1, 2].map(|c| sum(&|o| o.mean[c])),
        }
    }
}
