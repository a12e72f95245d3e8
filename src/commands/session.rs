//! A session: a scene on an open device, ready to be rendered, made from command-line arguments. Its functions for cameras,
//! pictures and profiles are in `session/`.

mod cameras;
mod picture;
mod profiling;

use super::arguments::SceneArgs;
use super::choices::TexturesArg;
use super::interrupt::Interrupt;
use super::{NOTHING_WRITTEN, apply_clock, check_messages, notice, open_scene, open_vulkan};
use crate::Result;
use crate::base::progress::Watch;
use crate::device_scene::selection::{self, Request, Selection};
use crate::device_scene::{GpuScene, SceneSizes, shaders};
use crate::gpu::{Device, Features, Instance, InstanceOptions, PassTime};
use crate::render::settings::Variant;
use crate::render::{Clock, Renderer, ResolvedSettings, Settings, Tracking, View};
use crate::scene::{Environment, MovingCamera};
use cameras::choose_camera;
use picture::check_aovs;
use serde_json::{Value, json};
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The target duration of one submission to the device: short enough that a signal is noticed soon and that no driver
/// assumes that the device hangs.
const SUBMISSION: Duration = Duration::from_millis(300);

/// The number of triangles from which on a line on stderr announces that trees over the triangles are built, because this
/// takes several seconds.
const MANY_TRIANGLES: u64 = 2_000_000;

/// The purpose of a session, which decides the features that its device is opened with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Pictures for files, with no feature besides those that rendering needs.
    Pictures,
    /// Frames for a capture tool, which records the calls of the device. The device is opened for
    /// [`Presentation`](crate::gpu::Presentation), and uses no feature that the tool cannot replay.
    Capture,
    /// A profile. The reports of the driver's compiler about shaders are kept for
    /// [`Records::compiled`](crate::gpu::records::Records::compiled).
    Profile,
    /// A regression test. The outputs of passes can be hashed for
    /// [`Records::take_outputs`](crate::gpu::records::Records::take_outputs).
    Regression {
        /// True if the validation layers are loaded, with synchronization validation.
        validate: bool,
    },
}

/// A scene on an open device, with the settings and the view of its picture, ready to render frames.
pub struct Session {
    /// The settings from the preset, `--config` and `--set`, in which the choice for this scene replaces each `auto`.
    pub settings: ResolvedSettings,
    /// The camera, the size of the picture, the seed, and the sampling of paths.
    pub view: View,
    /// The passes and buffers that render the view, and the sums of its samples.
    pub renderer: Renderer,
    /// The device on which the scene is rendered.
    pub device: Arc<Device>,
    instance: Arc<Instance>,
    gpu_scene: Arc<GpuScene>,
    selection: Selection,
    scene_hash: String,
    /// The time that each frame shows; `None` if nothing in the scene moves.
    clock: Option<Clock>,
    /// The motion of the scene's camera, which each frame follows while the clock runs. `None` for a camera that is not of
    /// the scene.
    camera: Option<MovingCamera>,
    rejected: u32,
    /// The time of each pass in its first run, which may include its compilation; one entry per pass.
    first_runs: Vec<PassTime>,
    /// The total time of each pass in the last submission, without first runs; one entry per pass, in the order in which
    /// they ran.
    times: Vec<PassTime>,
    opened: Instant,
    samples_a_submission: u32,
}

impl Session {
    /// Loads the scene, opens the device, and uploads the scene. `frames` are the indices of the frames that pictures will
    /// show, for a notice if the scene is black in all of them.
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
        let opened = Instant::now();
        let captured = purpose == Purpose::Capture;
        let validates = purpose == Purpose::Regression { validate: true };
        check_aovs(&args.aov, &settings, args.bounces)?;
        let camera_override = args.look_at_camera()?;
        let mut scene = open_scene(&args.scene, args.load.options(), interrupt)?;
        for text in &scene.notices {
            notice(text);
        }
        if let Some(name) = &args.environment {
            scene.environment = Some(Environment {
                rotation: settings.environment.rotation,
                intensity: settings.environment.intensity,
                ..Environment::open(name)?
            });
        }
        let moves = scene.motion.is_some();
        let scene_hash = scene.content_hash();
        // What does not shine now may do so at another time: as long as the scene still moves, that is known.
        let times = frames.map(|frame| clock.time(frame));
        let black = scene.why_black(settings.scatters_light(args.bounces), times);
        apply_clock(&clock, &mut scene, "")?;
        let (camera, followed) = match camera_override {
            Some(camera) => (camera, None),
            None => choose_camera(&scene, args.camera.as_deref(), clock.start_time)?,
        };
        let (width, height) = args.size(&camera)?;
        if let Some(why) = black {
            notice(why);
        }
        let instance = open_vulkan(InstanceOptions {
            validation: validates,
            presentation: captured,
        })?;
        let (info, reason) = instance.choose(args.device.as_deref())?;
        log::info!("device: {} ({reason})", info.name);
        let sizes = SceneSizes::of(&scene);
        let selection = selection::select(
            &info,
            Request {
                captured,
                ..args.variant.request()
            },
            &sizes,
        )?;
        let variant = selection.variant;
        if args.variant.textures == TexturesArg::Images && sizes.images.count == 0 {
            notice("the scene has no images, so --textures images has no effect");
        }
        log::info!(
            "tracer: {} ({}); geometry: {} ({}); fetch: {} ({}); textures: {} ({})",
            variant.tracer.name(),
            selection.tracer_reason,
            variant.geometry.name(),
            selection.geometry_reason,
            variant.fetch.name(),
            selection.fetch_reason,
            variant.textures.name(),
            selection.textures_reason
        );
        let features = Features {
            presentation: captured && instance.presents(&info),
            hashed_outputs: matches!(purpose, Purpose::Regression { .. }),
            executable_properties: purpose == Purpose::Profile && info.executable_properties,
            ..selection.features()
        };
        shaders::check_folder(variant)?;
        let device = Device::open(&instance, info, features)?;
        let origin = camera.camera_to_world.translation;
        for limit in scene.limits(&[origin]).iter().filter(|l| l.passed) {
            notice(&limit.text);
        }
        if sizes.triangles >= MANY_TRIANGLES {
            super::say(format_args!(
                "building trees over {} triangles",
                sizes.triangles
            ));
        }
        interrupt.check(NOTHING_WRITTEN)?;
        let gpu_scene = Arc::new(GpuScene::new(&device, &scene, origin, selection.variant)?);
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
        interrupt.check(NOTHING_WRITTEN)?;
        let view = View {
            camera,
            width,
            height,
            seed: args.seed,
            bounces: args.bounces,
            jitter: args.jitter,
        };
        let wanted = settings.indirect.secondary;
        let settings = ResolvedSettings::new(&settings, &gpu_scene, view.bounces);
        if settings.indirect.secondary != wanted {
            notice(
                "without rare ones, the scene has fewer lights than world_reservoirs.min_lights, or one emitter group alone, so indirect.secondary is ris; world_reservoirs.min_lights=0 keeps world reservoirs",
            );
        }
        let tracking = Tracking {
            origins: args.aov.iter().any(|aov| aov.reservoirs_of().is_some()),
            ..Tracking::default()
        };
        let uploaded = gpu_scene.clone();
        let renderer = Renderer::tracking(&device, uploaded, &view, &settings, tracking)?;
        Ok(Self {
            settings,
            view,
            renderer,
            device,
            instance,
            gpu_scene,
            selection,
            scene_hash,
            clock: moves.then_some(clock),
            camera: followed.map(|index| MovingCamera::of(&scene, index)),
            rejected: 0,
            first_runs: Vec::new(),
            times: Vec::new(),
            opened,
            samples_a_submission: 1,
        })
    }

    /// The index of the first frame that must be rendered so that frame `index` is correct. It is 0 if frames depend on
    /// those before them. If only the clock runs, it is the index of the previous frame, because motion is the difference of
    /// two frames. Otherwise it is `index` itself.
    pub fn first_needed_for(&self, index: u32) -> u32 {
        if self.renderer.has_history() {
            return 0;
        }
        // Motion is told from one frame to the next.
        let runs = self.running_clock().is_some();
        index - u32::from(runs && index > 0)
    }

    /// Renders frame `index` only as the history of later frames, without adding it to the sums.
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at that frame's time.
    pub fn skip_frame(&mut self, index: u32) -> Result<()> {
        self.set_clock(index)?;
        let times = self.renderer.skip_frame(index)?;
        self.keep_times(times);
        Ok(())
    }

    /// Renders frame `index` alone, without adding it to the frames before it.
    fn single_frame(&mut self, index: u32) -> Result<()> {
        self.set_clock(index)?;
        let times = self.renderer.single_frame(index)?;
        self.keep_times(times);
        Ok(())
    }

    /// Restarts the renderer without history and sums. From now on each pass runs separately, and every buffer that it may
    /// write is hashed after it.
    ///
    /// # Errors
    /// The device fails, or the session is not for [`Purpose::Regression`].
    pub fn restart_with_hashes(&mut self) -> Result<()> {
        self.renderer.restart(self.view.seed)?;
        self.device.hash_outputs()
    }

    /// Renders frame `index`. It is added to the sums of the frames before it if `accumulates` is true, and otherwise
    /// rendered alone.
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at that frame's time.
    pub fn frame(&mut self, index: u32, accumulates: bool) -> Result<()> {
        match accumulates {
            true => self.add_samples(index, 1, &mut |_| Ok(())).map(drop),
            false => self.single_frame(index),
        }
    }

    /// Stores the times of the passes of a submission. First runs, which may include compilation, are stored separately.
    fn keep_times(&mut self, times: Vec<PassTime>) {
        let times = PassTime::by_name(times).into_iter();
        let (first, rest) = times.partition(|time| time.first_run);
        PassTime::add(&mut self.first_runs, first);
        self.times = rest;
    }

    /// The clock if frames show different times; `None` if it is stopped or nothing in the scene moves.
    fn running_clock(&self) -> Option<Clock> {
        self.clock.filter(|clock| clock.fps.is_some())
    }

    /// Sets the scene to the time of frame `index`, with its camera, and returns true. If all frames show the same time, it
    /// changes nothing and returns false.
    fn set_clock(&mut self, index: u32) -> Result<bool> {
        let Some(clock) = self.running_clock() else {
            return Ok(false);
        };
        let time = clock.time(index);
        self.renderer.set_moment(time, self.camera.as_ref())?;
        Ok(true)
    }

    /// Adds at most `samples` samples to every pixel, with indices from `first`, and returns the number of added samples.
    /// One call is one submission, whose length follows from the times of earlier ones; this division changes no bit of the
    /// sums. `watch` receives the number of finished samples, with fractions, and can end the work by an error.
    ///
    /// # Errors
    /// The device fails, the scene cannot be rendered at that frame's time, or the errors of `watch`, after which the sums
    /// are invalid.
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

    /// Closes the session, and then checks the messages of the validation layers, because closing may cause some too.
    ///
    /// # Errors
    /// The validation layers have sent messages, or the folder of changed shaders (`HEADWATER_GLSL`) cannot be read.
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

    /// A description of the run as a JSON object, which `--report` writes. `samples` is the number of samples per pixel.
    /// Since version 2, first runs of passes are separate from `last_submission`.
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
            "rejected_values": self.rejected,
            "seconds": self.opened.elapsed().as_secs_f64(),
            "first_runs": self.first_runs,
            "last_submission": self.times,
            "scene_bytes": memory,
        }))
    }
}
