//! FLIP: the difference that a viewer perceives when two pictures alternate (LDR-FLIP, Andersson et al. 2020).

use crate::image::tonemap::to_srgb_byte;
use nv_flip::FlipImageRgb8;

/// The resolution of the display that FLIP assumes, in pixels per degree of visual angle. It is the
/// resolution of a 4K display with a width of 0.7 m, seen from a distance of 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = nv_flip::DEFAULT_PIXELS_PER_DEGREE;

/// The result of a FLIP comparison of two pictures: their mean error as one number, and a picture that shows where they
/// differ.
pub struct Flip {
    /// The mean FLIP error over the pixels, in [0, 1]; 0 means equal pictures.
    pub mean: f64,
    /// The FLIP error of each pixel, in [0, 1], row by row from the top.
    pub errors: Vec<f32>,
    /// The FLIP error of each pixel as a colour of the map magma (black is 0, pale yellow is 1), for a picture of the
    /// errors. It has three sRGB bytes per pixel, row by row from the top.
    pub map: Vec<u8>,
}

/// Computes the FLIP error of `picture` against `reference`: the difference that a viewer sees, for each pixel, when the
/// two pictures alternate on a display with the resolution [`PIXELS_PER_DEGREE`]. 0 means no visible difference; 1 is the
/// largest one. Each picture has the linear RGB radiance of every pixel, row by row from the top. `size` is (width, height)
/// in pixels. Each picture is shown as radiance × 2^`exposure`, clamped to [0, 1] and encoded as 8-bit sRGB. There is no
/// tone curve, because it would hide errors in bright areas.
///
/// # Panics
/// A picture has fewer pixels than `size`.
pub fn flip(picture: &[[f32; 3]], reference: &[[f32; 3]], size: (u32, u32), exposure: f32) -> Flip {
    let scale = f64::from(exposure).exp2();
    let shown = |pixels: &[[f32; 3]]| {
        let bytes: Vec<u8> = pixels
            .iter()
            .flatten()
            .map(|v| to_srgb_byte((f64::from(*v) * scale) as f32))
            .collect();
        FlipImageRgb8::with_data(size.0, size.1, &bytes)
    };
    let errors = nv_flip::flip(shown(reference), shown(picture), PIXELS_PER_DEGREE);
    // Not FlipPool's mean, which sums in 32 bits and loses precision on large pictures.
    let values = errors.to_vec();
    let sum: f64 = values.iter().copied().map(f64::from).sum();
    Flip {
        mean: sum / values.len().max(1) as f64,
        map: errors.apply_color_lut(&nv_flip::magma_lut()).to_vec(),
        errors: values,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_have_none_and_black_differs_from_white() {
        let grey = |v: f32| vec![[v; 3]; 32 * 32];
        let mean = |a: f32, b: f32| flip(&grey(a), &grey(b), (32, 32), 0.0).mean;
        assert_eq!(mean(0.4, 0.4), 0.0);
        assert!(mean(0.0, 1.0) > 0.9);
        assert!(mean(0.4, 0.5) < mean(0.4, 0.8));
    }

    #[test]
    fn the_map_says_where() {
        let grey = vec![[0.2; 3]; 64 * 64];
        let mut spot = grey.clone();
        spot[8 * 64 + 50] = [1.0, 0.0, 0.0];
        let map = flip(&spot, &grey, (64, 64), 0.0).map;
        assert_eq!(map.len(), 3 * 64 * 64);
        let red = |pixel: usize| map[3 * pixel];
        assert!(red(8 * 64 + 50) > 50);
        assert!(red(60 * 64 + 5) < 5);
    }

    #[test]
    fn exposure_brings_dark_differences_out_and_one_pixel_is_enough() {
        let mean = |a: f32, b: f32, ev: f32| flip(&[[a; 3]], &[[b; 3]], (1, 1), ev).mean;
        assert!(mean(0.001, 0.002, 6.0) > 2.0 * mean(0.001, 0.002, 0.0));
        assert_eq!(mean(0.0, 0.0, f32::MAX), 0.0);
    }
}
