//! OpenEXR: one part, 32-bit channels, losslessly compressed.

use super::{Image, Samples};
use crate::Error;
use crate::files::write_atomically;
use ::exr::prelude::*;
use std::io::Cursor;
use std::panic::catch_unwind;
use std::path::Path;

/// The attribute that holds the metadata, as JSON.
const METADATA: &str = "headwater";

/// Largest picture that is read, in pixels: a damaged header must not ask for all memory.
const MOST_PIXELS: usize = 1 << 30;

pub(super) fn write(image: &Image, path: &Path) -> crate::Result<()> {
    let size = (image.width as usize, image.height as usize);
    // The map's order is the order by name that the format wants.
    let channels = image
        .channels
        .iter()
        .map(|(name, samples)| {
            let samples = match samples {
                Samples::F32(values) => FlatSamples::F32(values.clone()),
                Samples::U32(values) => FlatSamples::U32(values.clone()),
            };
            AnyChannel::new(name.as_str(), samples)
        })
        .collect();
    let mut attributes = LayerAttributes::default();
    if !image.metadata.is_empty() {
        // One attribute: the library keeps several in an order that changes from run to run.
        let text = serde_json::to_string(&image.metadata).map_err(|e| Error::writing(path, e))?;
        let value = AttributeValue::Text(text.as_str().into());
        attributes.other.insert(METADATA.into(), value);
    }
    let layer = Layer::new(
        size,
        attributes,
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels),
    );
    write_atomically(path, |file| {
        Image_::from_layer(layer)
            .write()
            .to_buffered(file)
            .map_err(|e| match e {
                ::exr::error::Error::Io(e) => e,
                e => std::io::Error::other(e.to_string()),
            })
    })
}

type Image_<L> = ::exr::image::Image<L>;

pub(super) fn read(path: &Path) -> crate::Result<Image> {
    let bytes = std::fs::read(path).map_err(|e| Error::reading(path, e))?;
    // The decoder has been seen to panic on damaged files; that must reach nobody.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let decoded = catch_unwind(|| decode(&bytes));
    std::panic::set_hook(hook);
    match decoded {
        Ok(Ok(image)) => Ok(image),
        Ok(Err(e)) => Err(Error::reading(path, format!("{e}; is it a complete EXR?"))),
        Err(_) => Err(Error::reading(path, "it is damaged; is it a complete EXR?")),
    }
}

fn decode(bytes: &[u8]) -> std::result::Result<Image, String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(|e| e.to_string())?;
    let pixels = meta.headers.iter().map(|h| h.layer_size.area());
    if pixels.sum::<usize>() > MOST_PIXELS {
        return Err("it claims to be larger than any picture Headwater reads".into());
    }
    let file = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let layer = file.layer_data;
    let mut image = Image::new(layer.size.x() as u32, layer.size.y() as u32);
    for channel in layer.channel_data.list {
        let samples = match channel.sample_data {
            FlatSamples::F16(values) => Samples::F32(values.into_iter().map(f32::from).collect()),
            FlatSamples::F32(values) => Samples::F32(values),
            FlatSamples::U32(values) => Samples::U32(values),
        };
        image.channels.insert(channel.name.to_string(), samples);
    }
    if let Some(AttributeValue::Text(text)) = layer.attributes.other.get(&Text::from(METADATA)) {
        image.metadata = serde_json::from_str(&text.to_string()).unwrap_or_default();
    }
    Ok(image)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            ("x", "é"),
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
    fn damaged_files_are_errors_and_never_panics() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        sample().write(&path, 0.0).unwrap();
        let good = std::fs::read(&path).unwrap();
        let mut state = 1_u64;
        for round in 0..400 {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            let at = (state >> 33) as usize % good.len();
            let mut bad = good.clone();
            if round % 3 == 0 {
                bad.truncate(at);
            } else {
                bad[at] ^= 1 << (state >> 20 & 7);
            }
            std::fs::write(&path, bad).unwrap();
            if let Err(e) = Image::read(&path) {
                assert_eq!(e.exit_status(), 2);
                assert!(!e.to_string().contains('\n'));
            }
        }
    }
}
