//! A session: a scene on an open device, ready to be rendered as command-line arguments describe it. The commands
//! `render`, `reference`, `profile` and `regress` make their frames with one. Its functions for cameras, pictures and
//! profiles are in `session/`.

mod cameras;
mod lens;
mod opened_scene;
mod picture;
mod profiling;

pub use cameras::camera_text;
pub use opened_scene::{OpenedScene, Purpose, Shown};

use super::arguments::SceneArgs;
use super::interrupt::Interrupt;
use super::{check_messages, notice};
use crate::Result;
use crate::base::progress::Watch;
use crate::device_scene::selection::Selection;
use crate::device_scene::{GpuScene, shaders};
use crate::gpu::{Device, Instance, PassTime};
use crate::render::settings::Variant;
use crate::render::{Clock, Renderer, ResolvedSettings, Settings, Tracking, View};
use crate::scene::MovingCamera;
use picture::check_aovs;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The target duration of one call of [`Session::add_samples`]. It is short, so that a signal is noticed soon, and so
/// that no driver takes a long submission for a hang of the device.
const SUBMISSION: Duration = Duration::from_millis(300);

/// A scene on an open device, with the settings and the view with which it is rendered. The commands render its frames
/// through this value, and get pictures, reports and profiles from it.
pub struct Session {
    /// All settings, from the preset, `--config` and `--set`, by which the frames are rendered. A setting that was
    /// `auto` has the value that was chosen for this scene.
    pub settings: ResolvedSettings,
    /// The view: the camera, the size of the picture, the seed, the maximum number of scattering events, and
    /// whether the camera's rays go through random points of the pixels.
    pub view: View,
    /// The renderer of the view: its passes (compute shaders) and their buffers, among them the sums of the radiance of all
    /// samples, from which pictures are made.
    pub renderer: Renderer,
    /// The device on which the scene is rendered.
    pub device: Arc<Device>,
    instance: Arc<Instance>,
    gpu_scene: Arc<GpuScene>,
    selection: Selection,
    scene_hash: String,
    /// The hash of the shaders in the folder of `HEADWATER_GLSL` when the session was opened; `None` if the variable is not set.
    edited_shaders: Option<String>,
    /// The clock, which gives for the index of a frame the time in the scene that the frame shows. The scene is moved to
    /// this time before the frame is rendered, and pictures store the clock in their metadata. `None` if nothing in the
    /// scene moves.
    clock: Option<Clock>,
    /// The scene's camera with its motion; while the clock runs, each frame is rendered with the camera of its time. `None`
    /// for a camera that does not belong to the scene, and so does not move.
    camera: Option<MovingCamera>,
    /// True if pictures have an alpha channel, by `--alpha`.
    has_alpha: bool,
    /// The names of the passes whose shaders rejected values, such as NaN, with the number of values; set by
    /// [`Self::picture`].
    rejected: Vec<(String, u32)>,
    /// The time of each pass when it ran for the first time; one entry per pass. The report lists them apart from
    /// `times`, because they may include the compilation of the shader.
    first_runs: Vec<PassTime>,
    /// The time of each pass, for the report: in the last frame or, with path tracing, in the last call of
    /// [`Self::add_samples`]. A pass that ran for the first time in this frame or call is left out, because `first_runs` has
    /// its time. The entries have the order in which the passes ran.
    times: Vec<PassTime>,
    opened: Instant,
    samples_a_submission: u32,
}

impl Session {
    /// Loads the scene, opens the device, uploads the scene, and makes the renderer. `frames` are the indices of the frames
    /// that the user will see. If the scene is black in all of them, a notice says why.
    ///
    /// # Errors
    /// Wrong arguments or input, no usable device, a device that fails, or a signal.
    pub fn open(
        args: &SceneArgs,
        settings: Settings,
        clock: Clock,
        purpose: Purpose,
        frames: Range<u32>,
        interrupt: &Interrupt,
    ) -> Result<Self> {
        check_aovs(&args.aov, &settings, args.view.bounces)?;
        let shown = Shown {
            scatters: settings.scatters_light(args.view.bounces),
            environment: settings.environment,
            clock,
            clock_is_given: true,
            frames,
        };
        let scene = OpenedScene::open(&args.view, &shown, purpose, interrupt)?;
        Self::of(scene, args, settings)
    }

    /// Makes a session from a scene that is already open: resolves the settings for this scene, and makes the
    /// renderer.
    ///
    /// # Errors
    /// `--aov` does not fit the settings, or the device fails.
    pub fn of(scene: OpenedScene, args: &SceneArgs, settings: Settings) -> Result<Self> {
        check_aovs(&args.aov, &settings, args.view.bounces)?;
        let gpu_scene = &scene.gpu_scene;
        let [required, left_out] = gpu_scene.requirements.features();
        log::info!("required: {}", required.join(", "));
        log::info!(
            "{}: {}",
            match settings.variant {
                Variant::Full => "compiled all the same (variant=full)",
                Variant::Auto => "left out",
            },
            left_out.join(", ")
        );
        let wanted = settings.indirect.secondary;
        let settings = ResolvedSettings::new(&settings, gpu_scene, scene.view.bounces);
        if settings.indirect.secondary != wanted {
            notice(
                "without rare ones, the scene has fewer lights than world_reservoirs.min_lights, or one emitter group alone, so indirect.secondary is ris; world_reservoirs.min_lights=0 keeps world reservoirs",
            );
        }
        let tracking = Tracking {
            origins: args.aov.iter().any(|aov| aov.reservoirs_of().is_some()),
            coverage: args.alpha,
            ..Tracking::default()
        };
        let uploaded = gpu_scene.clone();
        let renderer =
            Renderer::tracking(&scene.device, uploaded, &scene.view, &settings, tracking)?;
        let OpenedScene {
            view,
            device,
            instance,
            gpu_scene,
            selection,
            scene_hash,
            edited_shaders,
            clock,
            camera,
            black: _,
            diagonal: _,
            opened,
        } = scene;
        Ok(Self {
            settings,
            view,
            renderer,
            device,
            instance,
            gpu_scene,
            selection,
            scene_hash,
            edited_shaders,
            clock,
            camera,
            has_alpha: args.alpha,
            rejected: Vec::new(),
            first_runs: Vec::new(),
            times: Vec::new(),
            opened,
            samples_a_submission: 1,
        })
    }

    /// True if pictures have an alpha channel, by `--alpha`.
    pub fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// The index of the first frame that must be rendered so that frame `index` is correct. If frames reuse data of earlier
    /// frames, it is 0. Otherwise it is `index` itself, except that in a scene that moves from frame to frame it is the
    /// index of the previous frame, if there is one, because motion vectors need the positions in that frame.
    pub fn first_needed_for(&self, index: u32) -> u32 {
        if self.renderer.has_history() {
            return 0;
        }
        // Motion is told from one frame to the next.
        let runs = self.running_clock().is_some();
        index - u32::from(runs && index > 0)
    }

    /// Renders frame `index` as history (data that later frames reuse), without adding it to the accumulated sums. If frames
    /// do not reuse data of earlier frames, this renders nothing, and only moves the scene to the time of the frame.
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at that frame's time.
    pub fn skip_frame(&mut self, index: u32) -> Result<()> {
        self.set_clock(index)?;
        let times = self.renderer.skip_frame(index)?;
        self.keep_times(times);
        Ok(())
    }

    /// Renders frame `index` alone, for a picture of one frame instead of the mean of several. With resampling, the
    /// accumulated sums stay unchanged. With path tracing, they are set to zero first, and then contain this frame only.
    fn single_frame(&mut self, index: u32) -> Result<()> {
        self.set_clock(index)?;
        let times = self.renderer.single_frame(index)?;
        self.keep_times(times);
        Ok(())
    }

    /// Restarts the renderer: it forgets the data of earlier frames, and its sums of radiance are 0. From now on each pass
    /// is submitted separately, and after it every buffer that it may write is hashed, so that a regression test finds the
    /// first pass whose results differ.
    ///
    /// # Errors
    /// The device fails, or the session is not for [`Purpose::Regression`].
    pub fn restart_with_hashes(&mut self) -> Result<()> {
        self.renderer.restart(self.view.seed)?;
        self.device.hash_outputs()
    }

    /// Renders frame `index`. If `accumulates` is true, its radiance is added to the accumulated sums, so that the picture
    /// is the mean of several frames. Otherwise the frame is rendered alone, for a picture of one frame.
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at that frame's time.
    pub fn frame(&mut self, index: u32, accumulates: bool) -> Result<()> {
        match accumulates {
            true => self.add_samples(index, 1, &mut |_| Ok(())).map(drop),
            false => self.single_frame(index),
        }
    }

    /// Stores the times of the passes of one frame, or of one call of [`Self::add_samples`], for the report. `times` has
    /// one entry per run of a pass; the times of one pass are summed. Passes that ran for the first time, which may include
    /// compilation, are stored separately.
    fn keep_times(&mut self, times: Vec<PassTime>) {
        let times = PassTime::by_name(times).into_iter();
        let (first, rest) = times.partition(|time| time.first_run);
        PassTime::add(&mut self.first_runs, first);
        self.times = rest;
    }

    /// The clock if frames show different times, so that the scene must be moved before each frame; `None` if the clock
    /// is stopped (has no frames per second), or if nothing in the scene moves.
    pub fn running_clock(&self) -> Option<Clock> {
        self.clock.filter(|clock| clock.fps.is_some())
    }

    /// Moves the scene and its camera to the time of frame `index`, and returns true. If all frames show the same time,
    /// changes nothing and returns false.
    fn set_clock(&mut self, index: u32) -> Result<bool> {
        let Some(clock) = self.running_clock() else {
            return Ok(false);
        };
        let time = clock.time(index);
        self.renderer.set_moment(time, self.camera.as_ref())?;
        Ok(true)
    }

    /// Adds at most `samples` samples to every pixel, and returns the number of samples that it added. The index of the
    /// first added sample is `first`. If the scene moves, a call adds one sample; otherwise it adds as many as take about
    /// 0.3 s, estimated from earlier calls. The division into calls changes no bit of the sums. `watch` is told the number
    /// of samples that this call has finished, with fractions; if it returns an error, the work ends.
    ///
    /// # Errors
    /// The device fails, the scene cannot be rendered at the time of frame `first`, or the errors of `watch`, after which
    /// the sums are invalid.
    pub fn add_samples(&mut self, first: u32, samples: u32, watch: &mut Watch<'_>) -> Result<u32> {
        let most = if self.set_clock(first)? {
            1
        } else {
            self.samples_a_submission
        };
        let samples = samples.min(most);
        let start = Instant::now();
        let mut watch = |fraction: f64| watch(fraction * f64::from(samples));
        let added = self
            .renderer
            .add_samples_watched(first, samples, &mut watch);
        self.keep_times(added?);
        let each = start.elapsed().as_secs_f64() / f64::from(samples);
        // The first submission holds the shader's compilation; growth is bounded for its sake.
        let fitting = (SUBMISSION.as_secs_f64() / each.max(1e-9)) as u32;
        self.samples_a_submission = fitting.clamp(1, self.samples_a_submission * 4);
        Ok(samples)
    }

    /// Ends the session in three steps. First, prints a notice for each edited shader file in the folder `HEADWATER_GLSL`
    /// that no pass of this run has used. Then closes the session. At last, checks that the validation layers have sent no
    /// messages, because closing can cause some too.
    ///
    /// # Errors
    /// The validation layers have sent messages, or that folder cannot be read.
    pub fn finish(self) -> Result<()> {
        // In a single frame every pass runs for the first time.
        let (times, when) = match self.times.is_empty() {
            true => (&self.first_runs, "with their compilation"),
            false => (&self.times, "in the last submission"),
        };
        let passes: Vec<String> = (times.iter())
            .map(|time| format!("{} {:.1} ms", time.name, time.milliseconds))
            .collect();
        log::info!("passes {when}: {}", passes.join(", "));
        for file in shaders::changes_without_effect()? {
            notice(&format!(
                "no pass of this run uses {file}, so its change in HEADWATER_GLSL has no effect"
            ));
        }
        let instance = self.instance.clone();
        drop(self);
        check_messages(&instance.validation_messages())
    }

    /// The report of the run as a JSON object, which `--report` writes: the scene, the settings, the device, what the
    /// program chose (such as the tracer) and why, times, and memory. `samples` is the number of samples per pixel of the
    /// picture. In the object, `first_runs` holds the time of each pass when it ran for the first time, which may include
    /// compilation. `last_submission` holds the times of the passes in the last submission, except for those that ran for
    /// the first time in it.
    ///
    /// # Errors
    /// A setting has no JSON form, which does not happen with finite values.
    pub fn report(&self, samples: u32) -> Result<Value> {
        let info = &self.device.info;
        let memory: serde_json::Map<String, Value> = self
            .gpu_scene
            .memory()
            .into_iter()
            .chain(self.renderer.light_bvh_memory())
            .map(|(name, bytes)| (name.to_owned(), json!(bytes)))
            .collect();
        Ok(json!({
            "version": 2,
            "scene": self.scene_hash,
            "settings": self.settings.to_value()?,
            "device": info.name,
            "driver": info.driver,
            "tracer": self.selection.variant.tracer.name(),
            "tracer_reason": self.selection.tracer_reason,
            "geometry": self.selection.variant.geometry.name(),
            "geometry_reason": self.selection.geometry_reason,
            "fetch": self.selection.variant.fetch.name(),
            "fetch_reason": self.selection.fetch_reason,
            "textures": self.selection.variant.textures.name(),
            "textures_reason": self.selection.textures_reason,
            "width": self.view.width,
            "height": self.view.height,
            "seed": self.view.seed,
            "bounces": self.view.bounces,
            "samples": samples,
            "rejected_values": self.rejected.iter().map(|(_, count)| u64::from(*count)).sum::<u64>(),
            "rejected_by_pass": self.rejected.iter().cloned().collect::<BTreeMap<String, u32>>(),
            "seconds": self.opened.elapsed().as_secs_f64(),
            "first_runs": self.first_runs,
            "last_submission": self.times,
            "scene_bytes": memory,
        }))
    }
}
