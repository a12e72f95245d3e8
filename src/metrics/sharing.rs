//! The measure of how many neighbouring pixels have the same sample. Spatial reuse gives one sample to
//! several pixels. Their errors are then similar, and a denoiser that averages them gains nothing.

/// The distance, in pixels along each axis, up to which pixels are neighbours: a neighbourhood has 5 × 5 pixels.
const RADIUS: usize = 2;

/// The fraction, in [0, 1], of the other pixels in the neighbourhood of each pixel that have the same sample
/// as this pixel; `None` for a pixel without a sample. `samples` has a value per pixel, row by row, that
/// identifies the pixel's sample; `width` is the number of pixels in a row. Pixels beyond the edge of the
/// picture do not count.
pub fn shared_samples<T: PartialEq>(samples: &[Option<T>], width: usize) -> Vec<Option<f32>> {
    let height = samples.len() / width.max(1);
    let fraction = |index: usize| {
        let own = samples[index].as_ref()?;
        let (x, y) = (index % width, index / width);
        let columns = x.saturating_sub(RADIUS)..(x + RADIUS + 1).min(width);
        let rows = y.saturating_sub(RADIUS)..(y + RADIUS + 1).min(height);
        let others = (columns.len() * rows.len() - 1).max(1);
        let pixels = rows.flat_map(|y| columns.clone().map(move |x| y * width + x));
        let same = pixels.filter(|pixel| samples[*pixel].as_ref() == Some(own));
        Some((same.count() - 1) as f32 / others as f32)
    };
    (0..width * height).map(fraction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_are_those_of_a_hand_count() {
        let own: Vec<Option<usize>> = (0..49).map(Some).collect();
        assert!(shared_samples(&own, 7).iter().all(|f| *f == Some(0.0)));
        assert!(
            shared_samples(&[Some(3); 49], 7)
                .iter()
                .all(|f| *f == Some(1.0))
        );
        // The pixel in the middle and the one to its right have the same sample, and a corner has none.
        let mut pair = own;
        pair[25] = pair[24];
        pair[0] = None;
        let fractions = shared_samples(&pair, 7);
        let expected = Some(1.0 / 24.0);
        assert_eq!([fractions[24], fractions[25]], [expected; 2]);
        assert_eq!([fractions[0], fractions[26]], [None, Some(0.0)]);
        assert_eq!(shared_samples(&[Some(1)], 1), [Some(0.0)]);
    }
}
