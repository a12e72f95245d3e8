//! PNG files: writes the tone-mapped picture for viewing, and reads pictures as linear values.

use super::Image;
use super::tonemap::{Look, from_srgb, to_srgb_byte};
use crate::base::files::write_atomically;
use crate::base::panics::caught;
use crate::base::{input_files, memory};
use crate::{Error, Result};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use std::path::Path;

/// The highest compression ratio of deflate, the compression of PNG: one compressed byte can expand to 1032
/// bytes. A file that is too small for the pixels that its header describes is refused before memory is
/// allocated for them.
const MAX_COMPRESSION_RATIO: u64 = 1032;

/// The memory that [`read`] needs for each pixel, in bytes: three 16-bit values and twice three floats, whatever the file
/// has. A pixel of the file may have a single bit.
const BYTES_PER_PIXEL: u64 = 3 * 2 + 2 * 3 * 4;

/// Writes the channels `R`, `G`, `B` as 8-bit sRGB to the file at `path`, with the exposure and the curve of `look`. If there
/// is a channel `A`, the file has it with 8 bits, and the colours are divided by it, as the format demands.
pub(super) fn write(image: &Image, path: &Path, look: Look) -> Result<()> {
    let scale = f64::from(look.exposure).exp2();
    let shown = |pixel: &[f32; 3], scale: f64| {
        let scaled = pixel.map(|v| (f64::from(v) * scale) as f32);
        look.curve.map(scaled).map(to_srgb_byte)
    };
    let colors = image.rgb()?;
    let size = (image.width, image.height);
    let Some(alpha) = image.floats("A") else {
        let bytes: Vec<u8> = colors.iter().flat_map(|c| shown(c, scale)).collect();
        return write_bytes(path, size, &bytes);
    };
    let with_alpha = |(color, alpha): (&[f32; 3], &f32)| {
        // Where nothing covers the pixel, it has no colour.
        let [r, g, b] = match *alpha > 0.0 {
            true => shown(color, scale / f64::from(*alpha)),
            false => [0; 3],
        };
        // Alpha is linear: the curve and the sRGB encoding are for colours.
        [r, g, b, (alpha.clamp(0.0, 1.0) * 255.0).round() as u8]
    };
    let bytes: Vec<u8> = colors.iter().zip(alpha).flat_map(with_alpha).collect();
    encode(path, size, &bytes, ExtendedColorType::Rgba8)
}

/// Writes a PNG file of values that are 8-bit sRGB already. `rgb` has three bytes per pixel, row by row from the top; `size`
/// is the width and the height in pixels.
pub(crate) fn write_bytes(path: &Path, size: (u32, u32), rgb: &[u8]) -> Result<()> {
    encode(path, size, rgb, ExtendedColorType::Rgb8)
}

fn encode(path: &Path, size: (u32, u32), bytes: &[u8], kind: ExtendedColorType) -> Result<()> {
    write_atomically(path, |file| {
        PngEncoder::new(file)
            .write_image(bytes, size.0, size.1, kind)
            .map_err(|e| match e {
                image::ImageError::IoError(e) => e,
                e => std::io::Error::other(e.to_string()),
            })
    })
}

/// Reads a grey, RGB or palette picture of any bit depth as linear channels `R`, `G`, `B`, which have values
/// in [0, 1]. Alpha is ignored. A file that is damaged, or too large for the memory, gives an error.
pub(super) fn read(path: &Path) -> Result<Image> {
    let bytes = input_files::read(path)?;
    // The decoder allocates the size in the header, which may be damaged.
    let claimed = Claim::of(&bytes).unwrap_or_default();
    if claimed.bytes / MAX_COMPRESSION_RATIO > bytes.len() as u64 {
        return Err(Error::reading(
            path,
            "it claims more pixels than it can hold; is it a complete PNG?",
        ));
    }
    let needed = claimed.pixels.saturating_mul(BYTES_PER_PIXEL);
    memory::check(needed).map_err(|cause| Error::reading(path, cause))?;
    let decode = || image::load_from_memory_with_format(&bytes, image::ImageFormat::Png);
    let decoded = caught(decode)
        .ok_or_else(|| Error::reading(path, "it is damaged; is it a complete PNG?"))?
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

/// The size that the header of a PNG file states. [`read`] refuses a file for which it is too large.
#[derive(Debug, Default, PartialEq)]
struct Claim {
    /// The number of pixels.
    pixels: u64,
    /// The number of bytes of the uncompressed pixels in the file.
    bytes: u64,
}

impl Claim {
    /// Reads the header of the PNG file with the content `file`. The result is `None` if the file is too short for a header;
    /// the decoder rejects such a file later.
    fn of(file: &[u8]) -> Option<Self> {
        let header = file.get(16..26)?;
        let number = |at: usize| {
            header[at..at + 4]
                .iter()
                .fold(0, |n, b| n << 8 | u64::from(*b))
        };
        let channels = match header[9] {
            2 => 3,
            4 => 2,
            6 => 4,
            _ => 1,
        };
        let [width, height] = [number(0), number(4)];
        let row = width * channels * u64::from(header[8]) / 8;
        Some(Self {
            pixels: width.saturating_mul(height),
            bytes: row.saturating_mul(height),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Samples, ToneCurve};
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
    fn a_png_has_colours_that_are_not_multiplied_by_alpha() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let mut image = Image::new(4, 1);
        let half = [0.2, 0.1, 0.05];
        let colors = [half, half, [0.0; 3], [0.3; 3]];
        image.set_vectors("", ["R", "G", "B"], &colors);
        let alpha = vec![0.5, 1.0, 0.0, 0.25];
        image.channels.insert("A".into(), Samples::F32(alpha));
        image.write(&path, 1.0).unwrap();
        let read = image::open(&path).unwrap().into_rgba8();
        // One stop brighter, and divided by alpha, by the neutral curve, which changes the last one only.
        let shown = |color: [f32; 3]| ToneCurve::Neutral.map(color).map(to_srgb_byte);
        let expected = [[0.8, 0.4, 0.2], [0.4, 0.2, 0.1], [0.0; 3], [2.4; 3]].map(shown);
        for ((pixel, [r, g, b]), alpha) in read.pixels().zip(expected).zip([128, 255, 0, 64]) {
            assert_eq!(pixel.0, [r, g, b, alpha]);
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
            refused(&path, content);
        }
    }

    /// A PNG file with one row of two pixels, which are indices into a palette of `length` bytes.
    fn with_palette(length: usize) -> Vec<u8> {
        let row = [0, 0b0100_0000];
        // Stored without compression, with its checksum (Adler-32).
        let (mut a, mut b) = (1_u32, 0_u32);
        for byte in row {
            a += u32::from(byte);
            b += a;
        }
        let data = [
            &[0x78, 1, 1, 2, 0, 0xFD, 0xFF][..],
            &row,
            &(b << 16 | a).to_be_bytes(),
        ]
        .concat();
        let header = [0, 0, 0, 2, 0, 0, 0, 1, 1, 3, 0, 0, 0];
        let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
        let chunks: [(&[u8; 4], &[u8]); 4] = [
            (b"IHDR", &header),
            (b"PLTE", &vec![9; length]),
            (b"IDAT", &data),
            (b"IEND", &[]),
        ];
        for (kind, data) in chunks {
            let named = [&kind[..], data].concat();
            file.extend((data.len() as u32).to_be_bytes());
            file.extend(&named);
            file.extend(crc32fast::hash(&named).to_be_bytes());
        }
        file
    }

    /// Files with a palette of any length are read, or refused with an error. The decoder of the library panics if the
    /// length is not a multiple of three bytes, as fuzzing found; [`read`] must return an error instead.
    #[test]
    fn palettes_of_any_length_are_read_or_refused_in_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for length in 1..800 {
            let bytes = with_palette(length);
            if length % 3 == 0 && length <= 768 {
                std::fs::write(&path, bytes).unwrap();
                assert_eq!(Image::read(&path).unwrap().pixels(), 2);
            } else {
                refused(&path, &bytes);
            }
        }
    }

    /// Writes `bytes` to `path`, checks that reading them fails as wrong input with a message of one line, and returns the
    /// message.
    fn refused(path: &Path, bytes: &[u8]) -> String {
        std::fs::write(path, bytes).unwrap();
        let error = Image::read(path).unwrap_err();
        assert_eq!(error.exit_status(), 2);
        let line = error.to_string();
        assert!(line.contains("a.png") && !line.contains('\n'), "{line}");
        line
    }

    fn written(path: &Path) -> Vec<u8> {
        let mut image = Image::new(9, 7);
        image.set_vectors("", ["R", "G", "B"], &[[0.1, 0.2, 0.3]; 63]);
        image.write(path, 0.0).unwrap();
        std::fs::read(path).unwrap()
    }

    #[test]
    fn no_file_that_was_cut_short_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let good = written(&path);
        // The last twelve bytes only mark the end of the file.
        for length in 0..good.len() - 12 {
            refused(&path, &good[..length]);
        }
    }

    #[test]
    fn a_small_file_that_claims_a_large_picture_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let good = written(&path);
        for (width, height) in [
            (9, 100_000),
            (100_000, 7),
            (20_000, 20_000),
            (u32::MAX, u32::MAX),
        ] {
            let mut bad = good.clone();
            bad[16..20].copy_from_slice(&u32::to_be_bytes(width));
            bad[20..24].copy_from_slice(&u32::to_be_bytes(height));
            let line = refused(&path, &bad);
            assert!(line.contains("claims more"), "{width} {height}: {line}");
        }
    }

    #[test]
    fn the_memory_for_few_bits_per_pixel_is_that_for_their_pixels() {
        let mut file = with_palette(6);
        file[16..20].copy_from_slice(&u32::to_be_bytes(1 << 20));
        file[20..24].copy_from_slice(&u32::to_be_bytes(1 << 10));
        // One bit per pixel.
        let (pixels, bytes) = (1 << 30, 1 << 27);
        assert_eq!(Claim::of(&file), Some(Claim { pixels, bytes }));
        assert_eq!(BYTES_PER_PIXEL * pixels, 30 << 30);
    }

    #[test]
    fn the_densest_picture_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let mut image = Image::new(2000, 2000);
        image.set_vectors("", ["R", "G", "B"], &vec![[0.0; 3]; image.pixels()]);
        image.write(&path, 0.0).unwrap();
        assert_eq!(Image::read(&path).unwrap(), image);
    }
}
