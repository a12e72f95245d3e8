//! Pictures: named channels in memory, EXR and PNG files on disk.

mod exr;
mod layers;
pub(crate) mod png;
pub(crate) mod tonemap;
pub use tonemap::{Look, ToneCurve};

pub use layers::Colors;

use crate::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The values of one channel of a picture: one per pixel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// The values are 32-bit floats, such as radiance or depth.
    F32(Vec<f32>),
    /// The values are 32-bit unsigned integers, such as instance indices.
    U32(Vec<u32>),
}

impl Samples {
    fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::U32(values) => values.len(),
        }
    }

    fn has_bits_of(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::F32(a), Self::F32(b)) => {
                bytemuck::cast_slice::<f32, u32>(a) == bytemuck::cast_slice::<f32, u32>(b)
            }
            _ => self == other,
        }
    }
}

/// A picture in memory, which is written to a file or was read from one. It has named channels, such as `R`, `stderr.G` or
/// `instance.id`. The part of a name before the last dot is the layer, a group of channels that belong together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// The width of the picture in pixels, which is the number of values in each row of a channel.
    pub width: u32,
    /// The height of the picture in pixels, which is the number of rows of each channel.
    pub height: u32,
    /// The channels by name; each has width × height values, row by row from the top.
    pub channels: BTreeMap<String, Samples>,
    /// Metadata, such as `headwater.seed`, as pairs of key and text of the value. They state how the picture was rendered,
    /// so that the computation of a reference can be resumed only with the same settings. Only EXR files store them; the map
    /// is empty if a file has none.
    pub metadata: BTreeMap<String, String>,
}

/// A file format for pictures. The extension of a file's name decides its format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: stores the metadata and all channels. Each value has 32 bits and does not change when it is written and
    /// read.
    Exr,
    /// PNG: stores only `R`, `G`, `B`, after exposure and tone mapping, as 8-bit sRGB, and the channel `A` if there is one.
    Png,
}

impl Format {
    /// The format that the extension of `path` names. The extension can be in upper or lower case.
    ///
    /// # Errors
    /// The path has no extension, or another one than `exr` and `png`.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|e| e.to_ascii_lowercase());
        match extension.as_deref().and_then(|e| e.to_str()) {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            _ => Err(Error::input(format!(
                "'{}' has no known format; pictures end in .exr or .png",
                path.display()
            ))),
        }
    }
}

impl Image {
    /// Makes a picture of `width` × `height` pixels without channels and metadata, which the caller then
    /// adds.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            ..Self::default()
        }
    }

    /// The number of pixels: width × height. Each channel must have this number of values.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Sets three float channels, whose names are `prefix` followed by each of `names`. `values` has one vector per pixel,
    /// row by row from the top. Existing channels of these names are replaced.
    pub fn set_vectors(&mut self, prefix: &str, names: [&str; 3], values: &[[f32; 3]]) {
        for (axis, name) in names.iter().enumerate() {
            let samples = values.iter().map(|value| value[axis]).collect();
            self.channels
                .insert(format!("{prefix}{name}"), Samples::F32(samples));
        }
    }

    /// The values of the float channel with this name, row by row from the top. `None` if the picture has no channel of this
    /// name, or if the channel holds integers.
    pub fn floats(&self, name: &str) -> Option<&[f32]> {
        match self.channels.get(name) {
            Some(Samples::F32(values)) => Some(values),
            _ => None,
        }
    }

    /// The values of the channels `R`, `G`, `B` that belong to no layer, as one vector per pixel, row by row
    /// from the top.
    ///
    /// # Errors
    /// One of these channels is missing or holds integers.
    pub fn rgb(&self) -> Result<Vec<[f32; 3]>> {
        let channel = |name: &str| {
            self.floats(name)
                .ok_or_else(|| Error::input(format!("the picture has no channel {name}")))
        };
        let (r, g, b) = (channel("R")?, channel("G")?, channel("B")?);
        Ok(r.iter()
            .zip(g)
            .zip(b)
            .map(|((r, g), b)| [*r, *g, *b])
            .collect())
    }

    /// The names of the channels that only one of the two pictures has, or whose values differ in any bit, in alphabetical
    /// order. 0 differs from −0, and NaNs of equal bits do not differ. The list is empty if the pictures are equal to the
    /// last bit, as regression tests require.
    pub fn different_channels<'a>(&'a self, other: &'a Self) -> Vec<&'a str> {
        let names: BTreeSet<&String> = self.channels.keys().chain(other.channels.keys()).collect();
        let same = |name: &String| match (self.channels.get(name), other.channels.get(name)) {
            (Some(a), Some(b)) => a.has_bits_of(b),
            _ => false,
        };
        let different = names.into_iter().filter(|name| !same(name));
        different.map(String::as_str).collect()
    }

    /// Writes the picture in the format that the extension of `path` names. A PNG file shows
    /// the radiance with the exposure and the curve of `look`, which can be an exposure alone; an EXR file contains the
    /// radiance itself, whatever the look. If the picture has a channel `A` of alpha, its `R`, `G`, `B` are multiplied by
    /// alpha, as EXR files have them; a PNG file shows them divided by alpha.
    ///
    /// # Errors
    /// The format is unknown, the picture has no pixels or no channels, a channel does not have one value per pixel, a PNG
    /// lacks `R`, `G` or `B`, or the file cannot be written.
    pub fn write(&self, path: &Path, look: impl Into<Look>) -> Result<()> {
        self.check().map_err(|e| Error::writing(path, e))?;
        match Format::of(path)? {
            Format::Exr => exr::write(self, path),
            Format::Png => png::write(self, path, look.into()),
        }
    }

    /// Checks that the picture has pixels and channels, and that each channel has one value per pixel, because the encoders
    /// panic on other pictures. The error text is the reason; the caller puts it behind the path of the file in its message.
    fn check(&self) -> std::result::Result<(), String> {
        let pixels = self.pixels();
        if pixels == 0 || self.channels.is_empty() {
            return Err("the picture is empty".into());
        }
        match self.channels.iter().find(|(_, s)| s.len() != pixels) {
            Some((name, samples)) => Err(format!(
                "channel {name} has {} values for {pixels} pixels",
                samples.len()
            )),
            None => Ok(()),
        }
    }

    /// Reads an EXR file with all its channels, or a PNG file as linear `R`, `G`, `B`.
    ///
    /// # Errors
    /// The extension names no known format, or the file cannot be read in this format.
    pub fn read(path: &Path) -> Result<Self> {
        match Format::of(path)? {
            Format::Exr => exr::read(path),
            Format::Png => png::read(path),
        }
    }
}
