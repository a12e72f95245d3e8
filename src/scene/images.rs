//! Image files of textures: reading and decoding, with limits on what a file may claim.

use super::load::Options;
use super::notices::{Tally, quoted};
use super::progress::{self, Progress};
use super::texture::Image;
use crate::{Error, Result};
use image::{ImageDecoder, ImageReader};
use std::io::{Cursor, ErrorKind};
use std::path::{Component, Path};

/// The largest width and height of an image, in texels.
pub const MAX_SIZE: u32 = 16384;

/// The bytes of an image file in the scene's folder; none if there is no such file.
///
/// # Errors
/// The file is outside of the folder, or cannot be read.
pub(super) fn read_file(
    what: &str,
    name: &str,
    folder: &Path,
    progress: &mut Progress<'_>,
) -> Result<Option<Vec<u8>>> {
    let wrong = |fault: &dyn std::fmt::Display| {
        Error::input(format!("{what}: cannot read {}: {fault}", quoted(name)))
    };
    // A scene from elsewhere must not show what else is on this machine.
    let inside = Path::new(name)
        .components()
        .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if !inside {
        return Err(wrong(
            &"it is outside of the scene's folder; copy it there and name it by its path from there",
        ));
    }
    let path = folder.join(name);
    match path.metadata() {
        Ok(found) => progress.expect(found.len()),
        Err(cause) if cause.kind() == ErrorKind::NotFound => return Ok(None),
        Err(cause) => return Err(wrong(&cause)),
    }
    progress::read_file(&path, u64::MAX, progress, wrong).map(Some)
}

/// What follows where an image file is missing: a notice if `options` permit it.
///
/// # Errors
/// They do not.
pub(super) fn missing(
    what: &str,
    name: Option<&str>,
    options: Options,
    tally: &mut Tally,
) -> Result<()> {
    let file = quoted(name.unwrap_or_default());
    if options.allow_missing {
        tally.add(
            "image files are missing, the plain factors are used",
            || format!("{file} ({what})"),
        );
        return Ok(());
    }
    Err(Error::input(format!(
        "{what}: there is no file {file} beside the scene; put it there, or render without it by --allow-missing"
    )))
}

/// An image from the bytes of a PNG, JPEG or WebP file.
///
/// # Errors
/// Another format, damaged data, or an image that is too large.
pub(super) fn decode(what: &str, name: &str, bytes: &[u8]) -> Result<Image> {
    let wrong = |fault: String| {
        let named = match name {
            "" => String::new(),
            name => format!(" ({})", quoted(name)),
        };
        Err(Error::input(format!("{what}{named}: {fault}")))
    };
    let damaged = |cause: image::ImageError| {
        let cause = cause.to_string().replace('\n', " ");
        wrong(format!("cannot be decoded: {cause}; export it again"))
    };
    let reader = match ImageReader::new(Cursor::new(bytes)).with_guessed_format() {
        Ok(reader) => reader,
        Err(cause) => return damaged(cause.into()),
    };
    if reader.format().is_none() {
        return wrong("is neither PNG, JPEG nor WebP; convert it to one of them".into());
    }
    let decoder = match reader.into_decoder() {
        Ok(decoder) => decoder,
        Err(cause) => return damaged(cause),
    };
    let (width, height) = decoder.dimensions();
    if width > MAX_SIZE || height > MAX_SIZE || width == 0 || height == 0 {
        return wrong(format!(
            "has {width} × {height} texels, it must be 1 to {MAX_SIZE} each way; scale it"
        ));
    }
    let decoded = match image::DynamicImage::from_decoder(decoder) {
        Ok(decoded) => decoded.into_rgba8(),
        Err(cause) => return damaged(cause),
    };
    let texels: &[[u8; 4]] = bytemuck::cast_slice(decoded.as_raw());
    Ok(Image {
        name: name.to_owned(),
        width,
        height,
        texels: texels.into(),
    })
}
