//! Metrics of the error of a picture against a reference, both in linear RGB, and the correlation of the errors of two
//! pictures.

use super::statistics::median;

/// Errors of a picture against a reference, over all pixels and the three channels, with the noise of the reference.
/// `headwater compare` prints them. Studies compute theirs without this noise, as [`SquaredErrors`].
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Errors {
    /// Root of the mean squared difference between the values of the picture and those of the reference, in the unit of
    /// these values: W/(m²·sr) for radiance.
    pub rmse: f64,
    /// Root mean squared difference, like [`Self::rmse`], but after the values of both pictures are clamped
    /// to [0, 1], the range that a display can show, so that very bright pixels do not dominate. It has the
    /// unit of the values, and is at most 1.
    pub rmse_clamped: f64,
    /// Mean of (a − b)² / (b² + 0.01), where a is the value of the picture and b that of the reference; it
    /// has no unit. Dark and bright pixels have similar weights in this mean. The constant 0.01 keeps the
    /// quotient finite where the reference is black.
    pub relmse: f64,
    /// The mean of all values of the picture divided by the mean of all values of the reference, without
    /// unit: 1 means equal brightness. It is 1 if both pictures are black, and infinite if only the reference
    /// is black.
    pub mean_ratio: f64,
}

impl Errors {
    /// Computes the errors of `picture` against `reference`, which has the same size. Each slice has one linear RGB value
    /// per pixel, in the same order.
    ///
    /// # Panics
    /// The slices differ in length.
    pub fn between(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> Self {
        assert_eq!(picture.len(), reference.len(), "pictures of one size");
        let (mut squared, mut clamped, mut relative) = (0.0, 0.0, 0.0);
        let (mut total, mut reference_total) = (0.0, 0.0);
        let values = picture.iter().flatten().zip(reference.iter().flatten());
        for (a, b) in values {
            let (a, b) = (f64::from(*a), f64::from(*b));
            squared += (a - b).powi(2);
            clamped += (a.clamp(0.0, 1.0) - b.clamp(0.0, 1.0)).powi(2);
            relative += (a - b).powi(2) / (b * b + 0.01);
            total += a;
            reference_total += b;
        }
        let count = (picture.len() * 3).max(1) as f64;
        Self {
            rmse: (squared / count).sqrt(),
            rmse_clamped: (clamped / count).sqrt(),
            relmse: relative / count,
            mean_ratio: if total == reference_total {
                1.0
            } else {
                total / reference_total
            },
        }
    }
}

/// The errors that a picture without any error would have against a noisy reference, because of the noise of
/// the reference. They are computed from the standard error of each value of the reference. `headwater
/// compare` takes them out of the measured errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseFloor {
    /// The RMSE, against this reference, of a picture without error, in the unit of the values.
    pub rmse: f64,
    /// The relMSE, against this reference, of a picture without error; it has no unit.
    pub relmse: f64,
}

impl NoiseFloor {
    /// Computes the noise floor from the values of a reference and the standard errors of these values,
    /// `errors`. Each slice has one linear RGB value per pixel, in the same order.
    ///
    /// # Panics
    /// The slices differ in length.
    pub fn of(reference: &[[f32; 3]], errors: &[[f32; 3]]) -> Self {
        assert_eq!(reference.len(), errors.len(), "pictures of one size");
        let values = reference.iter().flatten().zip(errors.iter().flatten());
        let (mut squared, mut relative) = (0.0, 0.0);
        for (b, error) in values {
            let (b, variance) = (f64::from(*b), f64::from(*error).powi(2));
            squared += variance;
            relative += variance / (b * b + 0.01);
        }
        let count = (reference.len() * 3).max(1) as f64;
        Self {
            rmse: (squared / count).sqrt(),
            relmse: relative / count,
        }
    }

    /// The estimated RMSE of a picture against the truth, computed from its RMSE against the reference,
    /// `rmse`; both are in the unit of the values. It is 0 if the noise of the reference explains the whole
    /// RMSE.
    pub fn rmse_without(&self, rmse: f64) -> f64 {
        (rmse * rmse - self.rmse * self.rmse).max(0.0).sqrt()
    }

    /// The estimated relMSE of a picture against the truth, computed from its relMSE against the reference,
    /// `relmse`. It is 0 if the noise of the reference explains the whole relMSE.
    pub fn relmse_without(&self, relmse: f64) -> f64 {
        (relmse - self.relmse).max(0.0)
    }
}

/// Estimates of the squared errors of a picture against the truth, over all pixels and the three channels.
/// The noise of the references is taken out. Studies list them for each frame. If the picture has almost no
/// error, random noise can make them negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquaredErrors {
    /// The mean squared difference of the picture from the truth, in the squared unit of the values.
    pub mse: f64,
    /// The mean squared difference, like [`Self::mse`], but after all values are clamped to [0, 1], the range
    /// that a display can show, so that very bright pixels do not dominate.
    pub clamped_mse: f64,
    /// The mean of (a − t)² / (b² + 0.01), where a is the value of the picture, t the truth, and b the mean
    /// of the two references. It has no unit; dark and bright pixels have similar weights in it.
    pub relmse: f64,
}

impl SquaredErrors {
    /// Computes the errors of `picture` against two reference pictures `halves` of the same view. The noise
    /// of the two references must be independent of each other and of the picture. The squared difference
    /// from one noisy reference contains the variance of the reference; the product of the differences from
    /// two references does not. Each list has one linear RGB value per pixel, in the same order.
    ///
    /// # Panics
    /// The lists differ in length.
    pub fn between(picture: &[[f32; 3]], halves: &[Vec<[f32; 3]>; 2]) -> Self {
        let [first, second] = halves;
        let sizes = [first.len(), second.len()];
        assert_eq!(sizes, [picture.len(); 2], "pictures of one size");
        let mut errors = Self {
            mse: 0.0,
            clamped_mse: 0.0,
            relmse: 0.0,
        };
        let references = first.iter().flatten().zip(second.iter().flatten());
        for (a, (b1, b2)) in picture.iter().flatten().zip(references) {
            let [a, b1, b2] = [a, b1, b2].map(|v| f64::from(*v));
            let product = |f: fn(f64) -> f64| (f(a) - f(b1)) * (f(a) - f(b2));
            let squared = product(|v| v);
            errors.mse += squared;
            errors.clamped_mse += product(|v| v.clamp(0.0, 1.0));
            errors.relmse += squared / ((0.5 * (b1 + b2)).powi(2) + 0.01);
        }
        let count = (picture.len() * 3).max(1) as f64;
        Self {
            mse: errors.mse / count,
            clamped_mse: errors.clamped_mse / count,
            relmse: errors.relmse / count,
        }
    }
}

/// A picture, and the two references from which its errors are computed. The references show the same view
/// and have independent noise. Each picture has one linear RGB value per pixel, in the same order.
pub type Judged<'a> = (&'a [[f32; 3]], &'a [Vec<[f32; 3]>; 2]);

/// Pearson's correlation, in [−1, 1], of the errors of two pictures over all pixels and channels. The error of a value is
/// its difference from the truth. For successive frames of an animation it is the temporal correlation of their noise, which
/// studies report: 1 means the same pattern of noise in both frames. The noise of the references is taken out, as in
/// [`SquaredErrors`]. If all errors of one picture are equal, the correlation is undefined, and the result is 0.
///
/// # Panics
/// The lists differ in length.
pub fn error_correlation(a: Judged<'_>, b: Judged<'_>) -> f64 {
    let sizes = [
        a.1[0].len(),
        a.1[1].len(),
        b.0.len(),
        b.1[0].len(),
        b.1[1].len(),
    ];
    assert!(sizes == [a.0.len(); 5], "pictures of one size");
    let errors = |(picture, halves): Judged<'_>, half: usize| -> Vec<f64> {
        let pairs = picture.iter().flatten().zip(halves[half].iter().flatten());
        let all: Vec<f64> = pairs.map(|(p, r)| f64::from(*p) - f64::from(*r)).collect();
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        all.into_iter().map(|e| e - mean).collect()
    };
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let [a, b] = [a, b].map(|judged| [errors(judged, 0), errors(judged, 1)]);
    let shared = 0.5 * (dot(&a[0], &b[1]) + dot(&a[1], &b[0]));
    let scale = (dot(&a[0], &a[1]).max(0.0) * dot(&b[0], &b[1]).max(0.0)).sqrt();
    if scale > 0.0 {
        (shared / scale).clamp(-1.0, 1.0)
    } else {
        0.0
    }
}

/// The median, over the pixels, of the picture's luminance divided by the reference's. Each pair holds these two luminances
/// of one pixel, in the same unit. Pixels that are black in the reference are left out; if none is left, the result is 1.
/// Unlike the ratio of means, the median shows that most pixels lack light, even if a few bright pixels compensate for it.
pub fn median_ratio(pairs: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let lit = pairs.into_iter().filter(|(_, reference)| *reference > 0.0);
    let ratios: Vec<f64> = lit
        .map(|(picture, reference)| picture / reference)
        .collect();
    if ratios.is_empty() {
        1.0
    } else {
        median(ratios.into_iter())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_correlate_with_themselves_and_not_with_others() {
        let truth = [vec![[1.0; 3]; 2], vec![[1.0; 3]; 2]];
        let a = [[2.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
        let b = [[1.0, 3.0, 1.0], [1.0, -1.0, 1.0]];
        let correlation =
            |x: &[[f32; 3]], y: &[[f32; 3]]| error_correlation((x, &truth), (y, &truth));
        assert!((correlation(&a, &a) - 1.0).abs() < 1e-12);
        let opposite = a.map(|p| p.map(|v| 2.0 - v));
        assert!((correlation(&a, &opposite) + 1.0).abs() < 1e-12);
        assert!(correlation(&a, &b).abs() < 1e-12);
        assert_eq!(correlation(&a, &truth[0]), 0.0);
        // What another reference moves is no error.
        let moved = a.map(|p| p.map(|v| v + 0.5));
        let other = [vec![[1.5; 3]; 2], vec![[1.5; 3]; 2]];
        let same = error_correlation((&a, &truth), (&moved, &other));
        assert!((same - 1.0).abs() < 1e-12);
    }

    /// The picture differs from the truth by 1 everywhere. The noise of the two references, ±2, must not
    /// appear in its errors.
    #[test]
    fn noise_of_halves_is_no_error_of_the_picture() {
        let noise = |seed: u32| -> Vec<[f32; 3]> {
            let value = |i: u32| match blake3::hash(&[seed.to_le_bytes(), i.to_le_bytes()].concat())
                .as_bytes()[0]
                & 1
            {
                0 => 3.0,
                _ => 7.0,
            };
            (0..40_000)
                .map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)])
                .collect()
        };
        let halves = [noise(1), noise(2)];
        let errors = SquaredErrors::between(&vec![[6.0; 3]; 40_000], &halves);
        // The standard error of the mean product is 2 · √6 / √120,000.
        assert!((errors.mse - 1.0).abs() < 0.06, "{errors:?}");
        let exact = [vec![[5.0; 3]; 2], vec![[5.0; 3]; 2]];
        let errors = SquaredErrors::between(&[[6.0; 3]; 2], &exact);
        assert_eq!((errors.mse, errors.clamped_mse), (1.0, 0.0));
        assert!((errors.relmse - 1.0 / 25.01).abs() < 1e-12);
    }

    #[test]
    fn the_median_is_of_pixels_with_light() {
        let pairs = [(0.5, 1.0), (7.0, 0.0), (0.2, 1.0), (900.0, 1.0)];
        assert_eq!(median_ratio(pairs), 0.5);
        assert_eq!(median_ratio([(1.0, 0.0)]), 1.0);
    }

    #[test]
    fn errors_are_what_a_hand_computes() {
        let errors = Errors::between(&[[1.0, 2.0, 0.0]], &[[0.0, 4.0, 0.0]]);
        assert!((errors.rmse - (5.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!((errors.rmse_clamped - (1.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!((errors.relmse - (100.0 + 4.0 / 16.01) / 3.0).abs() < 1e-9);
        assert_eq!(errors.mean_ratio, 0.75);
    }

    /// The errors of two pictures, one of them without error, against a reference whose values differ from
    /// the truth by 0.3, which is their standard error. The errors without the noise of the reference must be
    /// 0 and 0.4.
    #[test]
    fn the_noise_of_a_reference_is_taken_out() {
        let reference: Vec<[f32; 3]> = (0..64).map(|i| [[1.3, 0.7][i % 2]; 3]).collect();
        let floor = NoiseFloor::of(&reference, &[[0.3; 3]; 64]);
        let errors = Errors::between(&[[1.0; 3]; 64], &reference);
        assert!((floor.rmse - 0.3).abs() < 1e-6, "{floor:?}");
        assert!(floor.rmse_without(errors.rmse) < 1e-3, "{errors:?}");
        assert!(floor.relmse_without(errors.relmse) < 1e-6, "{errors:?}");
        let errors = Errors::between(&[[1.4; 3]; 64], &reference);
        assert!((floor.rmse_without(errors.rmse) - 0.4).abs() < 1e-6);
    }

    #[test]
    fn the_reference_is_the_second() {
        let (dim, bright) = ([[1.0; 3]; 2], [[2.0; 3]; 2]);
        assert_eq!(Errors::between(&dim, &bright).relmse, 1.0 / 4.01);
        assert_eq!(Errors::between(&bright, &dim).relmse, 1.0 / 1.01);
        assert_eq!(Errors::between(&bright, &dim).mean_ratio, 2.0);
    }

    #[test]
    fn extremes_stay_in_range() {
        let errors = Errors::between(&[[3e38; 3]; 3], &[[0.0; 3]; 3]);
        assert!((errors.rmse / 3e38 - 1.0).abs() < 1e-6);
        assert_eq!(errors.rmse_clamped, 1.0);
        assert_eq!(errors.mean_ratio, f64::INFINITY);
        let errors = Errors::between(&[[1e-30; 3]; 3], &[[2e-30; 3]; 3]);
        assert!((errors.rmse / 1e-30 - 1.0).abs() < 1e-6);
        assert!((errors.mean_ratio - 0.5).abs() < 1e-6);
    }

    #[test]
    fn black_pictures_agree() {
        let black = [[0.0; 3]; 4];
        let errors = Errors::between(&black, &black);
        assert_eq!(
            (errors.rmse, errors.relmse, errors.mean_ratio),
            (0.0, 0.0, 1.0)
        );
    }
}
