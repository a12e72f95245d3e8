//! The command-line options that several commands share, and their checks.

use super::choices::{LoadArgs, VariantArgs};
use crate::base::files::{check_writable, is_same_file};
use crate::base::input_files;
use crate::base::toml_text::TomlText;
use crate::image::Format;
use crate::render::presets::{self, Preset};
use crate::render::settings::{Settings, flatten};
use crate::render::{Clock, Lighting};
use crate::scene::Camera;
use crate::scene::camera::look_at;
use crate::scene::validate::check_camera;
use crate::scene_files::{environment_file_of, file_of};
use crate::{Error, Result};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// The maximum number of pixels of a picture that is rendered; a larger size is refused.
const MAX_PIXELS: u64 = 1 << 28;

/// Options that choose the scene, its view, its settings and the device; every command that renders a picture has them.
#[derive(clap::Args)]
pub struct SceneArgs {
    /// A procedural scene's name, or a file: .gltf, .glb, .obj
    pub scene: String,
    /// Permissions for loading a scene: without missing image files, with files outside of its folder
    #[command(flatten)]
    pub load: LoadArgs,
    /// Light from all around: a file, .exr or .hdr, by longitude and latitude, or a sky such as sky:sun=40
    #[arg(long, value_name = "FILE|sky:…")]
    pub environment: Option<String>,
    /// Image width in pixels; with neither width nor height: 1280
    #[arg(long, allow_negative_numbers = true)]
    pub width: Option<u32>,
    /// Image height in pixels; given one side, the other follows the camera's aspect
    #[arg(long, allow_negative_numbers = true)]
    pub height: Option<u32>,
    /// Seed of all random numbers; equal seeds give equal pictures on one driver
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u32,
    /// Maximum number of scattering events; 0 = emission only, 1 = direct light
    #[arg(long, default_value_t = 5, allow_negative_numbers = true)]
    pub bounces: u32,
    /// Draw rays over the whole pixel (box filter) instead of through its centre
    #[arg(long)]
    pub jitter: bool,
    /// The camera of the scene to render with, by name or index; without it, the first one
    #[arg(long, value_name = "NAME|INDEX", allow_negative_numbers = true)]
    pub camera: Option<String>,
    /// A user-defined camera: eye, target and optionally the vertical field of view in degrees
    #[arg(
        long,
        value_name = "EX,EY,EZ,TX,TY,TZ[,DEGREES]",
        allow_hyphen_values = true
    )]
    pub look_at: Option<String>,
    /// Time in seconds at which the scene is shown, or with --fps its first frame
    #[arg(
        long,
        default_value_t = 0.0,
        allow_hyphen_values = true,
        value_name = "SECONDS"
    )]
    pub start_time: f64,
    /// Preset to which the other settings are applied; see 'headwater presets' [default: balanced]
    #[arg(long)]
    pub preset: Option<String>,
    /// Settings from a TOML file, which override the preset
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// One setting, which overrides the preset and the file; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Options that choose the tracer and the access of shaders to the scene
    #[command(flatten)]
    pub variant: VariantArgs,
    /// The Vulkan device, by its name, a part of its name, or its index in 'headwater info'
    #[arg(long, value_name = "NAME|INDEX", env = "HEADWATER_DEVICE")]
    pub device: Option<String>,
    /// Further channels of EXR files, such as albedo and depth, separated by commas
    #[arg(long, value_delimiter = ',', value_enum)]
    pub aov: Vec<Aov>,
    /// Exposure of PNG files, in stops: radiance is multiplied by 2 to this power
    #[arg(
        long,
        default_value_t = 0.0,
        allow_hyphen_values = true,
        value_name = "EV"
    )]
    pub exposure: f32,
    /// Write the choices, the settings and the times of the run as JSON
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
}

/// Additional channels of an EXR file, beside the picture, as `--aov` names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Aov {
    /// The fraction of light, from 0 to 1 per channel, that the visible surface reflects.
    Albedo,
    /// The shading normal of the visible surface, in world space.
    Normal,
    /// Distance from the camera to the visible surface along the ray, in scene units; 0 where nothing was hit.
    Depth,
    /// Index of the visible instance among the instances of the scene; 0xFFFFFFFF where nothing was hit.
    Instance,
    /// Vector in pixels from the visible surface to its position in the previous frame; right and down are positive.
    Motion,
    /// The contents of the last frame's reservoirs of direct light.
    Direct,
    /// The contents of the last frame's reservoirs of indirect light.
    Indirect,
}

impl Aov {
    /// The kind of light, direct or indirect, whose reservoirs these channels show; `None` for channels that show surfaces.
    pub const fn reservoirs_of(self) -> Option<Lighting> {
        match self {
            Self::Direct => Some(Lighting::Direct),
            Self::Indirect => Some(Lighting::Indirect),
            Self::Albedo | Self::Normal | Self::Depth | Self::Instance | Self::Motion => None,
        }
    }
}

impl SceneArgs {
    /// The settings from the preset, the file of `--config` and the changes of `--set`, applied in this order. The second
    /// value lists the dotted keys that the file and `--set` name, for notes on keys without effect.
    ///
    /// # Errors
    /// A preset, key or value is unknown, or the file cannot be read or is not TOML.
    pub fn settings(&self) -> Result<(Settings, Vec<String>)> {
        let preset = self.preset.as_deref().unwrap_or(presets::DEFAULT);
        let mut settings = Preset::named(preset)?.settings()?;
        let mut changed = Vec::new();
        if let Some(path) = &self.config {
            let text = input_files::read_text(path, input_files::MAX_TOML_BYTES)?;
            let source = TomlText::new(&path.display().to_string(), &text);
            let changes = source.parse()?;
            settings = settings.with_toml(&source, &[], &changes)?;
            flatten("", &changes, &mut changed);
        }
        for change in &self.set {
            let change = Settings::parse_change(change)?;
            settings = settings.with(&change)?;
            flatten("", &change, &mut changed);
        }
        Ok((settings, changed.into_iter().map(|(key, _)| key).collect()))
    }

    /// Checks the paths of pictures, `outputs`, and of the report before long work begins.
    ///
    /// # Errors
    /// A picture has an unknown format or a file has two purposes (wrong input), or a file cannot be written (failed work).
    pub fn check_outputs(&self, outputs: &[PathBuf]) -> Result<()> {
        for path in outputs {
            Format::of(path)?;
        }
        let pictures = outputs.iter().map(|path| ("--output", path.as_path()));
        let report = self.report.as_deref().map(|path| ("--report", path));
        check_files(pictures.chain(report), self.inputs())
    }

    /// The files that the command reads, each as (role in messages, path): the scene, the environment and the settings.
    /// Generated scenes and skies are not files and do not appear.
    pub fn inputs(&self) -> impl Iterator<Item = (&str, &Path)> {
        let scene = file_of(&self.scene).map(|path| ("the scene", path));
        let environment = self.environment.as_deref().and_then(environment_file_of);
        let environment = environment.map(|path| ("--environment", path));
        let config = self.config.as_deref().map(|path| ("--config", path));
        [scene, environment, config].into_iter().flatten()
    }

    /// The time that each frame shows: `--start-time` for frame 0, then `fps` frames per second; without `fps`, all frames
    /// show the same time.
    ///
    /// # Errors
    /// `--start-time` is not finite, or `fps` is not positive and finite.
    pub fn clock(&self, fps: Option<f64>) -> Result<Clock> {
        let clock = Clock {
            start_time: self.start_time,
            fps,
        };
        clock.check("--start-time", "--fps")?;
        Ok(clock)
    }

    /// Width and height of the picture in pixels. The aspect ratio of `camera` gives a side that the options do not give.
    ///
    /// # Errors
    /// A side is 0, the picture has more than 2²⁸ pixels, or `--exposure` is not finite.
    pub fn size(&self, camera: &Camera) -> Result<(u32, u32)> {
        if !self.exposure.is_finite() {
            return Err(Error::input("--exposure takes a finite number of stops"));
        }
        size_for(camera, self.width, self.height)
    }

    /// The camera that `--look-at` describes; `None` if the option is not given, and an error if its text describes no
    /// camera.
    pub fn look_at_camera(&self) -> Result<Option<Camera>> {
        self.look_at
            .as_deref()
            .map(|text| parse_look_at("--look-at", text))
            .transpose()
    }
}

/// The camera that a text describes by six or seven numbers, separated by commas: the coordinates of the eye and of the
/// target, in scene units, and the vertical field of view in degrees, by default 45. `origin` names the text in messages.
///
/// # Errors
/// There are not six or seven finite numbers, eye and target are equal, the field of view is outside (0, 180) degrees, or
/// the eye is too far from the origin of the scene to be rendered.
pub fn parse_look_at(origin: &str, text: &str) -> Result<Camera> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    let numbers = numbers
        .filter(|n| (n.len() == 6 || n.len() == 7) && n.iter().all(|value| value.is_finite()));
    let numbers = numbers.ok_or_else(|| {
        Error::input(format!(
            "{origin} '{text}' is not EX,EY,EZ,TX,TY,TZ or EX,EY,EZ,TX,TY,TZ,DEGREES"
        ))
    })?;
    let eye = DVec3::from_slice(&numbers[..3]);
    let target = DVec3::from_slice(&numbers[3..6]);
    let degrees = numbers.get(6).copied().unwrap_or(45.0);
    if eye == target {
        return Err(Error::input(format!(
            "{origin}: eye and target are the same point"
        )));
    }
    if !(degrees > 0.0 && degrees < 180.0) {
        return Err(Error::input(format!(
            "{origin}: a field of view of {degrees} degrees; it lies between 0 and 180"
        )));
    }
    let camera = look_at(eye, target, degrees.to_radians());
    check_camera(origin, &camera)?;
    Ok(camera)
}

/// Width and height of a picture in pixels. A missing side follows from the camera's aspect ratio, which is 16:9 unless the
/// camera has one; if both are missing, the width is 1280.
///
/// # Errors
/// A side is 0, or the picture has more than 2²⁸ pixels.
pub fn size_for(camera: &Camera, width: Option<u32>, height: Option<u32>) -> Result<(u32, u32)> {
    let aspect = camera.aspect_ratio.unwrap_or(16.0 / 9.0);
    let side = |pixels: f64| (pixels.round().min(f64::from(u32::MAX)) as u32).max(1);
    let (width, height) = match (width, height) {
        (Some(width), Some(height)) => (width, height),
        (Some(width), None) => (width, side(f64::from(width) / aspect)),
        (None, Some(height)) => (side(f64::from(height) * aspect), height),
        (None, None) => (1280, side(1280.0 / aspect)),
    };
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(Error::input(format!(
            "an image of {width} × {height} has no pixels; --width and --height begin at 1"
        )));
    }
    if pixels > MAX_PIXELS {
        return Err(Error::input(format!(
            "an image of {width} × {height} has {pixels} pixels; at most {MAX_PIXELS} are possible"
        )));
    }
    Ok((width, height))
}

/// Checks, before work begins, that each file in `written` can be written, and that none of them is the same file as another
/// one in `written` or in `read`. Entries are (role in messages, path).
///
/// # Errors
/// A file has two roles (wrong input), or a file cannot be written (failed work).
pub fn check_files<'a>(
    written: impl IntoIterator<Item = (&'a str, &'a Path)>,
    read: impl IntoIterator<Item = (&'a str, &'a Path)>,
) -> Result<()> {
    let mut files: Vec<(&str, &Path)> = written.into_iter().collect();
    let count = files.len();
    files.extend(read);
    check_distinct(&files, count)?;
    files[..count]
        .iter()
        .try_for_each(|(_, path)| check_writable(path))
}

/// Checks that none of the first `written` entries of `files` is the same file as another entry, which would be overwritten.
/// Entries are (role in messages, path).
fn check_distinct(files: &[(&str, &Path)], written: usize) -> Result<()> {
    for (i, (what, path)) in files.iter().enumerate() {
        let before = files[..i.min(written)].iter();
        let Some((other_what, other)) = before.rev().find(|(_, other)| is_same_file(path, other))
        else {
            continue;
        };
        let path = path.display();
        return Err(Error::input(
            if other.as_os_str() != path.to_string().as_str() {
                let other = other.display();
                format!(
                    "{other_what} '{other}' and {what} '{path}' are one file, which would be overwritten; name another"
                )
            } else if what == other_what {
                format!("{what} names '{path}' twice; name each file once")
            } else {
                format!(
                    "{other_what} and {what} are both '{path}', which would be overwritten; name another"
                )
            },
        ));
    }
    Ok(())
}
