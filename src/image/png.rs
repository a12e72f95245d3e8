//! PNG: the picture as a person sees it.

use super::Image;
use super::tonemap::{from_srgb, to_srgb_byte, tone_map};
use crate::files::write_atomically;
use crate::{Error, Result};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use std::path::Path;

/// Writes radiance × 2^`exposure`, tone-mapped.
pub(super) fn write(image: &Image, path: &Path, exposure: f32) -> Result<()> {
    let scale = f64::from(exposure).exp2();
    let bytes: Vec<u8> = image
        .rgb()?
        .iter()
        .flat_map(|pixel| tone_map(pixel.map(|v| (f64::from(v) * scale) as f32)))
        .map(to_srgb_byte)
        .collect();
    write_bytes(path, (image.width, image.height), &bytes)
}

/// Writes sRGB bytes, three a pixel, as they are.
pub(crate) fn write_bytes(path: &Path, size: (u32, u32), rgb: &[u8]) -> Result<()> {
    write_atomically(path, |file| {
        PngEncoder::new(file)
            .write_image(rgb, size.0, size.1, ExtendedColorType::Rgb8)
            .map_err(|e| match e {
                image::ImageError::IoError(e) => e,
                e => std::io::Error::other(e.to_string()),
            })
    })
}

/// Reads grey or RGB of any depth as linear values; alpha is left out.
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
    use image::{DynamicImage, Luma, LumaA, Rgb, Rgba};

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

    #[test]
    fn exposure_is_in_stops() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a.png", "b.png", "c.png"].map(|name| folder.path().join(name));
        let grey = |value: f32| {
            let mut image = Image::new(1, 1);
            image.set_vectors("", ["R", "G", "B"], &[[value; 3]]);
            image
        };
        grey(0.1).write(&paths[0], 2.0).unwrap();
        grey(0.4).write(&paths[1], 0.0).unwrap();
        let read = |path| std::fs::read(path).unwrap();
        assert_eq!(read(&paths[0]), read(&paths[1]));
        // Beyond all floats, black stays black and light is white.
        grey(0.0).write(&paths[2], 1e30).unwrap();
        assert_eq!(Image::read(&paths[2]).unwrap(), grey(0.0));
        grey(1e-9).write(&paths[2], 1e30).unwrap();
        assert_eq!(Image::read(&paths[2]).unwrap(), grey(1.0));
    }

    #[test]
    fn grey_and_sixteen_bits_and_alpha_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let (b, w) = (102_u8, 102_u16 * 257);
        let kinds: [DynamicImage; 8] = [
            image::ImageBuffer::from_pixel(2, 1, Luma([b])).into(),
            image::ImageBuffer::from_pixel(2, 1, LumaA([b, 9])).into(),
            image::ImageBuffer::from_pixel(2, 1, Rgb([b; 3])).into(),
            image::ImageBuffer::from_pixel(2, 1, Rgba([b, b, b, 9])).into(),
            image::ImageBuffer::from_pixel(2, 1, Luma([w])).into(),
            image::ImageBuffer::from_pixel(2, 1, LumaA([w, 9])).into(),
            image::ImageBuffer::from_pixel(2, 1, Rgb([w; 3])).into(),
            image::ImageBuffer::from_pixel(2, 1, Rgba([w, w, w, 9])).into(),
        ];
        for kind in kinds {
            kind.save(&path).unwrap();
            let pixels = Image::read(&path).unwrap().rgb().unwrap();
            assert_eq!(pixels.len(), 2);
            // 102/255 = 0.4 in sRGB.
            let value = ((0.4_f32 + 0.055) / 1.055).powf(2.4);
            assert!(
                pixels.iter().flatten().all(|v| (v - value).abs() < 1e-6),
                "{:?}: {pixels:?}",
                kind.color()
            );
        }
    }

    #[test]
    fn what_is_no_png_is_wrong_input() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for content in [&b""[..], b"no picture", b"\x89PNG\r\n\x1a\n"] {
            std::fs::write(&path, content).unwrap();
            let error = Image::read(&path).unwrap_err();
            assert_eq!(error.exit_status(), 2);
            assert!(error.to_string().contains("a.png"), "{error}");
            assert!(!error.to_string().contains('\n'), "{error}");
        }
    }
}
