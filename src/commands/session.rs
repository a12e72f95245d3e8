//! From arguments to a scene on an open device, ready to be rendered.

use super::arguments::{Aov, SceneArgs};
use super::interrupt::Interrupt;
use super::{NOTHING_WRITTEN, apply_clock, check_messages, notice, open_scene, open_vulkan};
use crate::gpu::device::MemoryUse;
use crate::gpu::{
    Compiled, Device, Features, Instance, InstanceOptions, Label, Output, PassTime, Presentation,
};
use crate::image::{Image, Samples};
use crate::layouts::{MAX_RADIANCE, ReservoirAov};
use crate::profile::{Circumstances, Frame, Plan, Subject, measure};
use crate::render::counters::Counts;
use crate::render::outputs::Sums;
use crate::render::settings::Variant;
use crate::render::{Clock, Kind, Renderer, Settings, Tracking, View};
use crate::scene::camera::framing_camera;
use crate::scene::{Camera, Environment, MovingCamera, Scene};
use crate::tracing::selection::{self, Selection, TexturesChoice, Wanted};
use crate::tracing::{GpuScene, SceneSizes};
use crate::{Error, Result};
use glam::DVec3;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long one submission should take: short enough that a signal is noticed soon and that no
/// driver thinks the device hangs.
const SUBMISSION: Duration = Duration::from_millis(300);

/// Triangles whose trees take more than some seconds to build.
const MANY_TRIANGLES: u64 = 2_000_000;

/// What a session is for, besides pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Nothing.
    Pictures,
    /// A tool captures what the device does: it is opened for [`Session::presentation`], and uses nothing that cannot be
    /// replayed.
    Capture,
    /// What the driver's compiler says of shaders is kept for [`Session::compiled`].
    Profile,
    /// What passes write is hashed for [`Session::take_outputs`].
    Regression {
        /// Whether the validation layers watch.
        validate: bool,
    },
}

/// A scene on an open device, and what its picture is made with.
pub struct Session {
    /// The settings after preset, file and single changes.
    pub settings: Settings,
    /// What is seen.
    pub view: View,
    /// The passes and buffers.
    pub renderer: Renderer,
    device: Arc<Device>,
    instance: Arc<Instance>,
    gpu_scene: Arc<GpuScene>,
    selection: Selection,
    scene_hash: String,
    /// What time it is, for scenes that move.
    clock: Option<Clock>,
    /// The camera, where it moves while the clock runs.
    camera: Option<MovingCamera>,
    rejected: u32,
    /// What each pass took when it ran for the first time.
    first_runs: Vec<PassTime>,
    /// What passes took in the last submission, but for first runs.
    times: Vec<PassTime>,
    opened: Instant,
    samples_a_submission: u32,
}

impl Session {
    /// Loads the scene, opens the device, uploads.
    ///
    /// # Errors
    /// Wrong arguments or input, a device that fails, or a signal.
    pub fn open(
        args: &SceneArgs,
        settings: Settings,
        clock: Clock,
        purpose: Purpose,
        interrupt: &Interrupt,
    ) -> Result<Self> {
        let opened = Instant::now();
        let captured = purpose == Purpose::Capture;
        let validates = purpose == Purpose::Regression { validate: true };
        check_aovs(&args.aov, &settings, args.bounces)?;
        let own_camera = args.look_at_camera()?;
        let mut scene = open_scene(&args.scene, args.load, interrupt)?;
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
        apply_clock(&clock, &mut scene, "")?;
        let (camera, followed) = match own_camera {
            Some(camera) => (camera, None),
            None => choose_camera(&scene, args.camera.as_deref(), clock.start_time)?,
        };
        let (width, height) = args.size(&camera)?;
        if !scene.is_lit() && !scene.materials.iter().any(|material| material.unlit) {
            notice(
                "the scene has no light, so the picture is black; --environment sky:sun=40 lights it",
            );
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
            Wanted {
                captured,
                ..args.wanted()
            },
            &sizes,
        )?;
        let variant = selection.variant;
        if args.textures == TexturesChoice::Images && sizes.images.count == 0 {
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
        let device = Device::open(&instance, info, features)?;
        let origin = camera.camera_to_world.translation;
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
        let settings = settings.for_scene(&gpu_scene, view.bounces);
        if settings.indirect.secondary != wanted {
            notice(
                "the scene has too few lights for world reservoirs to gain anything, so indirect.secondary is ris; world_reservoirs.min_lights=0 has them all the same",
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

    /// The first frame that must be rendered so that frame `number` is what it should be.
    pub fn first_needed_for(&self, number: u32) -> u32 {
        if self.renderer.has_history() {
            return 0;
        }
        // Motion is told from one frame to the next.
        let runs = self.clock.as_ref().is_some_and(|clock| clock.fps.is_some());
        number - u32::from(runs && number > 0)
    }

    /// Renders a frame for the sake of those that follow.
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at that frame's time.
    pub fn skip_frame(&mut self, number: u32) -> Result<()> {
        self.set_clock(number)?;
        let times = self.renderer.skip_frame(number)?;
        self.keep_times(times);
        Ok(())
    }

    /// Renders a frame by itself, for [`Renderer::show`] and [`Renderer::keep_single_frame`].
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at that frame's time.
    pub fn single_frame(&mut self, number: u32) -> Result<()> {
        self.set_clock(number)?;
        let times = self.renderer.single_frame(number)?;
        self.keep_times(times);
        Ok(())
    }

    /// Renders the frames of a plan and times them; `watch` is called before each, and may end the work.
    ///
    /// # Errors
    /// The device fails, the scene cannot be rendered at a frame's time, or those of `watch`.
    pub fn profile(
        &mut self,
        plan: Plan,
        watch: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Vec<Frame>> {
        let moments = self.moments();
        measure(
            &self.device,
            &mut self.renderer,
            plan,
            &mut |renderer, number| {
                watch()?;
                moments.show(renderer, number)
            },
        )
    }

    /// What the passes of frame `number` count, in a renderer of their own; `watch` as in [`Self::profile`].
    ///
    /// # Errors
    /// Those of [`Self::profile`].
    pub fn counts_of(
        &self,
        number: u32,
        watch: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Vec<Counts>> {
        let tracking = Tracking {
            counts: true,
            ..Tracking::default()
        };
        let (device, scene) = (&self.device, self.gpu_scene.clone());
        let mut renderer = Renderer::tracking(device, scene, &self.view, &self.settings, tracking)?;
        let moments = self.moments();
        for number in 0..=number {
            watch()?;
            moments.show(&mut renderer, number)?;
            // What was counted before the last frame is dropped.
            renderer.counts()?;
            renderer.single_frame(number)?;
        }
        renderer.counts()
    }

    /// What was profiled.
    ///
    /// # Errors
    /// Never with finite settings.
    pub fn subject(&self, plan: Plan) -> Result<Subject> {
        Ok(Subject {
            scene: self.scene_hash.clone(),
            settings: self.settings.to_value()?,
            device: self.device.info.name.clone(),
            width: self.view.width,
            height: self.view.height,
            bounces: self.view.bounces,
            seed: self.view.seed,
            camera: camera_text(&self.view.camera),
            clock: self.clock.map(|clock| (clock.start_time, clock.fps)),
            warm_up: plan.warm_up,
            frames: plan.frames,
        })
    }

    /// How it was profiled.
    pub fn circumstances(&self, plan: Plan) -> Circumstances {
        let variant = self.selection.variant;
        Circumstances {
            driver: self.device.info.driver.clone(),
            tracer: variant.tracer.name().into(),
            geometry: variant.geometry.name().into(),
            commit: env!("HEADWATER_COMMIT").into(),
            in_flight: plan.in_flight,
        }
    }

    /// What the driver made of the shaders.
    pub fn compiled(&self) -> Vec<Compiled> {
        self.device.compiled()
    }

    /// Begins anew, without history or sums. From now on, each pass runs by itself, and what it writes is hashed.
    ///
    /// # Errors
    /// The device fails, or the session is not for [`Purpose::Regression`].
    pub fn restart_with_hashes(&mut self) -> Result<()> {
        self.renderer.restart(self.view.seed)?;
        self.device.hash_outputs()
    }

    /// What passes wrote since the last call, in their order.
    pub fn take_outputs(&self) -> Vec<Output> {
        self.device.take_outputs()
    }

    /// What is allocated on the device now.
    pub fn memory_use(&self) -> MemoryUse {
        self.device.memory_use()
    }

    /// Labels what is submitted until the returned value is dropped.
    pub fn label(&self, name: &str) -> Label {
        self.device.label(name)
    }

    /// The tools between Headwater and the device, by name.
    pub fn tools(&self) -> Vec<String> {
        self.instance.tools(&self.device.info)
    }

    /// What presents pictures of this size.
    ///
    /// # Errors
    /// The device cannot present to a headless surface.
    pub fn presentation(&self) -> Result<Presentation> {
        Presentation::new(&self.device, (self.view.width, self.view.height))
    }

    /// Keeps what a submission took; first runs, which may hold compilation, by themselves.
    fn keep_times(&mut self, times: Vec<PassTime>) {
        let times = PassTime::by_name(times).into_iter();
        let (first, rest) = times.partition(|time| time.first_run);
        PassTime::add(&mut self.first_runs, first);
        self.times = rest;
    }

    /// The times of frames, and the camera at these.
    fn moments(&self) -> Moments {
        Moments {
            clock: self.clock.filter(|clock| clock.fps.is_some()),
            camera: self.camera.clone(),
        }
    }

    /// Shows the time of a frame; whether every frame has its own.
    fn set_clock(&mut self, number: u32) -> Result<bool> {
        let moments = self.moments();
        moments.show(&mut self.renderer, number)?;
        Ok(moments.clock.is_some())
    }

    /// Adds up to `samples` samples to every pixel, in one submission whose length follows from the
    /// time that earlier ones took. Returns how many were added. The split changes no bit. `watch` is
    /// told within large pictures how many samples are done, and can end the work by an error.
    ///
    /// # Errors
    /// The device fails, the scene cannot be rendered at that frame's time, or those of `watch`, after
    /// which the sums mean nothing.
    pub fn add_samples(
        &mut self,
        first: u32,
        samples: u32,
        watch: &mut dyn FnMut(f64) -> Result<()>,
    ) -> Result<u32> {
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

    /// The picture of `samples` samples a pixel with its metadata and the AOVs asked for.
    ///
    /// # Errors
    /// The device fails.
    pub fn picture(&mut self, sums: &Sums, samples: u32, aovs: &[Aov]) -> Result<Image> {
        let mut image = Image::new(self.view.width, self.view.height);
        let mean = sums.mean(samples.max(1));
        let values: Vec<_> = mean.iter().map(|p| p.as_vec3().to_array()).collect();
        image.set_vectors("", ["R", "G", "B"], &values);
        if !aovs.is_empty() {
            self.add_aovs(&mut image, aovs)?;
        }
        self.rejected = self.renderer.rejected()?;
        if self.rejected > 0 {
            notice(&format!(
                "{} values were refused because they were NaN, negative or beyond {MAX_RADIANCE:e} times the brightest light",
                self.rejected
            ));
        }
        let settings = self.settings.to_value()?.to_string();
        let info = &self.device.info;
        for (key, value) in [
            ("scene", self.scene_hash.clone()),
            ("settings", settings),
            ("device", info.name.clone()),
            ("driver", info.driver.clone()),
            ("tracer", self.selection.variant.tracer.name().into()),
            ("commit", env!("HEADWATER_COMMIT").into()),
            ("seed", self.view.seed.to_string()),
            ("bounces", self.view.bounces.to_string()),
            ("jitter", self.view.jitter.to_string()),
            ("camera", camera_text(&self.view.camera)),
            ("samples", samples.to_string()),
        ] {
            image.metadata.insert(format!("headwater.{key}"), value);
        }
        if let Some(Clock { start_time, fps }) = self.clock {
            let fps = fps.map(|fps| ("fps", fps));
            for (key, value) in fps.into_iter().chain([("start_time", start_time)]) {
                let (key, value) = (format!("headwater.{key}"), format!("{value:?}"));
                image.metadata.insert(key, value);
            }
        }
        Ok(image)
    }

    fn add_aovs(&mut self, image: &mut Image, aovs: &[Aov]) -> Result<()> {
        let surfaces = if aovs.iter().any(|aov| aov.reservoirs_of().is_none()) {
            self.renderer.primary_surfaces()?
        } else {
            Vec::new()
        };
        for aov in aovs {
            match aov {
                Aov::Direct => self.add_reservoir_aovs(image, Kind::Direct)?,
                Aov::Indirect => self.add_reservoir_aovs(image, Kind::Indirect)?,
                Aov::Albedo => {
                    let values: Vec<_> = surfaces.iter().map(|s| s.albedo.to_array()).collect();
                    image.set_vectors("albedo.", ["R", "G", "B"], &values);
                }
                Aov::Normal => {
                    let values: Vec<_> = surfaces.iter().map(|s| s.normal.to_array()).collect();
                    image.set_vectors("normal.", ["X", "Y", "Z"], &values);
                }
                Aov::Depth => {
                    let values = surfaces.iter().map(|s| s.depth).collect();
                    image
                        .channels
                        .insert("depth.Z".into(), Samples::F32(values));
                }
                Aov::Motion => {
                    for (axis, name) in ["motion.X", "motion.Y"].into_iter().enumerate() {
                        let values = surfaces.iter().map(|s| s.motion[axis]).collect();
                        image.channels.insert(name.into(), Samples::F32(values));
                    }
                }
                Aov::Instance => {
                    let values = surfaces.iter().map(|s| s.instance).collect();
                    image
                        .channels
                        .insert("instance.id".into(), Samples::U32(values));
                }
            }
        }
        Ok(())
    }

    fn add_reservoir_aovs(&self, image: &mut Image, kind: Kind) -> Result<()> {
        let reservoirs = self.renderer.reservoir_aovs(kind)?;
        let mut add = |name: &str, samples| {
            let name = format!("{}.{name}", kind.name());
            image.channels.insert(name, samples);
        };
        let floats =
            |value: fn(&ReservoirAov) -> f32| Samples::F32(reservoirs.iter().map(value).collect());
        add("weight", floats(|r| r.weight));
        add("confidence", floats(|r| r.confidence));
        add("age", floats(|r| r.age as f32));
        add("neighbours", floats(|r| r.neighbours as f32));
        add("source.X", floats(|r| r.source.x));
        add("source.Y", floats(|r| r.source.y));
        add("jacobian", floats(|r| r.jacobian));
        let lights = reservoirs.iter().map(|r| r.light).collect();
        add("light", Samples::U32(lights));
        Ok(())
    }

    /// Ends the session, and then checks the messages of the validation layers: the end may cause some too.
    ///
    /// # Errors
    /// There are any.
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
        let instance = self.instance.clone();
        drop(self);
        check_messages(&instance.validation_messages())
    }

    /// What was done, for `--report`; version 2 since first runs stand apart from `last_submission`.
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

/// The times of frames.
struct Moments {
    /// If frames have times of their own.
    clock: Option<Clock>,
    /// The camera, if it moves.
    camera: Option<MovingCamera>,
}

impl Moments {
    /// Sets time and camera of a frame.
    fn show(&self, renderer: &mut Renderer, number: u32) -> Result<()> {
        let Some(clock) = self.clock else {
            return Ok(());
        };
        let time = clock.time(number);
        renderer.set_time(time);
        if let Some(camera) = &self.camera {
            renderer.set_camera(&camera.at(time)?);
        }
        Ok(())
    }
}

/// Refuses AOVs of reservoirs that there are none of.
fn check_aovs(aovs: &[Aov], settings: &Settings, bounces: u32) -> Result<()> {
    for (kind, needed) in [
        (Kind::Direct, "--bounces of at least 1"),
        (
            Kind::Indirect,
            "indirect.mode=restir, --bounces of at least 2",
        ),
    ] {
        let shows = |aov: &Aov| aov.reservoirs_of() == Some(kind);
        if aovs.iter().any(shows) && !kind.has_reservoirs(settings, bounces) {
            return Err(Error::input(format!(
                "--aov {} shows reservoirs, of which there are none; they come of render with a --preset of integrator=restir, {needed}",
                kind.name()
            )));
        }
    }
    Ok(())
}

/// The camera that `wanted` names, as it is at a time; without it the first; without any one that
/// frames the scene. The scene's own come with their index.
fn choose_camera(
    scene: &Scene,
    wanted: Option<&str>,
    time: f64,
) -> Result<(Camera, Option<usize>)> {
    let own = |index: usize| Ok((scene.camera_at(index, time)?, Some(index)));
    let Some(wanted) = wanted else {
        if !scene.cameras.is_empty() {
            return own(0);
        }
        notice("the scene has no camera, so one was made that frames it; --look-at sets another");
        return Ok((framing_camera(scene), None));
    };
    let by_index = wanted.parse::<usize>().ok();
    let by_index = by_index.filter(|index| *index < scene.cameras.len());
    let by_name = || scene.cameras.iter().position(|c| c.name == wanted);
    by_index.or_else(by_name).map(own).unwrap_or_else(|| {
        let listed: Vec<String> = scene
            .cameras
            .iter()
            .enumerate()
            .map(|(i, c)| format!("{i} '{}'", c.name))
            .collect();
        Err(Error::input(format!(
            "no camera '{wanted}'; the scene has: {}",
            if listed.is_empty() {
                "none".into()
            } else {
                listed.join(", ")
            }
        )))
    })
}

/// A camera as text that tells any two apart.
fn camera_text(camera: &Camera) -> String {
    let place = camera.camera_to_world;
    let text = |v: DVec3| format!("{:?} {:?} {:?}", v.x, v.y, v.z);
    format!(
        "eye {}; back {}; up {}; vertical fov {:?}",
        text(place.translation),
        text(place.matrix3.z_axis),
        text(place.matrix3.y_axis),
        camera.vertical_fov
    )
}
