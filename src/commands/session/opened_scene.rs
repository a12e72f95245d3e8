//! A scene that was loaded and uploaded to a device, before a renderer is made for it.

use super::cameras::choose_camera;
use super::lens;
use crate::Result;
use crate::base::timed::timed;
use crate::commands::arguments::ViewArgs;
use crate::commands::choices::{JitterArg, TexturesArg};
use crate::commands::interrupt::Interrupt;
use crate::commands::{NOTHING_WRITTEN, apply_clock, notice, open_scene, open_vulkan, say};
use crate::device_scene::selection::{self, Request, Selection};
use crate::device_scene::{GpuScene, SceneSizes, shaders};
use crate::gpu::{Device, Features, Instance, InstanceOptions};
use crate::render::settings::EnvironmentSettings;
use crate::render::{Clock, View};
use crate::scene::MovingCamera;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

/// If a scene has at least this many triangles, a line on stderr announces that the trees over the triangles are being
/// built, because this takes several seconds.
const MANY_TRIANGLES: u64 = 2_000_000;

/// The purpose of a session. It decides the features with which the Vulkan instance and the device are opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The session renders pictures for files. The device is opened without features that rendering does not need.
    Pictures,
    /// The session renders frames for a capture tool, which records the Vulkan calls. If the device supports it, it is
    /// opened so that it can present pictures ([`Presentation`](crate::gpu::Presentation)). The session uses no feature
    /// that the tool cannot replay.
    Capture,
    /// The session measures a profile. If the driver supports it, its compiler reports on each shader, and
    /// [`Records::compiled`](crate::gpu::records::Records::compiled) returns these reports.
    Profile,
    /// The session runs a regression test. The device can hash every buffer that a pass writes, so that the test can compare
    /// each pass with golden frames. [`Records::take_outputs`](crate::gpu::records::Records::take_outputs) returns the
    /// hashes.
    Regression {
        /// True if the Vulkan validation layers are loaded, with synchronization validation.
        validate: bool,
    },
}

/// The frames that will be rendered, as far as loading depends on them: the environment, the clock, and the
/// notices about scenes without light.
#[derive(Clone, Debug)]
pub struct Shown {
    /// True if the settings show light that surfaces scatter; false for example with `--bounces 0`, where
    /// only directly visible emitters and the environment give light. The notice about black scenes depends
    /// on it.
    pub scatters: bool,
    /// The rotation and the intensity of the environment that `--environment` names.
    pub environment: EnvironmentSettings,
    /// The clock, which gives for the index of a frame the time in the scene that the frame shows.
    pub clock: Clock,
    /// True if the user has set the clock, so that a notice says that it has no effect on a scene at rest.
    pub clock_is_given: bool,
    /// The indices of the frames that the user will see. If all of them are black, a notice says why.
    pub frames: Range<u32>,
}

/// A scene on an open device, with the view that the arguments describe. Sessions and measurements make their
/// renderers from it.
pub struct OpenedScene {
    /// The camera, the size of the picture, the seed, the maximum number of scattering events, and whether the camera's rays go
    /// through random points of the pixels.
    pub view: View,
    /// The open device to which the scene was uploaded, and on which its frames are rendered.
    pub device: Arc<Device>,
    /// The Vulkan instance, which collects the messages of the validation layers.
    pub instance: Arc<Instance>,
    /// The uploaded scene: its buffers, textures and acceleration structures on the device, which renderers
    /// bind.
    pub gpu_scene: Arc<GpuScene>,
    /// The tracer and the other choices of shader variants, with their reasons.
    pub selection: Selection,
    /// The hash of the content of the scene, as hexadecimal digits. Pictures, reports and stored measurements
    /// contain it, so that a changed scene is recognised.
    pub scene_hash: String,
    /// The reason why the frames that will be shown have no light, as a text for the user; `None` if at least
    /// one of them may have light.
    pub black: Option<&'static str>,
    /// The length of the diagonal of the box around the scene, in scene units; 0 for a scene without instances.
    pub diagonal: f64,
    /// The hash of the shaders in the folder of `HEADWATER_GLSL`; `None` if the variable is not set.
    pub edited_shaders: Option<String>,
    /// The clock, which gives for the index of a frame the time in the scene that the frame shows. The scene is moved to
    /// this time before the frame is rendered, and pictures store the clock in their metadata. `None` if nothing in the
    /// scene moves.
    pub clock: Option<Clock>,
    /// The scene's camera with its motion; while the clock runs, each frame is rendered with the camera of its time. `None`
    /// for a camera that does not belong to the scene, and so does not move.
    pub camera: Option<MovingCamera>,
    /// The moment at which loading the scene began. Reports state the time since then.
    pub opened: Instant,
}

impl OpenedScene {
    /// Loads the scene, opens the device with the features for `purpose`, and uploads the scene. Prints
    /// notices, for example if none of the frames `shown` has light.
    ///
    /// # Errors
    /// Wrong arguments or input, no usable device, a device that fails, or a signal.
    pub fn open(
        args: &ViewArgs,
        shown: &Shown,
        purpose: Purpose,
        interrupt: &Interrupt,
    ) -> Result<Self> {
        let opened = Instant::now();
        let captured = purpose == Purpose::Capture;
        let validates = purpose == Purpose::Regression { validate: true };
        let clock = shown.clock;
        let camera_override = args.look_at_camera()?;
        let mut scene = open_scene(&args.scene, args.load.options(), interrupt)?;
        scene.surround(args.environment.as_deref())?;
        if let (Some(_), Some(environment)) = (&args.environment, &mut scene.environment) {
            environment.rotation = shown.environment.rotation;
            environment.intensity = shown.environment.intensity;
        }
        for text in &scene.notices {
            notice(text);
        }
        let moves = scene.motion.is_some();
        let diagonal = scene.bounds().map_or(0.0, |bounds| bounds.size().length());
        let scene_hash = timed("hashing the scene", || scene.content_hash());
        // What does not shine now may do so at another time: as long as the scene still moves, that is known.
        let times = shown.frames.clone().map(|frame| clock.time(frame));
        let black = scene.why_black(shown.scatters, times);
        if shown.clock_is_given || moves {
            apply_clock(&clock, &mut scene, "")?;
        }
        let (mut camera, followed) = match camera_override {
            Some(camera) => (camera, None),
            None => choose_camera(&scene, args, clock.start_time)?,
        };
        lens::check(args, &camera)?;
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
        let edited_shaders = shaders::edited_fingerprint()?;
        let device = Device::open(&instance, info, features)?;
        let origin = camera.camera_to_world.translation;
        for limit in scene.limits(&[origin]).iter().filter(|l| l.passed) {
            notice(&limit.text);
        }
        if sizes.triangles >= MANY_TRIANGLES {
            say(format_args!(
                "building trees over {} triangles",
                sizes.triangles
            ));
        }
        interrupt.check(NOTHING_WRITTEN)?;
        let gpu_scene = Arc::new(GpuScene::new(&device, &scene, origin, variant)?);
        interrupt.check(NOTHING_WRITTEN)?;
        if args.aperture != 0.0 {
            camera = lens::add(args, camera, &device, &gpu_scene, &clock)?;
            // The camera moves with its lens.
            if let Some(index) = followed {
                scene.cameras[index].projection = camera.projection;
            }
        }
        Ok(Self {
            view: View {
                camera,
                width,
                height,
                seed: args.seed,
                bounces: args.bounces,
                jitter: args.jitter == JitterArg::On,
            },
            device,
            instance,
            gpu_scene,
            selection,
            scene_hash,
            black,
            diagonal,
            edited_shaders,
            clock: moves.then_some(clock),
            camera: followed.map(|index| MovingCamera::of(&scene, index)),
            opened,
        })
    }
}
