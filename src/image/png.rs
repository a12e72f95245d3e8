//! PNG: the picture as a person sees it.

use super::Image;
use crate::files::write_atomically;
use crate::{Error, Result};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use std::path::Path;

/// Where the tone curve leaves the straight line.
const KNEE: f32 = 0.8;

/// Radiance to display brightness, both linear. Up to the knee nothing changes, so that pictures
/// compare with other renderers; above it, brightness nears 1 as a hyperbola of the same slope, so
/// that lamps keep some shape.
pub fn tone_map(value: f32) -> f32 {
    if value <= KNEE {
        return value.max(0.0);
    }
    let over = (value - KNEE) / (1.0 - KNEE);
    if over.is_infinite() {
        return 1.0;
    }
    KNEE + (1.0 - KNEE) * (over / (1.0 + over))
}

/// Linear to sRGB (IEC 61966-2-1), 0…1.
pub(crate) fn to_srgb(value: f32) -> f32 {
    if value <= 0.003_130_8 {
        12.92 * value
    } else {
        1.055 * value.powf(1.0 / 2.4) - 0.055
    }
}

/// sRGB to linear, 0…1.
fn from_srgb(value: f32) -> f32 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

pub(super) fn write(image: &Image, path: &Path, exposure: f32) -> Result<()> {
    let scale = exposure.exp2();
    let bytes: Vec<u8> = image
        .rgb()?
        .iter()
        .flat_map(|pixel| pixel.map(|v| (to_srgb(tone_map(v * scale)) * 255.0).round() as u8))
        .collect();
    write_atomically(path, |file| {
        PngEncoder::new(file)
            .write_image(&bytes, image.width, image.height, ExtendedColorType::Rgb8)
            .map_err(|e| match e {
                image::ImageError::IoError(e) => e,
                e => std::io::Error::other(e.to_string()),
            })
    })
}

pub(super) fn read(path: &Path) -> Result<Image> {
    let bytes = std::fs::read(path).map_err(|e| Error::reading(path, e))?;
    let decoded = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png)
        .map_err(|e| Error::reading(path, format!("{e}; is it a complete PNG?")))?
        .into_rgb16();
    let mut picture = Image::new(decoded.width(), decoded.height());
    let values: Vec<[f32; 3]> = decoded
        .pixels()
        .map(|p| p.0.map(|v| from_srgb(f32::from(v) / 65535.0)))
        .collect();
    picture.set_vectors("", ["R", "G", "B"], &values);
    Ok(picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_rises_and_stays_below_one() {
        let values: Vec<f32> = (0..2000).map(|i| tone_map(i as f32 * 0.01)).collect();
        assert!(values.windows(2).all(|w| w[0] < w[1]));
        assert!(tone_map(f32::INFINITY) <= 1.0 && tone_map(1e30) <= 1.0);
        assert_eq!(tone_map(0.5), 0.5);
    }

    #[test]
    fn a_png_comes_back_within_its_eight_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let mut image = Image::new(2, 1);
        image.set_vectors("", ["R", "G", "B"], &[[0.0, 0.2, 0.5], [0.01, 0.7, 0.1]]);
        image.write(&path, 0.0).unwrap();
        let back = Image::read(&path).unwrap().rgb().unwrap();
        for (a, b) in back
            .iter()
            .flatten()
            .zip(image.rgb().unwrap().iter().flatten())
        {
            assert!((a - b).abs() < 0.006, "{a} {b}");
        }
    }
}
