//! Reads Radiance HDR files (`.hdr`). The `image` crate decodes the texels, but it accepts only one form of the
//! header. So this file reads the header, gives the decoder the form that it accepts, and then applies the header to the
//! decoded texels: exposure, colour space and orientation.

use crate::base::panics::caught;
use crate::base::{input_files, memory};
use crate::scene::environment::MAX_TEXELS;
use crate::scene::notices::quoted;
use crate::{Error, Result};
use ::image::codecs::hdr::HdrDecoder;
use ::image::{ImageDecoder, ImageError};
use glam::{Mat3, Vec3};
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

/// The maximum length of the header of an `.hdr` file, in bytes (64 KiB). A file with a longer header is refused. Without
/// this limit, a damaged file whose header never ends would be searched to its end.
const MAX_HEADER: u64 = 1 << 16;

/// The matrix from CIE XYZ to linear sRGB with the white point D65 (IEC 61966-2-1), for files with
/// `FORMAT=32-bit_rle_xyze`. Negative channels of colours outside of sRGB become 0.
const SRGB_OF_XYZ: Mat3 = Mat3::from_cols(
    Vec3::new(3.2406, -0.9689, 0.0557),
    Vec3::new(-1.5372, 1.8758, -0.2040),
    Vec3::new(-0.4986, 0.0415, 1.0570),
);

/// The image of an `.hdr` file.
pub(super) struct Hdr {
    /// The width of the image in texels.
    pub width: u32,
    /// The height of the image in texels.
    pub height: u32,
    /// Linear RGB radiance of each texel, row by row from the top, left to right.
    pub texels: Vec<Vec3>,
}

/// Reads the HDR file at `path`. The texels are divided by the product of all `EXPOSURE` lines of the header and, for each
/// channel, by that of all `COLORCORR` lines. A line of these whose numbers are not above 0 is ignored, with one of
/// `notices`.
///
/// # Errors
/// The file cannot be read, is damaged, or has too many texels for the limit or the memory.
pub(super) fn read(path: &Path, notices: &mut Vec<String>) -> Result<Hdr> {
    // The decoder may panic on damaged data.
    caught(|| decode(path, notices)).unwrap_or_else(|| {
        let text = "it is damaged; is it a complete HDR?";
        Err(Error::reading(path, text))
    })
}

fn decode(path: &Path, notices: &mut Vec<String>) -> Result<Hdr> {
    let file = input_files::open(path).map_err(|e| Error::reading(path, e))?;
    let mut file = BufReader::new(file);
    let lines = header_lines(&mut file).map_err(|e| Error::reading(path, e))?;
    let header = Header::of(&lines, |ignored| {
        notices.push(format!(
            "{}: the line {} has no number above 0, so it is ignored",
            path.display(),
            quoted(ignored)
        ));
    })
    .map_err(|fault| Error::reading(path, fault))?;
    let [width, height] = header.size();
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
    let damaged = |cause: ImageError| {
        let cause = match cause {
            ImageError::IoError(cause) if cause.kind() == ErrorKind::UnexpectedEof => {
                "it is cut off".to_owned()
            }
            other => other.to_string().replace('\n', " "),
        };
        Error::reading(path, format!("{cause}; export it again"))
    };
    let [lines, length] = header.axes.map(|axis| axis.size);
    let accepted = format!("#?RADIANCE\n\n-Y {lines} +X {length}\n");
    let decoder = HdrDecoder::new(accepted.as_bytes().chain(file)).map_err(damaged)?;
    let mut texels = vec![Vec3::ZERO; lines as usize * length as usize];
    (decoder.read_image(bytemuck::cast_slice_mut(&mut texels))).map_err(damaged)?;
    for texel in &mut texels {
        *texel = header.radiance(*texel);
    }
    Ok(Hdr {
        width,
        height,
        texels: header.upright(texels),
    })
}

/// Reads the lines of the header, up to the one with the size of the image, from the start of `file`. The header ends with
/// the line that follows an empty line. Bytes that are not UTF-8, such as in comments, are replaced. Fails if the header
/// does not end within [`MAX_HEADER`] bytes.
fn header_lines(file: &mut impl BufRead) -> std::io::Result<Vec<String>> {
    let mut lines: Vec<String> = Vec::new();
    let mut start = file.take(MAX_HEADER);
    loop {
        let mut line = Vec::new();
        start.read_until(b'\n', &mut line)?;
        if line.pop() != Some(b'\n') {
            let text =
                format!("its header does not end within {MAX_HEADER} bytes; is it a complete HDR?");
            return Err(std::io::Error::new(ErrorKind::InvalidData, text));
        }
        let is_last = lines.last().is_some_and(String::is_empty);
        lines.push(String::from_utf8_lossy(&line).trim_end().to_owned());
        if is_last {
            return Ok(lines);
        }
    }
}

/// The header of an HDR file, as far as it affects the texels.
struct Header {
    /// The two axes of the image in the order of the resolution line: the texels of the file are lines along the second
    /// axis, one after the other along the first axis.
    axes: [Axis; 2],
    /// The product of all `EXPOSURE` and `COLORCORR` lines for each channel, by which the texels are divided.
    exposure: Vec3,
    /// True if the channels of a texel are CIE XYZ instead of RGB.
    is_xyz: bool,
}

/// One axis of the resolution line, such as `-Y 512`.
#[derive(Clone, Copy)]
struct Axis {
    /// True for Y, the height, and false for X, the width.
    is_y: bool,
    /// True if the file has the texels along this axis from the bottom up, or from right to left.
    is_reversed: bool,
    /// The number of texels along the axis.
    size: u32,
}

impl Header {
    /// Interprets the lines of a header. Lines whose numbers have no use are given to `ignore`. The error text is the
    /// reason; the caller puts it behind the path of the file in its message.
    fn of(lines: &[String], mut ignore: impl FnMut(&str)) -> std::result::Result<Self, String> {
        let (Some(magic), Some(resolution)) = (lines.first(), lines.last()) else {
            return Err("it has no header".into());
        };
        if !magic.starts_with("#?") {
            return Err("its first line does not begin with #?; is it an HDR file?".into());
        }
        let mut header = Self {
            axes: axes(resolution).ok_or_else(|| {
                format!(
                    "its line {} is not a size such as \"-Y 512 +X 1024\"; export it again",
                    quoted(resolution)
                )
            })?,
            exposure: Vec3::ONE,
            is_xyz: false,
        };
        for line in lines {
            match line.split_once('=') {
                Some(("FORMAT", format)) => match format.trim() {
                    "32-bit_rle_rgbe" => header.is_xyz = false,
                    "32-bit_rle_xyze" => header.is_xyz = true,
                    other => {
                        return Err(format!(
                            "its format is {}, not 32-bit_rle_rgbe or 32-bit_rle_xyze; export it again",
                            quoted(other)
                        ));
                    }
                },
                Some((key @ ("EXPOSURE" | "COLORCORR"), text)) => {
                    let count = if key == "EXPOSURE" { 1 } else { 3 };
                    match (factors(text, count), header.exposure) {
                        (Some(factors), before) if is_positive(before * factors) => {
                            header.exposure = before * factors;
                        }
                        _ => ignore(line),
                    }
                }
                _ => {}
            }
        }
        Ok(header)
    }

    /// The width and the height of the image in texels.
    fn size(&self) -> [u32; 2] {
        let [first, second] = self.axes.map(|axis| axis.size);
        if self.axes[0].is_y {
            [second, first]
        } else {
            [first, second]
        }
    }

    /// The radiance in linear sRGB of a texel of the file.
    fn radiance(&self, texel: Vec3) -> Vec3 {
        let texel = texel / self.exposure;
        if self.is_xyz {
            // Rounding to 8 bits puts colours at the edge of sRGB outside of it.
            (SRGB_OF_XYZ * texel).max(Vec3::ZERO)
        } else {
            texel
        }
    }

    /// The texels in rows from the top, from left to right, from those in the order of the file.
    fn upright(&self, texels: Vec<Vec3>) -> Vec<Vec3> {
        let [first, second] = self.axes;
        if first.is_y && !first.is_reversed && !second.is_reversed {
            return texels;
        }
        let index = |axis: Axis, at: u32| {
            let at = if axis.is_reversed {
                axis.size - 1 - at
            } else {
                at
            };
            at as usize
        };
        let [width, height] = self.size();
        let from = |x: u32, y: u32| {
            let [line, place] = if first.is_y { [y, x] } else { [x, y] };
            texels[index(first, line) * second.size as usize + index(second, place)]
        };
        (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| from(x, y))
            .collect()
    }
}

/// The axes of the resolution line `line`, such as `-Y 512 +X 1024`; `None` if it does not have one X and one Y, each with
/// a sign and a size of 31 bits. `-Y` and `+X` are the usual directions: down and to the right.
fn axes(line: &str) -> Option<[Axis; 2]> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [first, first_size, second, second_size] = *words.as_slice() else {
        return None;
    };
    let axis = |name: &str, size: &str| {
        let (is_y, is_reversed) = match name {
            "-Y" => (true, false),
            "+Y" => (true, true),
            "+X" => (false, false),
            "-X" => (false, true),
            _ => return None,
        };
        let size = size.parse().ok().filter(|size| *size <= i32::MAX as u32)?;
        Some(Axis {
            is_y,
            is_reversed,
            size,
        })
    };
    let axes = [axis(first, first_size)?, axis(second, second_size)?];
    (axes[0].is_y != axes[1].is_y).then_some(axes)
}

/// The factors of red, green and blue in `text`: `count` numbers, where one number stands for all channels. `None` if there
/// are fewer numbers.
fn factors(text: &str, count: usize) -> Option<Vec3> {
    let numbers = text.split_whitespace().map(|word| word.parse().ok());
    match *numbers
        .take(count)
        .collect::<Option<Vec<f32>>>()?
        .as_slice()
    {
        [all] if count == 1 => Some(Vec3::splat(all)),
        [r, g, b] => Some(Vec3::new(r, g, b)),
        _ => None,
    }
}

/// True if all factors can divide a radiance: they are normal numbers above 0.
fn is_positive(factors: Vec3) -> bool {
    factors
        .to_array()
        .iter()
        .all(|factor| factor.is_normal() && *factor > 0.0)
}

#[cfg(test)]
mod tests {
    use crate::scene::Environment;
    use std::fs::File;

    #[test]
    fn a_header_without_an_end_is_not_read_to_the_end_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.hdr");
        for (text, bytes) in [("", 1 << 40), ("\n", 1 << 40), ("\n-Y 1", 20)] {
            std::fs::write(&path, format!("#?RADIANCE\n{text}")).unwrap();
            let file = File::options().write(true).open(&path).unwrap();
            file.set_len(bytes).unwrap();
            let message = Environment::open(path.to_str().unwrap(), &mut Vec::new()).unwrap_err();
            assert!(
                message.to_string().contains("header does not end"),
                "{message}"
            );
        }
    }
}
