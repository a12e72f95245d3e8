//! Environments: light from infinitely far away, as an image over the sphere.

use super::lights::luminance;
use super::sky;
use super::validate::{BRIGHTEST, is_within};
use crate::panics::caught;
use crate::{Error, Result, image, input_files, memory};
use ::image::{ImageDecoder, ImageReader};
use glam::Vec3;
use std::f64::consts::{PI, TAU};
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek};
use std::path::Path;
use std::sync::Arc;

/// The most texels of an environment: samples name a texel in 29 bits, and this many take 1.5 GiB.
const MAX_TEXELS: u64 = 1 << 26;

/// The longest header of an `.hdr` file, in bytes.
const MAX_HEADER: u64 = 1 << 16;

/// Light from infinitely far away.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// The file, or the parameters of a generated sky.
    pub name: String,
    /// Texels of longitude.
    pub width: u32,
    /// Texels of latitude.
    pub height: u32,
    /// Linear radiance ≥ 0, by rows, before [`Environment::intensity`]. Row 0 is at the zenith (+Y); the middle column
    /// looks along −Z, and columns go on to the right as seen from within. Between the centres of texels it is
    /// interpolated.
    pub texels: Arc<[Vec3]>,
    /// Turns it around the upward axis, counter-clockwise seen from above, in degrees.
    pub rotation: f64,
    /// Multiplies the radiance.
    pub intensity: f32,
}

impl Environment {
    /// Reads an environment (`.exr`, `.hdr`), or generates the sky that `sky:…` describes.
    ///
    /// # Errors
    /// No such file, damaged data, radiance that is no number or out of range, or wrong parameters.
    pub fn open(name: &str) -> Result<Self> {
        let mut environment = match name.split_once(':') {
            Some(("sky", parameters)) => sky::generate(parameters)?,
            _ if name == "sky" => sky::generate("")?,
            _ => read(Path::new(name))?,
        };
        environment.name = name.to_owned();
        environment.check()?;
        Ok(environment)
    }

    /// Checks that [`Environment::open`] can succeed, as far as possible without reading the file.
    ///
    /// # Errors
    /// No such file, or wrong parameters of a sky.
    pub fn check_name(name: &str) -> Result<()> {
        match file_of(name) {
            None => sky::parse(name.strip_prefix("sky").unwrap_or_default()).map(drop),
            Some(path) => input_files::check(path),
        }
    }

    fn check(&mut self) -> Result<()> {
        let wrong = |fault: String| Err(Error::input(format!("{}: {fault}", self.name)));
        let texels = u64::from(self.width) * u64::from(self.height);
        if texels == 0 || texels > MAX_TEXELS || texels != self.texels.len() as u64 {
            return wrong(format!(
                "has {} × {} texels, an environment 1 to {MAX_TEXELS} in all; scale it",
                self.width, self.height
            ));
        }
        let bad = |texel: &Vec3| !is_within(*texel, BRIGHTEST);
        if let Some(index) = self.texels.iter().position(bad) {
            let (x, y) = (index as u32 % self.width, index as u32 / self.width);
            return wrong(format!(
                "texel {x}, {y} is {}; radiance must be within 0 and {BRIGHTEST:e}",
                self.texels[index]
            ));
        }
        Ok(())
    }

    /// The solid angle of each texel of a row.
    pub fn solid_angle(&self, row: u32) -> f64 {
        // By the product, because differences of cosines cancel near the poles.
        let (middle, half) = (
            PI * (f64::from(row) + 0.5) / f64::from(self.height),
            0.5 * PI / f64::from(self.height),
        );
        TAU / f64::from(self.width) * 2.0 * middle.sin() * half.sin()
    }

    /// The mean of the interpolated radiance over each texel, without the intensity.
    pub fn means(&self) -> Vec<Vec3> {
        let (width, height) = (self.width as usize, self.height as usize);
        let across = |row: usize| -> Vec<Vec3> {
            let texels = &self.texels[row * width..(row + 1) * width];
            (0..width)
                .map(|x| {
                    let beside = texels[(x + width - 1) % width] + texels[(x + 1) % width];
                    0.75 * texels[x] + 0.125 * beside
                })
                .collect()
        };
        let mut means = Vec::with_capacity(width * height);
        let (mut above, mut here) = (across(0), across(0));
        for row in 0..height {
            let below = across((row + 1).min(height - 1));
            let beside = above.iter().zip(&below).map(|(a, b)| *a + *b);
            means.extend((here.iter().zip(beside)).map(|(own, sum)| 0.75 * *own + 0.125 * sum));
            above = std::mem::replace(&mut here, below);
        }
        means
    }

    /// The integrals of its luminance over the sphere, and of the square.
    pub fn integrals(&self) -> (f64, f64) {
        let (mut integral, mut squares) = (0.0, 0.0);
        for (index, mean) in self.means().into_iter().enumerate() {
            let solid_angle = self.solid_angle(index as u32 / self.width);
            let luminance = luminance(mean) * f64::from(self.intensity);
            integral += luminance * solid_angle;
            squares += luminance * luminance * solid_angle;
        }
        (integral, squares)
    }

    /// The largest radiance in any channel.
    pub fn brightest(&self) -> f32 {
        let brightest = self.texels.iter().map(|texel| texel.max_element());
        self.intensity * brightest.fold(0.0, f32::max)
    }

    /// Whether it lights anything.
    pub fn is_lit(&self) -> bool {
        self.brightest() > 0.0
    }
}

/// The file that an environment's name is the path of; none for a generated sky.
pub fn file_of(name: &str) -> Option<&Path> {
    let generated = name == "sky" || name.starts_with("sky:");
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
                "{}: is no environment that can be read; give an .exr or .hdr file, or sky:sun=40",
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

/// Checks that the header ends: the decoder would look for its end, a line after an empty one, as far as the file goes.
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
    // They are decoded, and copied.
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

    fn environment(width: u32, height: u32, texel: impl Fn(u32, u32) -> Vec3) -> Environment {
        Environment {
            name: "test".into(),
            width,
            height,
            texels: (0..height)
                .flat_map(|y| (0..width).map(move |x| (x, y)))
                .map(|(x, y)| texel(x, y))
                .collect(),
            rotation: 0.0,
            intensity: 1.0,
        }
    }

    #[test]
    fn texels_cover_the_sphere() {
        for (width, height) in [(1, 1), (2, 1), (64, 33), (4096, 2048)] {
            let environment = environment(width, height, |_, _| Vec3::ONE);
            let rows = (0..height).map(|row| environment.solid_angle(row));
            let sum: f64 = rows.sum::<f64>() * f64::from(width);
            assert!((sum / (2.0 * TAU) - 1.0).abs() < 1e-9, "{sum}");
        }
    }

    #[test]
    fn means_reach_as_far_as_the_interpolation_does() {
        let sun = environment(8, 4, |x, y| {
            Vec3::splat(if (x, y) == (0, 0) { 64.0 } else { 0.0 })
        });
        let means = sun.means();
        let at = |x: usize, y: usize| means[8 * y + x].x;
        // The first row is its own neighbour above.
        assert_eq!(
            [at(0, 0), at(1, 0), at(7, 0)],
            [64.0 * 0.75 * 0.875, 7.0, 7.0]
        );
        assert_eq!([at(0, 1), at(1, 1), at(7, 1)], [6.0, 1.0, 1.0]);
        assert_eq!(means.iter().filter(|mean| mean.x > 0.0).count(), 6);
    }

    #[test]
    fn a_constant_environment_has_its_radiance_on_the_whole_sphere() {
        let mut constant = environment(16, 8, |_, _| Vec3::ONE);
        constant.intensity = 3.0;
        let (integral, squares) = constant.integrals();
        assert!((integral / (6.0 * TAU) - 1.0).abs() < 1e-6, "{integral}");
        assert!((squares / (18.0 * TAU) - 1.0).abs() < 1e-6, "{squares}");
    }

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

    #[test]
    fn radiance_out_of_range_is_named() {
        for value in [f32::NAN, f32::INFINITY, -1.0, 1e13] {
            let mut broken = environment(4, 2, |x, y| {
                Vec3::new(1.0, if (x, y) == (3, 1) { value } else { 0.0 }, 0.0)
            });
            let message = broken.check().unwrap_err().to_string();
            assert!(message.contains("texel 3, 1"), "{message}");
        }
    }
}
