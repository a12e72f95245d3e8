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
