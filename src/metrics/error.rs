//! Metrics of the error of a picture against a reference, both in linear RGB, and the correlation of the errors of two
//! pictures.

use super::statistics::median;

/// Errors of a picture against a reference, over all pixels and the three channels. `headwater compare` prints them, and
/// studies list all but [`Self::mean_ratio`] for each frame.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Errors {
    /// Root of the mean squared difference between the values of the picture and those of the reference, in the unit of
    /// these values: W/(m²·sr) for radiance.
    pub rmse: f64,
    /// The same as [`Self::rmse`], but after the values of both pictures are clamped to [0, 1], the range that a display can
    /// show. It has the same unit, and is at most 1.
    pub rmse_clamped: f64,
    /// Mean of (a − b)² / (b² + 0.01), where a is the value of the picture and b that of the reference; it has no unit. Dark
    /// and bright pixels have similar weights in it. The constant 0.01 keeps the quotient finite where the reference is
    /// black.
    pub relmse: f64,
    /// The mean of all values of the picture divided by the mean of all values of the reference: 1 means equal brightness.
    /// It is 1 if both pictures are black, and infinite if only the reference is black.
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

/// Pearson's correlation, in [−1, 1], of the errors of two pictures over all pixels and channels. The error of a value is
/// its difference from the value of the reference. For successive frames of an animation it is the temporal correlation of
/// their noise, which studies report: 1 means the same pattern of noise in both frames. `a` and `b` are each a pair of a
/// picture and its reference. If all errors of one picture are equal, the correlation is undefined, and the result is 0.
///
/// # Panics
/// The four slices differ in length.
pub fn error_correlation(a: [&[[f32; 3]]; 2], b: [&[[f32; 3]]; 2]) -> f64 {
    let sizes = [a[1], b[0], b[1]].map(<[_]>::len);
    assert!(sizes == [a[0].len(); 3], "pictures of one size");
    let errors = |[picture, reference]: [&[[f32; 3]]; 2]| -> Vec<f64> {
        let pairs = picture.iter().flatten().zip(reference.iter().flatten());
        let all: Vec<f64> = pairs.map(|(p, r)| f64::from(*p) - f64::from(*r)).collect();
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        all.into_iter().map(|e| e - mean).collect()
    };
    let (a, b) = (errors(a), errors(b));
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let scale = (dot(&a, &a) * dot(&b, &b)).sqrt();
    if scale > 0.0 {
        dot(&a, &b) / scale
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
        let reference = [[1.0; 3]; 2];
        let a = [[2.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
        let b = [[1.0, 3.0, 1.0], [1.0, -1.0, 1.0]];
        let correlation =
            |x: &[[f32; 3]], y: &[[f32; 3]]| error_correlation([x, &reference], [y, &reference]);
        assert!((correlation(&a, &a) - 1.0).abs() < 1e-12);
        let opposite = a.map(|p| p.map(|v| 2.0 - v));
        assert!((correlation(&a, &opposite) + 1.0).abs() < 1e-12);
        assert!(correlation(&a, &b).abs() < 1e-12);
        assert_eq!(correlation(&a, &reference), 0.0);
        // What another reference moves is no error.
        let (moved, other) = (a.map(|p| p.map(|v| v + 0.5)), [[1.5; 3]; 2]);
        let same = error_correlation([&a, &reference], [&moved, &other]);
        assert!((same - 1.0).abs() < 1e-12);
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
