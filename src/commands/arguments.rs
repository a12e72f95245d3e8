//! The command-line options that several commands share, and the checks of their values, so that a wrong value is an
//! error before rendering begins.

use super::choices::{JitterArg, LoadArgs, TonemapArg, VariantArgs};
use crate::base::files::{check_writable, is_same_file};
use crate::base::input_files;
use crate::base::toml_text::TomlText;
use crate::image::{Format, Look};
use crate::render::presets::{self, Preset};
use crate::render::settings::{Settings, flatten};
use crate::render::{Clock, Lighting};
use crate::scene::Camera;
use crate::scene::camera::{DEFAULT_ASPECT, look_at};
use crate::scene::validate::check_camera;
use crate::scene_files::{environment_file_of, file_of};
use crate::{Error, Result};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// The maximum number of pixels of a picture to render; arguments that ask for more are refused.
const MAX_PIXELS: u64 = 1 << 28;

/// Options that choose what is rendered (the scene, its environment, the camera, the size of the picture), and the device.
/// All commands that render one scene share them.
#[derive(clap::Args)]
pub struct ViewArgs {
    /// The scene: the name of a procedural scene (see 'headwater scene list'), or a file, .gltf, .glb or .obj
    pub scene: String,
    /// Options for loading the scene: missing files, files outside of its folder, and the variant of its materials
    #[command(flatten)]
    pub load: LoadArgs,
    /// Light from infinitely far away, which surrounds the scene: an .exr or .hdr image whose columns are longitudes
    /// and whose rows are latitudes, or a sky such as sky:sun=40, where the number is the sun's elevation in degrees;
    /// or neutral, a grey one that makes shapes visible; or none. Without it, a scene that has no light at all gets
    /// neutral
    #[arg(long, value_name = "FILE|sky:…|neutral|none")]
    pub environment: Option<String>,
    /// Width of the picture in pixels; without it, the width follows from --height and the camera's aspect ratio; without
    /// both, it is 1280
    #[arg(long, allow_negative_numbers = true)]
    pub width: Option<u32>,
    /// Height of the picture in pixels; without it, the height follows from the width and the camera's aspect ratio
    #[arg(long, allow_negative_numbers = true)]
    pub height: Option<u32>,
    /// Seed of all random numbers; equal seeds give equal pictures on the same device and driver
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u32,
    /// Maximum number of scattering events of a path; 0 shows only emitted light, 1 also direct light, 2 also light that is
    /// scattered twice
    #[arg(long, default_value_t = 5, allow_negative_numbers = true)]
    pub bounces: u32,
    /// The points of each pixel through which the camera's rays pass; --jitter alone means on
    #[arg(long, value_enum, num_args = 0..=1, default_value_t, default_missing_value = "on")]
    pub jitter: JitterArg,
    /// Render with this camera of the scene, given by its name or its index from 0; without it, the first camera is
    /// used, or one that sees the whole scene if the scene has none
    #[arg(long, value_name = "NAME|INDEX", allow_negative_numbers = true)]
    pub camera: Option<String>,
    /// Render with this camera, not with one of the scene; it is given by eye and target in scene units, and optionally
    /// by the vertical field of view in degrees [default: 45]
    #[arg(
        long,
        value_name = "EX,EY,EZ,TX,TY,TZ[,DEGREES]",
        allow_hyphen_values = true
    )]
    pub look_at: Option<String>,
    /// Diameter of the camera's lens in scene units, which blurs what is out of focus; 0 is a pinhole, which shows
    /// everything sharply
    #[arg(
        long,
        default_value_t = 0.0,
        allow_hyphen_values = true,
        value_name = "DIAMETER"
    )]
    pub aperture: f64,
    /// Distance of what --aperture shows sharply, in scene units along the viewing direction; without it, the distance of
    /// what the centre of the picture shows at --start-time
    #[arg(long, allow_hyphen_values = true, value_name = "DISTANCE")]
    pub focus: Option<f64>,
    /// Time in the scene, in seconds, at which it is rendered; with --fps, it is the time of frame 0
    #[arg(
        long,
        default_value_t = 0.0,
        allow_hyphen_values = true,
        value_name = "SECONDS"
    )]
    pub start_time: f64,
    /// Options that choose the method that traces rays, and how shaders access the scene
    #[command(flatten)]
    pub variant: VariantArgs,
    /// The Vulkan device to use: its name, a part of its name, or its index in 'headwater info'; without it, the best
    /// one: discrete GPUs first, CPUs last
    #[arg(long, value_name = "NAME|INDEX", env = "HEADWATER_DEVICE")]
    pub device: Option<String>,
}

/// Options that choose the view, the settings of the renderer, and further outputs. The commands `render`, `reference` and
/// `profile` share them.
#[derive(clap::Args)]
pub struct SceneArgs {
    /// Options that choose what is rendered, and the device
    #[command(flatten)]
    pub view: ViewArgs,
    /// Preset that supplies all settings which --config and --set do not change; see 'headwater presets' [default: balanced]
    #[arg(long)]
    pub preset: Option<String>,
    /// TOML file of settings, which override those of the preset; without it, only --set changes them
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// A setting and its value, which override the preset and --config; may be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Further channels of EXR files beside the picture, such as albedo and depth, separated by commas; without it,
    /// there are none
    #[arg(long, value_delimiter = ',', value_enum)]
    pub aov: Vec<Aov>,
    /// Give pictures an alpha channel: the fraction of each pixel that surfaces cover. The camera then does not see the
    /// environment, which still lights the scene. EXR files have colours that are multiplied by alpha, PNG files have colours
    /// that are not
    #[arg(long)]
    pub alpha: bool,
    /// Exposure of PNG files and of the pictures that --capture presents, in stops: radiance is multiplied by 2 to this
    /// power; EXR files are not affected
    #[arg(
        long,
        default_value_t = 0.0,
        allow_hyphen_values = true,
        value_name = "EV"
    )]
    pub exposure: f32,
    /// The curve that maps radiance to the brightness of PNG files, before the sRGB encoding
    #[arg(long, value_enum, default_value_t)]
    pub tonemap: TonemapArg,
    /// Write a report of the run as JSON: the device, the tracer and other choices with their reasons, the settings, and the
    /// times of the passes
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
}

/// Channels (arbitrary output variables) that an EXR file can have beside the picture, as `--aov` names them. Some show the
/// surface that the camera sees, for example for a denoiser. The others show the content of each pixel's reservoir, so that
/// the user can examine the resampling; the sample in a reservoir supplies the light of its pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Aov {
    /// The channels contain the fraction of light that the visible surface reflects, from 0 to 1 for red, green and blue;
    /// they are 0 where the camera's ray hits nothing
    Albedo,
    /// The channels contain the unit shading normal of the visible surface, in world space, on the side of the camera;
    /// they are 0 where the camera's ray hits nothing
    Normal,
    /// The channel contains the distance from the camera to the visible surface along the ray, in scene units; it is 0
    /// where the ray hits nothing
    Depth,
    /// The channel contains the index of the visible instance among all instances of the scene, from 0; it is 0xFFFFFFFF
    /// where the camera's ray hits nothing
    Instance,
    /// The channels contain the vector in the picture, in pixels, from the visible surface point to the position that it
    /// had in the previous frame; right and down are positive
    Motion,
    /// The channels show what the reservoir of direct light of each pixel contains after the last frame: its weight,
    /// confidence, age, light and number of merged neighbours, the pixel that drew its sample, and, as 'jacobian', the solid
    /// angle under which this pixel's surface sees a small area around the sample, divided by the one under which the
    /// surface that drew the sample saw it; no weight contains this ratio
    Direct,
    /// The channels show what the reservoir of indirect light of each pixel contains after the last frame, with the same
    /// quantities as 'direct'
    Indirect,
}

impl Aov {
    /// The kind of light, direct or indirect, whose reservoirs these channels show; `None` for channels that show the
    /// visible surface. Channels of reservoirs are refused if the settings make no reservoirs of this kind.
    pub const fn reservoirs_of(self) -> Option<Lighting> {
        match self {
            Self::Direct => Some(Lighting::Direct),
            Self::Indirect => Some(Lighting::Indirect),
            Self::Albedo | Self::Normal | Self::Depth | Self::Instance | Self::Motion => None,
        }
    }
}

impl SceneArgs {
    /// The settings of the run: those of the preset, changed by the file of `--config` and then by `--set`. The second
    /// value lists the dotted keys, such as `direct.mode`, that the file and `--set` change, so that the user can be told
    /// which of them have no effect.
    ///
    /// # Errors
    /// A preset, key or value is unknown, the file cannot be read or is not TOML, or `--exposure` is not finite.
    pub fn settings(&self) -> Result<(Settings, Vec<String>)> {
        if !self.exposure.is_finite() {
            return Err(Error::input("--exposure takes a finite number of stops"));
        }
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

    /// Checks, before long work begins, that the pictures with the paths `outputs` and the file of `--report` can be
    /// written, and that none of these files is also another output or an input.
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

    /// The way in which PNG files show radiance, by `--exposure` and `--tonemap`.
    pub fn look(&self) -> Look {
        Look {
            exposure: self.exposure,
            curve: self.tonemap.curve(),
        }
    }

    /// The files that the command reads, each as (role in messages, path): the scene, the environment and the settings
    /// of `--config`. No output may be one of them. Procedural scenes and generated skies are not files and are left
    /// out.
    pub fn inputs(&self) -> impl Iterator<Item = (&str, &Path)> {
        let scene = file_of(&self.view.scene).map(|path| ("the scene", path));
        let environment = self
            .view
            .environment
            .as_deref()
            .and_then(environment_file_of);
        let environment = environment.map(|path| ("--environment", path));
        let config = self.config.as_deref().map(|path| ("--config", path));
        [scene, environment, config].into_iter().flatten()
    }
}

impl ViewArgs {
    /// The clock of the run, which maps the index of a frame to the time in the scene that the frame shows: `--start-time`
    /// for frame 0, and 1 / `fps` seconds more for each further frame. Without `fps`, all frames show the same time.
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

    /// Width and height of the picture in pixels, from `--width` and `--height`. A side that is not given is computed from
    /// the aspect ratio of `camera`; if both are not given, the width is 1280.
    ///
    /// # Errors
    /// A side is 0, or the picture has more than 2²⁸ pixels.
    pub fn size(&self, camera: &Camera) -> Result<(u32, u32)> {
        size_for(camera, self.width, self.height)
    }

    /// The aspect ratio (width ÷ height) of a picture whose camera states none.
    pub fn aspect(&self) -> f64 {
        match (self.width, self.height) {
            (Some(width @ 1..), Some(height @ 1..)) => f64::from(width) / f64::from(height),
            _ => DEFAULT_ASPECT,
        }
    }

    /// The camera that the value of `--look-at` describes; it replaces the cameras of the scene. `None` if the option
    /// is not given. Returns an error if the value describes no camera.
    pub fn look_at_camera(&self) -> Result<Option<Camera>> {
        self.look_at
            .as_deref()
            .map(|text| parse_look_at("--look-at", text))
            .transpose()
    }
}

/// The camera that `text` describes by six or seven numbers, separated by commas: the coordinates of the eye and of the
/// target, in scene units, and the vertical field of view in degrees, by default 45. Error messages call the text
/// `origin`, such as `--look-at`.
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

/// Width and height of a picture in pixels. A side that is `None` is computed from the aspect ratio of `camera`, or 16:9
/// if the camera has none. If both are `None`, the width is 1280.
///
/// # Errors
/// A side is 0, or the picture has more than 2²⁸ pixels.
pub fn size_for(camera: &Camera, width: Option<u32>, height: Option<u32>) -> Result<(u32, u32)> {
    let aspect = camera.aspect_ratio.unwrap_or(DEFAULT_ASPECT);
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

/// Checks, before work begins, that each file in `written` can be written, and that it is not the same file as another
/// one in `written` or in `read`. Each entry is (role in messages, path); the role is an option, such as `--output`, or a
/// phrase, such as "the scene".
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

/// Checks that no output is also another output or an input, because it would overwrite that file. `files` lists all
/// outputs, then all inputs, each as (role in messages, path); `written` is the number of outputs.
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
