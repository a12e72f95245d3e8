//! Reads OpenEXR files. The picture is the display window of the file. The data window of a part may be smaller than the
//! display window, larger, or shifted against it: pixels of the display window without data are 0, and data outside of the
//! display window are dropped.

use super::METADATA;
use crate::Error;
use crate::base::panics::caught;
use crate::base::{input_files, memory};
use crate::image::layers::is_main;
use crate::image::{Image, Samples};
use ::exr::block::lines::LineRef;
use ::exr::block::reader::ChunksReader;
use ::exr::io::Data;
use ::exr::meta::header::Header;
use ::exr::prelude::*;
use std::io::Cursor;
use std::path::Path;

/// The maximum number of pixels (width × height) of a picture that is read. A file whose header states more is refused,
/// because its picture would need many gigabytes of memory.
const MAX_PIXELS: usize = 1 << 30;

/// Upper bound on the compression ratio of an EXR file: the number of uncompressed bytes per byte of the file. If a file
/// would need a higher ratio for the picture that its header describes, it is refused before memory is allocated. Deflate
/// reaches 1032; PXR24 reaches 4/3 of that, because it first drops one of four bytes. RLE, PIZ and B44 stay below.
const MAX_COMPRESSION_RATIO: usize = 1400;

/// The maximum number of bytes of a picture whose display window is much larger than its data windows: 512 MiB. Without it,
/// a file of a few bytes could state a display window that fills the memory.
const MAX_BLANK: u64 = 512 << 20;

/// Reads the EXR file at `path`. In a file with several parts, the names of channels begin with the name of their part, as
/// in `beauty.R`, except for those of the first part if no part has a name that [`is_main`] accepts. Parts with deep data
/// are left out.
pub(in crate::image) fn read(path: &Path) -> crate::Result<Image> {
    let bytes = input_files::read(path)?;
    // The decoder can panic on damaged files; a panic must become an error.
    match caught(|| decode(&bytes)) {
        Some(Ok(image)) => Ok(image),
        Some(Err(e)) => Err(Error::reading(path, e)),
        None => Err(Error::reading(path, "it is damaged; is it a complete EXR?")),
    }
}

fn decode(bytes: &[u8]) -> std::result::Result<Image, String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(described)?;
    for header in &meta.headers {
        check_header(header, bytes.len())?;
    }
    let first = (meta.headers.iter().find(|header| !header.deep))
        .ok_or("it has only deep data, which Headwater does not read; save it as a flat picture")?;
    let display = first.shared_attributes.display_window;
    check_display(display.size, &meta.headers)?;
    let mut image = Image::new(display.size.x() as u32, display.size.y() as u32);
    // For each part, its channels in the order of the file.
    let mut parts = named_channels(&meta.headers, image.pixels());
    ::exr::block::read(Cursor::new(bytes), true)
        .map_err(described)?
        // Without `pedantic` (true), a damaged table of chunks leaves black lines and no error.
        .filter_chunks(true, |meta, tile, block| {
            !meta.headers[block.layer].deep && tile.level_index == Vec2(0, 0)
        })
        .map_err(described)?
        // A panic in one of the library's threads would end the process.
        .decompress_sequential(true, |meta, block| {
            let part = block.index.layer;
            let header = &meta.headers[part];
            let corner = header.own_attributes.layer_position;
            let shift = [
                i64::from(corner.x()) - i64::from(display.position.x()),
                i64::from(corner.y()) - i64::from(display.position.y()),
            ];
            for line in block.lines(&header.channels) {
                let channel = line.location.channel;
                let (_, samples) = &mut parts[part][channel];
                match (samples, header.channels.list[channel].sample_type) {
                    (Samples::U32(values), _) => place::<u32, _>(line, shift, &image, values)?,
                    (Samples::F32(values), SampleType::F16) => {
                        place::<f16, _>(line, shift, &image, values)?;
                    }
                    (Samples::F32(values), _) => place::<f32, _>(line, shift, &image, values)?,
                }
            }
            Ok(())
        })
        .map_err(described)?;
    image.channels = parts.into_iter().flatten().collect();
    let metadata = first.own_attributes.other.get(&Text::from(METADATA));
    if let Some(AttributeValue::Text(text)) = metadata {
        image.metadata = serde_json::from_str(&string(text)).unwrap_or_default();
    }
    Ok(image)
}

/// The text of an error of the decoder, with advice.
fn described(error: ::exr::error::Error) -> String {
    let text = error.to_string();
    if text.contains("sampling") {
        // Luminance and chroma (`Y`, `RY`, `BY`) are stored so.
        return "it has subsampled channels, which Headwater does not read; save it as RGB".into();
    }
    format!("{text}; is it a complete EXR?")
}

/// Decodes text from an EXR header as UTF-8 or, if it is not UTF-8, as Latin-1.
fn string(text: &Text) -> String {
    std::str::from_utf8(text.as_slice()).map_or_else(|_| text.to_string(), str::to_owned)
}

/// For each part, the names of its channels as [`read()`] describes them, with `pixels` samples of 0 each. Parts with deep
/// data get no channels.
fn named_channels(headers: &[Header], pixels: usize) -> Vec<Vec<(String, Samples)>> {
    let part_name = |header: &Header| header.own_attributes.layer_name.as_ref().map(string);
    let has_main = |header| part_name(header).is_some_and(|name| is_main(&name));
    let names_first = headers.len() > 1 && headers.iter().any(has_main);
    let of_part = |(index, header): (usize, &Header)| {
        let part = part_name(header).filter(|_| index > 0 || names_first);
        let prefix = part.map_or_else(String::new, |part| part + ".");
        let flat = header.channels.list.iter().filter(|_| !header.deep);
        let named = flat.map(|channel| {
            let name = string(&channel.name);
            let samples = match channel.sample_type {
                SampleType::U32 => Samples::U32(vec![0; pixels]),
                SampleType::F16 | SampleType::F32 => Samples::F32(vec![0.0; pixels]),
            };
            match name.starts_with(&prefix) {
                true => (name, samples),
                false => (prefix.clone() + &name, samples),
            }
        });
        named.collect()
    };
    headers.iter().enumerate().map(of_part).collect()
}

/// Copies the samples of `line` that are within the picture into `values`, the samples of a channel of `image`. `shift` is
/// the position of the part's data window relative to the display window, in pixels to the right and down.
fn place<T: Data + Copy + Default, V: From<T>>(
    line: LineRef<'_>,
    shift: [i64; 2],
    image: &Image,
    values: &mut [V],
) -> ::exr::error::UnitResult {
    let mut samples = vec![T::default(); line.location.sample_count];
    line.read_samples_into_slice(&mut samples)?;
    let width = image.width as usize;
    let [left, top] = [line.location.position.x(), line.location.position.y()];
    let (left, top) = (left as i64 + shift[0], top as i64 + shift[1]);
    let row = usize::try_from(top).ok();
    if let Some(row) = row.and_then(|row| values.chunks_exact_mut(width).nth(row)) {
        let pixels = row.iter_mut().skip(left.max(0) as usize);
        for (pixel, sample) in pixels.zip(samples.into_iter().skip((-left).max(0) as usize)) {
            *pixel = sample.into();
        }
    }
    Ok(())
}

/// Rejects a header that describes more data than a file of `file_bytes` bytes can hold, or more pixels than
/// [`MAX_PIXELS`]; so a damaged file does not exhaust memory. It also rejects DWA compression, which the decoder cannot read
/// safely. The error text is the reason; the caller puts it behind the path of the file in its message.
fn check_header(header: &Header, file_bytes: usize) -> std::result::Result<(), String> {
    // The decoder allocates the size in a DWA block, which may be damaged, and ends the process if
    // memory does not suffice.
    if matches!(
        header.compression,
        Compression::DWAA(_) | Compression::DWAB(_)
    ) {
        return Err(
            "it is compressed with DWA, which Headwater does not read; save it as ZIP".into(),
        );
    }
    let size = header.layer_size;
    let too_large = || {
        format!(
            "it claims {} × {} pixels in {} channels, more than it can hold or Headwater reads",
            size.x(),
            size.y(),
            header.channels.list.len()
        )
    };
    let pixels = size
        .x()
        .checked_mul(size.y())
        .filter(|pixels| *pixels <= MAX_PIXELS)
        .ok_or_else(too_large)?;
    let depth = |c: &ChannelDescription| c.sample_type.bytes_per_sample();
    let pixel_bytes: usize = header.channels.list.iter().map(depth).sum();
    let bytes = pixels.checked_mul(pixel_bytes).ok_or_else(too_large)?;
    // The file stores an offset of eight bytes per chunk.
    if header.chunk_count > file_bytes / 8 || bytes / MAX_COMPRESSION_RATIO > file_bytes {
        return Err(too_large());
    }
    Ok(())
}

/// Rejects a display window of `size` pixels if the picture would have more than [`MAX_PIXELS`] pixels, would be larger
/// than both [`MAX_BLANK`] and twice the data that the parts with these `headers` have, or would need more memory than
/// there is.
fn check_display(size: Vec2<usize>, headers: &[Header]) -> std::result::Result<(), String> {
    let channels: usize = headers.iter().map(|h| h.channels.list.len()).sum();
    let data = headers.iter().map(|header| {
        // Within the limits of `check_header`.
        4 * header.layer_size.area() as u64 * header.channels.list.len() as u64
    });
    let most = MAX_BLANK.max(2 * data.sum::<u64>());
    let bytes = (size.x().checked_mul(size.y()))
        .filter(|pixels| *pixels <= MAX_PIXELS)
        .map(|pixels| 4 * pixels as u64 * channels as u64)
        .filter(|bytes| *bytes <= most)
        .ok_or_else(|| {
            format!(
                "its display window has {} × {} pixels in {channels} channels, far more than it has data for; crop it",
                size.x(),
                size.y()
            )
        })?;
    // A failed allocation in the decoder would end the process. A block may be as large as the picture.
    memory::room_for(2 * bytes).map(drop)
}
