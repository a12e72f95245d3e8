//! Differences of two pictures at each pixel, relative to the brightness of a reference, as in the metric
//! relMSE.

/// The mean of two reference pictures, as one linear RGB value per pixel, in the order of their pixels. The
/// mean has less noise than each reference, so relative differences take their denominators from it.
pub fn mean_of_halves([first, second]: &[Vec<[f32; 3]>; 2]) -> Vec<[f32; 3]> {
    let mean = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]));
    first.iter().zip(second).map(mean).collect()
}

/// The squared difference of two pictures at each pixel, relative to the brightness, as in relMSE: the mean
/// over the three channels of (a − b)² / (r² + 0.01), where a and b are the values of the pictures, and r is
/// the mean of the two references `halves`. For successive frames, it measures how much the picture flickers.
/// All lists have one linear RGB value per pixel, in the same order.
pub fn relative_squares(
    first: &[[f32; 3]],
    second: &[[f32; 3]],
    halves: &[Vec<[f32; 3]>; 2],
) -> Vec<f32> {
    let of_pixel = |((a, b), r): ((&[f32; 3], &[f32; 3]), [f32; 3])| {
        let of_channel = |c: usize| (a[c] - b[c]).powi(2) / (r[c] * r[c] + 0.01);
        (of_channel(0) + of_channel(1) + of_channel(2)) / 3.0
    };
    let pixels = first.iter().zip(second).zip(mean_of_halves(halves));
    pixels.map(of_pixel).collect()
}

/// The difference between the luminance of `picture` and that of each of the two references `halves`, at each
/// pixel, divided by √(r² + 0.01), where r is the luminance of the mean of the references. The result has one
/// list per reference, with one value without unit per pixel. The spectrum of the error is computed from
/// these lists.
pub fn relative_differences(
    picture: &[[f32; 3]],
    halves: &[Vec<[f32; 3]>; 2],
    luminance: impl Fn([f32; 3]) -> f64,
) -> [Vec<f64>; 2] {
    let reference: Vec<f64> = (mean_of_halves(halves).into_iter())
        .map(&luminance)
        .collect();
    [0, 1].map(|half| {
        let pixels = picture.iter().zip(&halves[half]).zip(&reference);
        let relative =
            pixels.map(|((a, b), r)| (luminance(*a) - luminance(*b)) / (r * r + 0.01).sqrt());
        relative.collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_relative_to_the_mean_of_the_references() {
        let halves = [vec![[0.5; 3], [0.0; 3]], vec![[1.5; 3], [0.0; 3]]];
        let (a, b) = ([[1.5; 3], [0.1; 3]], [[1.0; 3], [0.0; 3]]);
        let squares = relative_squares(&a, &b, &halves);
        assert!((squares[0] - 0.25 / 1.01).abs() < 1e-6, "{squares:?}");
        assert!((squares[1] - 1.0).abs() < 1e-5, "{squares:?}");
        let [first, second] = relative_differences(&a, &halves, |p| f64::from(p[1]));
        let root = 1.01_f64.sqrt();
        assert!((first[0] - 1.0 / root).abs() < 1e-6 && second[0].abs() < 1e-6);
        assert!((first[1] - 1.0).abs() < 1e-5 && first[1] == second[1]);
    }
}
