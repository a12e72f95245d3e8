//! Opens environments by name: `.exr` and `.hdr` files, and skies that are generated from parameters.

use super::surroundings::NO_ENVIRONMENT;
use crate::base::panics::caught;
use crate::base::{input_files, memory};
use crate::scene::Environment;
use crate::scene::environment::{MAX_TEXELS, sky};
use crate::{Error, Result, image};
use ::image::{ImageDecoder, ImageReader};
use glam::Vec3;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek};
use std::path::Path;
use std::sync::Arc;

/// The maximum length of the header of an `.hdr` file, in bytes (64 KiB). A file with a longer header is refused. Without
/// this limit, a damaged file whose header never ends would be searched to its end.
const MAX_HEADER: u64 = 1 << 16;

impl Environment {
    /// Reads the environment from the file at the path `name` (`.exr` or `.hdr`). If `name` is `sky` or `sky:KEY=VALUE,…`,
    /// generates the sky with these parameters instead; `neutral` is [`Environment::neutral`].
    ///
    /// # Errors
    /// The file cannot be read, has another extension, is damaged, or has too many texels for the limit or the memory; a
    /// radiance is not a number or out of range; or a parameter of the sky is wrong.
    pub fn open(name: &str) -> Result<Self> {
        let mut environment = match name.split_once(':') {
            Some(("sky", parameters)) => sky::generate(parameters)?,
            _ if name == "sky" => sky::generate("")?,
            _ if name == "neutral" => Self::neutral(),
            _ => read(Path::new(name))?,
        };
        environment.name = name.to_owned();
        environment.check()?;
        Ok(environment)
    }

    /// Checks, before long work begins, that [`Environment::open`] can probably open the environment `name`: the file
    /// exists, or the parameters of the sky are valid. The content of the file is not read.
    ///
    /// # Errors
    /// There is no plain file at this path, or a parameter of the sky is wrong.
    pub fn check_name(name: &str) -> Result<()> {
        match environment_file_of(name) {
            None if name == "neutral" || name == NO_ENVIRONMENT => Ok(()),
            None => sky::parse(name.strip_prefix("sky").unwrap_or_default()).map(drop),
            Some(path) => input_files::check(path),
        }
    }
}

/// The path of the file from which the environment `name` is read. `None` for `sky` and `sky:…`, which are
/// generated without a file. Commands refuse an output with this path, because it would overwrite the
/// environment.
pub fn environment_file_of(name: &str) -> Option<&Path> {
    let generated = matches!(name, "sky" | "neutral" | NO_ENVIRONMENT) || name.starts_with("sky:");
    (!generated).then(|| Path::new(name))
}

fn read(path: &Path) -> Result<Environment> {
    let extension = path.extension().map(|e| e.to_ascii_lowercase());
    let (width, height, texels) = match extension.as_deref().and_then(|e| e.to_str()) {
        Some("exr") => {
            let picture = image::Image::read(path)?;
            let texels = picture.rgb().map_err(|e| Error::reading(path, e))?;
            let texels = texels.into_iter().map(Vec3::from_array).collect();
            (picture.width, picture.height, texels)
        }
        Some("hdr") => read_hdr(path)?,
        _ => {
            return Err(Error::input(format!(
                "{}: is not an environment file; give an .exr or .hdr file, sky:sun=40, neutral or none",
                path.display()
            )));
        }
    };
    Ok(Environment {
        name: String::new(),
        width,
        height,
        texels,
        rotation: 0.0,
        intensity: 1.0,
    })
}

/// Checks that the header of an `.hdr` file ends within its first [`MAX_HEADER`] bytes, and moves back to the start of the
/// file. The header ends with the line that follows an empty line. Without this check, the decoder would search the whole
/// file for that line.
fn check_hdr_header(file: &mut BufReader<File>) -> std::io::Result<()> {
    let mut start = Vec::new();
    file.by_ref().take(MAX_HEADER).read_to_end(&mut start)?;
    let mut lines = start.split_inclusive(|byte| *byte == b'\n');
    let ends = lines.any(|line| line == b"\n") && lines.any(|line| line.ends_with(b"\n"));
    if !ends {
        let text =
            format!("its header does not end within {MAX_HEADER} bytes; is it a complete HDR?");
        return Err(std::io::Error::new(ErrorKind::InvalidData, text));
    }
    file.rewind()
}

fn read_hdr(path: &Path) -> Result<(u32, u32, Arc<[Vec3]>)> {
    // The decoder may panic on damaged data.
    caught(|| decode_hdr(path)).unwrap_or_else(|| {
        let text = "it is damaged; is it a complete HDR?";
        Err(Error::reading(path, text))
    })
}

fn decode_hdr(path: &Path) -> Result<(u32, u32, Arc<[Vec3]>)> {
    let damaged = |cause: ::image::ImageError| {
        let cause = cause.to_string().replace('\n', " ");
        Error::reading(path, format!("{cause}; export it again"))
    };
    let file = input_files::open(path).map_err(|e| Error::reading(path, e))?;
    let mut file = BufReader::new(file);
    check_hdr_header(&mut file).map_err(|e| Error::reading(path, e))?;
    let mut reader = ImageReader::new(file);
    reader.set_format(::image::ImageFormat::Hdr);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > MAX_TEXELS {
        return Err(Error::reading(
            path,
            format!("has {width} × {height} texels, the most are {MAX_TEXELS}; scale it"),
        ));
    }
    // The texels exist twice for a moment: as the decoder's picture, and as the copy made from it.
    const BYTES: u64 = 2 * size_of::<Vec3>() as u64;
    memory::check(BYTES * u64::from(width) * u64::from(height))
        .map_err(|cause| Error::reading(path, cause))?;
    let decoded = ::image::DynamicImage::from_decoder(decoder).map_err(damaged)?;
    let texels = decoded.into_rgb32f();
    let texels = texels.pixels().map(|p| Vec3::from_array(p.0)).collect();
    Ok((width, height, texels))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_without_an_end_is_not_read_to_the_end_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.hdr");
        for (text, bytes) in [("", 1 << 40), ("\n", 1 << 40), ("\n-Y 1", 20)] {
            std::fs::write(&path, format!("#?RADIANCE\n{text}")).unwrap();
            let file = File::options().write(true).open(&path).unwrap();
            file.set_len(bytes).unwrap();
            let message = Environment::open(path.to_str().unwrap()).unwrap_err();
            assert!(
                message.to_string().contains("header does not end"),
                "{message}"
            );
        }
    }
}
