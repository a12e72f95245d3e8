//! OpenEXR files: writes pictures as one part with 32-bit channels, losslessly compressed, and reads pictures, also those of
//! other programs.

mod reading;

pub(super) use reading::read;

use super::{Image, Samples};
use crate::Error;
use crate::base::files::write_atomically;
use ::exr::prelude::*;
use std::path::Path;

/// Name of the attribute in the EXR header that holds the metadata of the picture, as one JSON object.
const METADATA: &str = "headwater";

pub(super) fn write(image: &Image, path: &Path) -> crate::Result<()> {
    let size = (image.width as usize, image.height as usize);
    let channels = image
        .channels
        .iter()
        .map(|(name, samples)| {
            let samples = match samples {
                Samples::F32(values) => FlatSamples::F32(values.clone()),
                Samples::U32(values) => FlatSamples::U32(values.clone()),
            };
            AnyChannel::new(utf8(name), samples)
        })
        .collect();
    let mut attributes = LayerAttributes::default();
    if !image.metadata.is_empty() {
        // One attribute for all: the library writes several in an order that differs between runs.
        let text = serde_json::to_string(&image.metadata).map_err(|e| Error::writing(path, e))?;
        let value = AttributeValue::Text(utf8(&text));
        attributes.other.insert(METADATA.into(), value);
    }
    let layer = Layer::new(
        size,
        attributes,
        // Lossless, with scan lines in increasing order whichever thread finishes first.
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels),
    );
    write_atomically(path, |file| {
        ::exr::image::Image::from_layer(layer)
            .write()
            .to_buffered(file)
            .map_err(|e| match e {
                ::exr::error::Error::Io(e) => e,
                e => std::io::Error::other(e.to_string()),
            })
    })
}

/// Converts a string to text for an EXR header, encoded as UTF-8. The library's own conversion panics on characters outside
/// Latin-1.
fn utf8(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::Random;

    fn sample() -> Image {
        let mut image = Image::new(3, 2);
        let values = [1e-30, 1e30, f32::MIN_POSITIVE / 4.0, 0.0, 0.1, 7.0].map(|v| [v, 2.0 * v, v]);
        image.set_vectors("", ["R", "G", "B"], &values);
        image.set_vectors("normal.", ["X", "Y", "Z"], &values);
        let ids = vec![0, 1, 2, u32::MAX, 4, 5];
        image
            .channels
            .insert("instance.id".into(), Samples::U32(ids));
        for (key, value) in [
            ("headwater.seed", "7"),
            ("headwater.scene", "\"a\""),
            ("x", "é, 木, ™"),
        ] {
            image.metadata.insert(key.into(), value.into());
        }
        image
    }

    #[test]
    fn what_is_written_is_read_and_equal_pictures_are_equal_files() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a.exr", "b.exr"].map(|name| folder.path().join(name));
        for path in &paths {
            sample().write(path, 0.0).unwrap();
        }
        assert_eq!(Image::read(&paths[0]).unwrap(), sample());
        assert_eq!(
            std::fs::read(&paths[0]).unwrap(),
            std::fs::read(&paths[1]).unwrap()
        );
    }

    #[test]
    fn many_blocks_compressed_by_many_threads_are_equal_files() {
        let mut random = Random::new(3);
        let (width, height) = (67, 301);
        let mut image = Image::new(width, height);
        let values: Vec<[f32; 3]> = (0..width * height)
            .map(|i| [random.unit() * 1e-6, i as f32, 0.0])
            .collect();
        image.set_vectors("", ["R", "G", "B"], &values);
        image.set_vectors("stderr.", ["R", "G", "B"], &values);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut files = std::collections::BTreeSet::new();
        for _ in 0..8 {
            image.write(&path, 0.0).unwrap();
            files.insert(std::fs::read(&path).unwrap());
        }
        assert_eq!(files.len(), 1);
        assert_eq!(Image::read(&path).unwrap(), image);
    }

    #[test]
    fn not_a_number_and_infinity_come_back_bit_by_bit() {
        let bits = [
            0x7fc0_0001,
            0xff80_0000,
            0x7f80_0000,
            0x8000_0000,
            1,
            0x7f7f_ffff,
        ];
        let mut image = Image::new(3, 2);
        let values = bits.map(f32::from_bits).to_vec();
        image
            .channels
            .insert("depth.Z".into(), Samples::F32(values));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        image.write(&path, 0.0).unwrap();
        let back = Image::read(&path).unwrap();
        let back: Vec<u32> = back
            .floats("depth.Z")
            .unwrap()
            .iter()
            .map(|v| v.to_bits())
            .collect();
        assert_eq!(back, bits);
    }

    #[test]
    fn half_floats_of_other_programs_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let pixel = |x: usize, y: usize| {
            let half = f16::from_f32(x as f32 + 0.5);
            (half, half, f16::from_f32(y as f32))
        };
        write_rgb_file(&path, 5, 3, pixel).unwrap();
        let image = Image::read(&path).unwrap();
        let pixels = image.rgb().unwrap();
        assert_eq!(pixels.len(), 15);
        assert_eq!(pixels[2 * 5 + 4], [4.5, 4.5, 2.0]);
    }

    const COMPRESSIONS: [Compression; 6] = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
    ];

    /// Writes an EXR file as other programs may write it: with this compression, and with this layout of blocks (scan lines
    /// or tiles). The picture has `size` (width, height) pixels. `value` returns the value of the pixel at (column, row),
    /// which all of `R`, `G` and `B` get.
    fn write_foreign(
        path: &Path,
        size: (usize, usize),
        compression: Compression,
        blocks: Blocks,
        value: fn(Vec2<usize>) -> f32,
    ) {
        let channels = SpecificChannels::rgb(|at| (value(at), value(at), value(at)));
        let encoding = Encoding {
            compression,
            blocks,
            line_order: LineOrder::Increasing,
        };
        let layer = Layer::new(size, LayerAttributes::default(), encoding, channels);
        ::exr::image::Image::from_layer(layer)
            .write()
            .to_file(path)
            .unwrap();
    }

    #[test]
    fn every_compression_is_read_where_it_is_densest() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for compression in COMPRESSIONS {
            write_foreign(&path, (256, 512), compression, Blocks::ScanLines, |_| 0.0);
            let pixels = Image::read(&path).unwrap().rgb().unwrap();
            assert_eq!(pixels, vec![[0.0; 3]; 256 * 512], "{compression:?}");
        }
    }

    #[test]
    fn dwa_is_refused_with_advice() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let compression = Compression::DWAA(None);
        write_foreign(&path, (8, 8), compression, Blocks::ScanLines, |_| 0.0);
        let error = Image::read(&path).unwrap_err();
        assert_eq!(error.exit_status(), 2);
        assert!(error.to_string().contains("save it as ZIP"), "{error}");
    }

    #[test]
    fn what_is_no_picture_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut short = Image::new(2, 2);
        short.set_vectors("", ["R", "G", "B"], &[[0.0; 3]]);
        for image in [Image::new(0, 0), Image::new(2, 2), short] {
            assert_eq!(image.write(&path, 0.0).unwrap_err().exit_status(), 1);
        }
        assert!(!path.exists());
    }

    /// Writes `bytes` to `path` and reads them as a picture. Returns true if this fails. Then it also checks that the error
    /// has the exit status of wrong input and a message of one line.
    fn fails(path: &Path, bytes: &[u8]) -> bool {
        std::fs::write(path, bytes).unwrap();
        match Image::read(path) {
            Ok(image) => {
                assert!(image.check().is_ok());
                false
            }
            Err(e) => {
                assert_eq!(e.exit_status(), 2);
                assert!(!e.to_string().contains('\n'), "{e}");
                assert!(e.to_string().contains("a.exr"), "{e}");
                true
            }
        }
    }

    #[test]
    fn no_file_that_was_cut_short_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        sample().write(&path, 0.0).unwrap();
        let good = std::fs::read(&path).unwrap();
        for length in 0..good.len() {
            assert!(fails(&path, &good[..length]), "{length} of {}", good.len());
        }
        assert!(!fails(&path, &good));
    }

    #[test]
    fn damaged_files_are_errors_and_never_panics() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        sample().write(&path, 0.0).unwrap();
        let mut whole = vec![std::fs::read(&path).unwrap()];
        for (i, compression) in COMPRESSIONS.into_iter().enumerate() {
            let blocks = match i % 2 {
                0 => Blocks::ScanLines,
                _ => Blocks::Tiles(Vec2(8, 8)),
            };
            write_foreign(&path, (17, 19), compression, blocks, |at| {
                (at.x() * at.y()) as f32
            });
            whole.push(std::fs::read(&path).unwrap());
        }
        let mut random = Random::new(1);
        let mut failed = 0;
        for good in whole.iter().cycle().take(2100) {
            let mut bad = good.clone();
            for _ in 0..=random.index(3) {
                // Half of the damage hits the header.
                let end = random.pick(&[bad.len(), bad.len().min(600)]);
                let at = random.index(end);
                match random.index(4) {
                    0 => bad[at] = random.bits() as u8,
                    1 => bad[at] ^= 1 << random.index(8),
                    2 => bad[at] = random.pick(&[0, 0x7f, 0x80, 0xff]),
                    _ => {
                        bad.remove(at);
                    }
                }
            }
            failed += u32::from(fails(&path, &bad));
        }
        assert!(failed > 500, "only {failed} of 2100 were noticed");
    }

    #[test]
    fn a_small_file_that_claims_a_large_picture_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        sample().write(&path, 0.0).unwrap();
        let good = std::fs::read(&path).unwrap();
        let name = b"dataWindow\0box2i\0";
        let at = good.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
        for (right, bottom) in [
            (99_999, 9),
            (9, 99_999),
            (40_000, 40_000),
            (i32::MAX, i32::MAX),
        ] {
            let mut bad = good.clone();
            bad[at + 8..at + 12].copy_from_slice(&i32::to_le_bytes(right));
            bad[at + 12..at + 16].copy_from_slice(&i32::to_le_bytes(bottom));
            assert!(fails(&path, &bad), "{right} {bottom}");
        }
    }
}
