//! A session: from arguments to a scene on an open device, ready to be rendered; `session/` has its functions besides frames.

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

/// The target duration of one submission: short enough that a signal is noticed soon and that no driver assumes that the device
/// hangs.
const SUBMISSION: Duration = Duration::from_millis(300);

/// The number of triangles above which building the trees takes more than some seconds.
const MANY_TRIANGLES: u64 = 2_000_000;

/// The purposes of a session besides pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Pictures only.
    Pictures,
    /// A tool captures the calls of the device: it is opened for [`Presentation`](crate::gpu::Presentation), and uses no
    /// feature that cannot be replayed.
    Capture,
    /// The reports of the driver's compiler about shaders are kept for
    /// [`Records::compiled`](crate::gpu::records::Records::compiled).
    Profile,
    /// The outputs of passes are hashed for [`Records::take_outputs`](crate::gpu::records::Records::take_outputs).
    Regression {
        /// True if the validation layers are used.
        validate: bool,
    },
}

/// A scene on an open device, with the settings and the view of its picture.
pub struct Session {
    /// The settings after preset, file and single changes, for this scene.
    pub settings: ResolvedSettings,
    /// The view.
    pub view: View,
    /// The passes and buffers.
    pub renderer: Renderer,
    /// The device that renders.
    pub device: Arc<Device>,
    instance: Arc<Instance>,
    gpu_scene: Arc<GpuScene>,
    selection: Selection,
    scene_hash: String,
    /// The clock, for scenes that move.
    clock: Option<Clock>,
    /// The camera, if it moves while the clock runs.
    camera: Option<MovingCamera>,
    rejected: u32,
    /// The time of each pass in its first run.
    first_runs: Vec<PassTime>,
    /// The times of passes in the last submission, without first runs.
    times: Vec<PassTime>,
    opened: Instant,
    samples_a_submission: u32,
}

impl Session {
    /// Loads the scene, opens the device, uploads. Pictures will show `frames`.
    ///
    /// # Errors
    /// Wrong arguments or input, a device that fails, or a signal.
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

    /// The index of the first frame that must be rendered so that frame `number` is correct.
    pub fn first_needed_for(&self, number: u32) -> u32 {
        if self.renderer.has_history() {
            return 0;
        }
        // Motion is told from one frame to the next.
        let runs = self.running_clock().is_some();
        number - u32::from(runs && number > 0)
    }

    /// Renders a frame only as the history of later frames.
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at that frame's time.
    pub fn skip_frame(&mut self, number: u32) -> Result<()> {
        self.set_clock(number)?;
        let times = self.renderer.skip_frame(number)?;
        self.keep_times(times);
        Ok(())
    }

    /// Renders a frame alone.
    fn single_frame(&mut self, number: u32) -> Result<()> {
        self.set_clock(number)?;
        let times = self.renderer.single_frame(number)?;
        self.keep_times(times);
        Ok(())
    }

    /// Restarts without history and sums. From now on, each pass runs separately, and its outputs are hashed.
    ///
    /// # Errors
    /// The device fails, or the session is not for [`Purpose::Regression`].
    pub fn restart_with_hashes(&mut self) -> Result<()> {
        self.renderer.restart(self.view.seed)?;
        self.device.hash_outputs()
    }

    /// Renders a frame: added to the frames before it, or alone.
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at that frame's time.
    pub fn frame(&mut self, number: u32, accumulates: bool) -> Result<()> {
        match accumulates {
            true => self.add_samples(number, 1, &mut |_| Ok(())).map(drop),
            false => self.single_frame(number),
        }
    }

    /// Stores the times of a submission, with first runs, which may include compilation, stored separately.
    fn keep_times(&mut self, times: Vec<PassTime>) {
        let times = PassTime::by_name(times).into_iter();
        let (first, rest) = times.partition(|time| time.first_run);
        PassTime::add(&mut self.first_runs, first);
        self.times = rest;
    }

    /// The clock, if frames show different times.
    fn running_clock(&self) -> Option<Clock> {
        self.clock.filter(|clock| clock.fps.is_some())
    }

    /// Sets the time and the camera of a frame; returns true if frames show different times.
    fn set_clock(&mut self, number: u32) -> Result<bool> {
        let Some(clock) = self.running_clock() else {
            return Ok(false);
        };
        let time = clock.time(number);
        self.renderer.set_moment(time, self.camera.as_ref())?;
        Ok(true)
    }

    /// Adds up to `samples` samples to every pixel, in one submission whose length follows from the times of earlier ones.
    /// Returns the number of samples that were added. The split changes no bit. `watch` receives the number of finished samples
    /// within large pictures, and can end the work by an error.
    ///
    /// # Errors
    /// The device fails, the scene cannot be rendered at that frame's time, or the errors of `watch`, after which the sums are
    /// invalid.
    pub fn add_samples(&mut self, first: u32, samples: u32, watch: &mut Watch<'_>) -> Result<u32> {
        let most = if self.set_clock(first)? {
            1
        } else {
            self.samples_a_submission
        };
        let samples = samples.min(most);
        let start = Instant::now();
        let mut watch = |share: f64| watch(share * f64::from(samples));
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

    /// Ends the session, and then checks the messages of the validation layers: the end may cause some too.
    ///
    /// # Errors
    /// There are messages.
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

    /// A description of the run for `--report`; version 2 since first runs are separate from `last_submission`.
    ///
    /// # Errors
    /// Never with finite settings.
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
