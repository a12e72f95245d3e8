//! Converts pictures to text that is small enough for a page: reduces their size, and encodes them in compact
//! formats and base64.

use crate::{Error, Result};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// The number of bits of each of the three mantissas in the format RGB9E5.
const MANTISSA_BITS: i32 = 9;
/// The bias of the common exponent in the format RGB9E5.
const EXPONENT_BIAS: i32 = 15;

/// Encodes a picture as base64 text of RGB9E5 values (one exponent for three mantissas: 32 bits per pixel,
/// little-endian; Vulkan's `E5B9G9R9_UFLOAT_PACK32`). Values are multiplied by `scale`, and clamped to
/// [0, 65408]; NaN becomes 0.
pub fn rgb9e5(picture: &[[f32; 3]], scale: f64) -> String {
    let words = picture.iter().map(|pixel| {
        let pixel = pixel.map(|v| (f64::from(v) * scale).clamp(0.0, 65_408.0));
        packed(pixel.map(|v| if v.is_nan() { 0.0 } else { v }))
    });
    STANDARD.encode(words.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())
}

fn packed(pixel: [f64; 3]) -> u32 {
    let largest = pixel.iter().copied().fold(0.0, f64::max);
    let lowest = -EXPONENT_BIAS - 1;
    let exponent = |largest: f64| (largest.log2().floor() as i32).max(lowest) + 1 + EXPONENT_BIAS;
    let step = |exponent: i32| f64::from(exponent - EXPONENT_BIAS - MANTISSA_BITS).exp2();
    let mut shared = exponent(largest);
    // Rounding can carry the largest mantissa over.
    if (largest / step(shared)).round() >= 512.0 {
        shared += 1;
    }
    let [r, g, b] = pixel.map(|v| (v / step(shared)).round() as u32);
    r | g << 9 | b << 18 | (shared as u32) << 27
}

/// Encodes a map as base64 text with one byte per pixel: 0 stands for 0, and 255 for `most`. Values outside
/// of [0, `most`] are clamped.
pub fn bytes(values: &[f32], most: f32) -> String {
    let byte = |v: &f32| (255.0 * (v / most).clamp(0.0, 1.0)).round() as u8;
    STANDARD.encode(values.iter().map(byte).collect::<Vec<u8>>())
}

/// The exposure, in stops, with which a page first shows the picture: about the brightest 5 % of the pixels
/// become white. It is a multiple of 0.5 in [−30, 30], and 0 for a black picture.
pub fn exposure(picture: &[[f32; 3]]) -> f64 {
    let brightest = |p: &[f32; 3]| p.iter().copied().fold(0.0, f32::max);
    let mut values: Vec<f32> = picture.iter().map(brightest).collect();
    values.sort_by(f32::total_cmp);
    let white = values.get(values.len() * 19 / 20).copied().unwrap_or(0.0);
    if white > 0.0 {
        (-2.0 * f64::from(white).log2()).round().clamp(-60.0, 60.0) / 2.0
    } else {
        0.0
    }
}

/// The reduction of pictures to a smaller size: each pixel of the result is the mean of `factor` × `factor` pixels.
#[derive(Clone, Copy, Debug)]
pub struct Reduction {
    size: (usize, usize),
    /// The number of pixels along each axis that become one pixel; with 1, pictures stay as they are.
    pub factor: usize,
}

impl Reduction {
    /// The smallest reduction with which pictures of `size` (width, height) pixels have at most `most`
    /// pixels.
    pub fn to(size: (u32, u32), most: usize) -> Self {
        let size = (size.0 as usize, size.1 as usize);
        let mut reduction = Self { size, factor: 1 };
        while reduction.factor < size.0.max(size.1) && reduction.pixels() > most {
            reduction.factor += 1;
        }
        reduction
    }

    /// The width and the height of reduced pictures, in pixels; a rest at the right or lower edge becomes a
    /// pixel of its own.
    pub fn reduced_size(&self) -> (usize, usize) {
        let (width, height) = self.size;
        (width.div_ceil(self.factor), height.div_ceil(self.factor))
    }

    fn pixels(&self) -> usize {
        let (width, height) = self.reduced_size();
        width * height
    }

    /// Reduces a picture with N components per pixel, row by row: each pixel of the result is the mean of the
    /// pixels that it replaces.
    ///
    /// # Errors
    /// The number of entries of `pixels` is not the number of pixels of the size that this reduction was made
    /// for.
    pub fn apply<const N: usize>(&self, pixels: &[[f32; N]]) -> Result<Vec<[f32; N]>> {
        let (width, height) = self.size;
        if pixels.len() != width * height {
            return Err(Error::failed(format!(
                "a picture of the page has {} pixels instead of {width} × {height}",
                pixels.len()
            )));
        }
        if self.factor == 1 {
            return Ok(pixels.to_vec());
        }
        let (columns, rows) = self.reduced_size();
        let mut sums = vec![([0.0_f64; N], 0.0_f64); columns * rows];
        for (index, pixel) in pixels.iter().enumerate() {
            let (x, y) = (index % width / self.factor, index / width / self.factor);
            let (sum, count) = &mut sums[y * columns + x];
            for (sum, value) in sum.iter_mut().zip(pixel) {
                *sum += f64::from(*value);
            }
            *count += 1.0;
        }
        let mean = |(sum, count): &([f64; N], f64)| sum.map(|v| (v / count) as f32);
        Ok(sums.iter().map(mean).collect())
    }

    /// Reduces a map, which has one value per pixel, row by row, like [`Self::apply`].
    ///
    /// # Errors
    /// As for [`Self::apply`].
    pub fn apply_to_map(&self, values: &[f32]) -> Result<Vec<f32>> {
        let values: Vec<[f32; 1]> = values.iter().map(|v| [*v]).collect();
        Ok(self.apply(&values)?.into_iter().map(|[v]| v).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::Random;

    fn unpacked(word: u32) -> [f64; 3] {
        let step = f64::from((word >> 27) as i32 - EXPONENT_BIAS - MANTISSA_BITS).exp2();
        [0, 9, 18].map(|shift| f64::from(word >> shift & 511) * step)
    }

    #[test]
    fn rgb9e5_comes_back_within_half_a_step() {
        let mut random = Random::new(1);
        for _ in 0..10_000 {
            let scale = f64::from(random.between(-20.0, 15.9)).exp2();
            let pixel = [0, 1, 2].map(|_| scale * f64::from(random.unit()));
            let largest = pixel.iter().copied().fold(0.0, f64::max);
            let half_step = (largest / 512.0).max(f64::exp2(-25.0));
            for (a, b) in unpacked(packed(pixel)).iter().zip(pixel) {
                assert!((a - b).abs() <= half_step, "{pixel:?}");
            }
        }
        for exact in [[0.0; 3], [1.0, 0.5, 0.0], [65_408.0, 128.0, 0.0]] {
            assert_eq!(unpacked(packed(exact)), exact);
        }
    }

    #[test]
    fn values_without_a_code_are_clamped() {
        let text = rgb9e5(&[[f32::NAN, -1.0, f32::INFINITY]], 1.0);
        let bytes = STANDARD.decode(text).unwrap();
        let word = u32::from_le_bytes(bytes.try_into().unwrap());
        assert_eq!(unpacked(word), [0.0, 0.0, 65_408.0]);
        assert_eq!(
            STANDARD
                .decode(super::bytes(&[-1.0, 1.0, 9.0], 2.0))
                .unwrap(),
            [0, 128, 255]
        );
    }

    #[test]
    fn reduction_keeps_means_and_the_limit() {
        let picture: Vec<[f32; 3]> = (0..35).map(|i| [i as f32, 1.0, 0.0]).collect();
        let same = Reduction::to((7, 5), 35);
        assert_eq!(same.apply(&picture).unwrap(), picture);
        let half = Reduction::to((7, 5), 34);
        assert_eq!((half.factor, half.reduced_size()), (2, (4, 3)));
        let reduced = half.apply(&picture).unwrap();
        // Pixels 0, 1, 7 and 8; the last one is alone.
        assert_eq!(
            (reduced[0], reduced[11]),
            ([4.0, 1.0, 0.0], [34.0, 1.0, 0.0])
        );
        assert!(half.apply(&picture[1..]).is_err());
        assert_eq!(Reduction::to((3000, 2), 1).reduced_size(), (1, 1));
    }

    #[test]
    fn the_exposure_makes_the_brightest_part_white() {
        assert_eq!(exposure(&[[0.25; 3]; 100]), 2.0);
        assert_eq!(exposure(&[[0.0; 3]; 100]), 0.0);
        assert_eq!(exposure(&[[f32::INFINITY; 3]; 100]), -30.0);
        assert_eq!(exposure(&[]), 0.0);
    }
}
