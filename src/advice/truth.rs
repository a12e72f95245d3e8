//! Two independent references of one view, against which the errors of a race are measured.

use crate::metrics::error::median_ratio;
use crate::metrics::relative;
use crate::metrics::statistics::Estimate;
use crate::scene::lights::luminance;

/// A picture: one linear RGB radiance per pixel, row by row from the top.
pub type Picture = Vec<[f32; 3]>;

/// The references: two pictures of one view whose noise is independent. At first they are path-traced; after
/// each round of the race, the pictures of the unbiased candidates are averaged into them.
pub struct Truth {
    path_traced: [Picture; 2],
    halves: [Picture; 2],
    /// Factor by which the relMSE multiplies the squared error of each pixel and channel, about 1 / (b² +
    /// 0.01) for the reference b.
    weights: Picture,
    /// Mean radiance of each RGB channel over all pixels of both path-traced pictures, with its standard
    /// error.
    means: [Estimate; 3],
}

/// The measurements of one frame (error, brightness and mean radiance), or their means over several frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observed {
    /// The relMSE of the frame. Its expected value does not contain the noise of the references. For an
    /// almost perfect frame it can be negative.
    pub relmse: f64,
    /// Median over the lit pixels of their luminance, divided by that of the references. It is small if most
    /// pixels are dark.
    pub median: f64,
    /// Mean radiance of each RGB channel over all pixels of the frame.
    pub mean: [f64; 3],
}

impl Truth {
    /// Makes the references from two path-traced pictures, which must have `samples` samples per pixel each,
    /// with different random numbers. `errors` has the standard errors of all their values, from which the
    /// standard error of the means is computed.
    pub fn new(halves: [Picture; 2], errors: &[Picture; 2], samples: u32) -> Self {
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
        Self {
            path_traced: halves.clone(),
            weights: weights(&halves),
            halves,
            means,
        }
    }

    /// Computes the references again, as weighted means of the path-traced pictures and of `pairs`, further
    /// pairs of pictures of the same view. The first picture of each pair goes into the first reference, the
    /// second one into the second. All pictures must be independent and unbiased. The weight of a pair is the
    /// inverse of its variance, so the references have less noise than the best pair. This is needed because
    /// a few path-traced samples alone have so much noise that the divisor of the relMSE, which contains
    /// their square, is wrong.
    pub fn join(&mut self, pairs: &[[Picture; 2]]) {
        let pairs: Vec<&[Picture; 2]> = std::iter::once(&self.path_traced).chain(pairs).collect();
        let mut shares = vec![1.0; pairs.len()];
        // Variances are relative to the square of the references, so the shares of the first round are rough.
        for _ in 0..3 {
            self.halves = [0, 1].map(|half| {
                let pictures: Vec<&Picture> = pairs.iter().map(|pair| &pair[half]).collect();
                weighted(&pictures, &shares)
            });
            let variances = pairs.iter().map(|pair| variance(pair, &self.halves));
            shares = variances
                .map(|variance| 1.0 / variance.max(1e-12))
                .collect();
        }
        self.weights = weights(&self.halves);
    }

    /// Mean radiance of each RGB channel over all pixels of both path-traced pictures, with its standard
    /// error. The pictures of candidates are not included, so a bias that all of them share is found, too.
    pub fn means(&self) -> &[Estimate; 3] {
        &self.means
    }

    /// The mean of the two references: one linear RGB radiance per pixel, row by row from the top.
    pub fn reference(&self) -> Vec<[f32; 3]> {
        relative::mean_of_halves(&self.halves)
    }

    /// For each pixel, row by row, the squared difference of two pictures, divided by r² + 0.01 for the
    /// reference r, as the mean over the channels ([`relative_squares`](relative::relative_squares)). The
    /// flicker of successive frames is computed from it.
    pub fn relative_squares(&self, first: &[[f32; 3]], second: &[[f32; 3]]) -> Vec<f32> {
        relative::relative_squares(first, second, &self.halves)
    }

    /// The relative error of the luminance of each pixel of `picture`, row by row: one list for each of the
    /// two references ([`relative_differences`](relative::relative_differences)). The spectrum of the error
    /// is computed from both lists.
    pub fn relative_differences(&self, picture: &[[f32; 3]]) -> [Vec<f64>; 2] {
        relative::relative_differences(picture, &self.halves, |pixel| luminance(pixel.into()))
    }

    /// The relMSE of a picture. Each squared error is computed as the product of the differences from the
    /// first and from the second reference. Their noise is independent, so it does not change the expected
    /// value.
    fn relmse(&self, picture: &[[f32; 3]]) -> f64 {
        let [first, second] = &self.halves;
        let pixels = picture
            .iter()
            .zip(first.iter().zip(second.iter().zip(&self.weights)));
        let values =
            pixels.flat_map(|(a, (r, (s, w)))| [0, 1, 2].map(|c| [a[c], r[c], s[c], w[c]]));
        let relative = values.map(|values| {
            let [a, r, s, weight] = values.map(f64::from);
            (a - r) * (a - s) * weight
        });
        relative.sum::<f64>() / (3 * picture.len()).max(1) as f64
    }

    /// Measures the error, the brightness and the mean radiance of one frame, whose `picture` has one linear
    /// RGB radiance per pixel, row by row from the top.
    pub fn observe(&self, picture: &[[f32; 3]]) -> Observed {
        let [first, second] = &self.halves;
        let of = |pixel: &[f32; 3]| luminance((*pixel).into());
        let pixels = picture.iter().zip(first.iter().zip(second));
        let ratios = pixels.map(|(p, (a, b))| (of(p), 0.5 * (of(a) + of(b))));
        let mean =
            |c: usize| picture.iter().map(|p| f64::from(p[c])).sum::<f64>() / picture.len() as f64;
        Observed {
            relmse: self.relmse(picture),
            median: median_ratio(ratios),
            mean: [0, 1, 2].map(mean),
        }
    }
}

/// The factors 1 / (b² + 0.01) by which squared errors are multiplied, where b is the mean of the references.
/// The noise of b makes such a factor too large on average, in proportion to the variance of b. The factors
/// of the single references are too large by twice as much, because their variance is twice as large. So
/// their mean is subtracted from twice the factor of b, which removes this error unless the noise is as large
/// as b.
fn weights([first, second]: &[Picture; 2]) -> Picture {
    let factor = |b: f64| 1.0 / (b * b + 0.01);
    let weight = |r: f32, s: f32| {
        let [r, s] = [r, s].map(f64::from);
        let both = factor(0.5 * (r + s));
        let alone = 0.5 * (factor(r) + factor(s));
        (2.0 * both - alone).clamp(0.5 * both, 1.5 * both) as f32
    };
    let pixels = first.iter().zip(second);
    pixels
        .map(|(r, s)| [0, 1, 2].map(|c| weight(r[c], s[c])))
        .collect()
}

/// The variance of a pair of independent pictures, divided by the squared references as in the relMSE: the
/// mean over all pixels and channels.
pub(super) fn variance([first, second]: &[Picture; 2], references: &[Picture; 2]) -> f64 {
    let pixels = first.iter().zip(second);
    let pixels = pixels.zip(references[0].iter().zip(&references[1]));
    let values = pixels.flat_map(|((a, b), (r, s))| [0, 1, 2].map(|c| [a[c], b[c], r[c], s[c]]));
    let relative = values.map(|values| {
        let [a, b, r, s] = values.map(f64::from);
        0.5 * (a - b).powi(2) / ((0.5 * (r + s)).powi(2) + 0.01)
    });
    relative.sum::<f64>() / (3 * first.len()).max(1) as f64
}

/// The weighted mean of pictures of equal size. `weights` has one positive weight per picture, in the same
/// order; their sum need not be 1.
fn weighted(pictures: &[&Picture], weights: &[f64]) -> Picture {
    let total: f64 = weights.iter().sum();
    let pixels = 0..pictures.first().map_or(0, |picture| picture.len());
    let value = |pixel: usize, c: usize| {
        let values = pictures.iter().zip(weights);
        let sum: f64 = values
            .map(|(p, weight)| weight * f64::from(p[pixel][c]))
            .sum();
        (sum / total) as f32
    };
    pixels
        .map(|pixel| [0, 1, 2].map(|c| value(pixel, c)))
        .collect()
}

/// The sum of several pictures of equal size and their number, from which their mean is computed.
#[derive(Clone, Debug, Default)]
pub struct Added {
    sum: Vec<[f64; 3]>,
    count: u32,
}

impl Added {
    /// Adds a picture, which must have as many pixels as all earlier ones.
    pub fn add(&mut self, picture: &[[f32; 3]]) {
        self.sum.resize(picture.len(), [0.0; 3]);
        for (sum, value) in self.sum.iter_mut().flatten().zip(picture.iter().flatten()) {
            *sum += f64::from(*value);
        }
        self.count += 1;
    }

    /// Number of pictures that were added.
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// The mean of the added pictures, one linear RGB radiance per pixel; `None` if no picture was added.
    pub fn mean(&self) -> Option<Picture> {
        let scale = 1.0 / f64::from(self.count);
        (self.count > 0).then(|| {
            let pixels = self.sum.iter();
            pixels
                .map(|pixel| pixel.map(|v| (v * scale) as f32))
                .collect()
        })
    }
}

impl Observed {
    /// The arithmetic mean of several observations, value by value; all values are 0 if there are none.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::Random;

    /// A picture of 4000 grey pixels, each of which is 1 + `noise` or 1 − `noise` with equal probability.
    fn noisy(random: &mut Random, noise: f32) -> Picture {
        let sign = |random: &mut Random| if random.unit() < 0.5 { -noise } else { noise };
        (0..4000).map(|_| [1.0 + sign(random); 3]).collect()
    }

    #[test]
    fn better_pictures_make_the_references_better() {
        let random = &mut Random::new(5);
        let pair = |noise: f32, random: &mut Random| [noisy(random, noise), noisy(random, noise)];
        let poor = pair(1.0, random);
        let picture = noisy(random, 0.1);
        let mut truth = Truth::new(poor, &[vec![], vec![]], 4);
        // Half of the pixels of each reference are black, so the divisor is wrong.
        let before = truth.observe(&picture).relmse;
        truth.join(&[pair(0.02, random), pair(0.04, random)]);
        let after = truth.observe(&picture).relmse;
        let right = 0.01 / 1.01;
        assert!((after - right).abs() < 0.05 * right, "{after}");
        assert!(
            (before - right).abs() > 5.0 * (after - right).abs(),
            "{before}"
        );
    }
    /// The relMSE is not biased by the noise of the references in its divisor. Without a correction, noise of
    /// 0.2 in each reference would make the relMSE 6 % too large.
    #[test]
    fn the_noise_of_the_divisor_is_taken_out() {
        let random = &mut Random::new(9);
        let halves = [noisy(random, 0.2), noisy(random, 0.2)];
        let factors = weights(&halves);
        let mean = factors.iter().map(|f| f64::from(f[0])).sum::<f64>() / factors.len() as f64;
        assert!((mean * 1.01 - 1.0).abs() < 0.01, "{mean}");
        let truth = Truth::new(halves, &[vec![], vec![]], 4);
        let relmse = truth.observe(&noisy(random, 1.0)).relmse * 1.01;
        assert!((relmse - 1.0).abs() < 0.03, "{relmse}");
    }
}
