//! FLIP: the difference that a person notices when flipping between two pictures (Andersson et al.
//! 2020, for displays of limited range).

use crate::image::png::to_srgb;
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8};

/// The outcome of a comparison.
pub struct Flip {
    /// Mean over the pixels, 0…1.
    pub mean: f64,
    /// The error of each pixel in the colours of magma, three bytes a pixel.
    pub map: Vec<u8>,
}

/// Compares two pictures at 67 pixels a degree. Both are shown as radiance × 2^`exposure`, clamped
/// to 0…1, sRGB, 8 bits: no tone curve, which would hide errors in the light.
pub fn flip(picture: &[[f32; 3]], reference: &[[f32; 3]], size: (u32, u32), exposure: f32) -> Flip {
    let shown = |pixels: &[[f32; 3]]| {
        let bytes: Vec<u8> = pixels
            .iter()
            .flatten()
            .map(|v| (to_srgb((v * exposure.exp2()).clamp(0.0, 1.0)) * 255.0).round() as u8)
            .collect();
        FlipImageRgb8::with_data(size.0, size.1, &bytes)
    };
    let errors = nv_flip::flip(shown(reference), shown(picture), DEFAULT_PIXELS_PER_DEGREE);
    // Not FlipPool's mean: it sums in 32 bits, which large pictures outgrow.
    let values = errors.to_vec();
    let sum: f64 = values.iter().copied().map(f64::from).sum();
    Flip {
        mean: sum / values.len().max(1) as f64,
        map: errors.apply_color_lut(&nv_flip::magma_lut()).to_vec(),
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
}
