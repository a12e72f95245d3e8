//! The entrance of the library: builds a renderer of a scene, with defaults for everything that is not set.

use super::presets::{DEFAULT, Preset};
use super::{Renderer, Settings, View};
use crate::device_scene::GpuScene;
use crate::device_scene::selection::{Request, select};
use crate::device_scene::sizes::SceneSizes;
use crate::gpu::{Device, Instance, InstanceOptions};
use crate::scene::camera::framing_camera;
use crate::scene::{Camera, Scene};
use crate::{Error, Result};
use std::sync::Arc;

/// A builder of a [`Renderer`], which collects settings, camera, picture size and device. [`Renderer::builder`] makes it.
///
/// ```no_run
/// # fn main() -> headwater::Result<()> {
/// use headwater::{Renderer, Scene};
///
/// let scene = Scene::open("garage")?;
/// let builder = Renderer::builder(&scene).preset("accurate")?.size(640, 360).seed(7);
/// let mut renderer = builder.build()?;
/// renderer.add_samples(0, 4)?;
/// # Ok(())
/// # }
/// ```
#[must_use]
pub struct RendererBuilder<'a> {
    scene: &'a Scene,
    /// The settings of the renderer. `None`: those of the default preset, `balanced`.
    settings: Option<Settings>,
    camera: Option<Camera>,
    size: (u32, u32),
    seed: u32,
    bounces: u32,
    jitter: bool,
    device: Option<String>,
}

impl Renderer {
    /// Begins to build a renderer of `scene` with default values. The device is not opened before
    /// [`RendererBuilder::build`].
    pub fn builder(scene: &Scene) -> RendererBuilder<'_> {
        RendererBuilder::new(scene)
    }
}

impl<'a> RendererBuilder<'a> {
    /// A builder with the defaults: the preset `balanced`, 640 × 360 pixels, at most 5 bounces, seed 0, no
    /// jitter, the scene's first camera, and the first device in the order of preference.
    fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            settings: None,
            camera: None,
            size: (640, 360),
            seed: 0,
            bounces: 5,
            jitter: false,
            device: None,
        }
    }

    /// Replaces all settings by those of a preset: `path-tracing`, `fast`, `balanced`, `accurate` or `s1`.
    ///
    /// # Errors
    /// No preset has this name.
    pub fn preset(mut self, name: &str) -> Result<Self> {
        self.settings = Some(Preset::named(name)?.settings()?);
        Ok(self)
    }

    /// Replaces all settings by `settings`.
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = Some(settings);
        self
    }

    /// Sets the camera. Without this call, it is the scene's first camera, or for a scene without cameras one that shows the
    /// whole scene.
    pub fn camera(mut self, camera: Camera) -> Self {
        self.camera = Some(camera);
        self
    }

    /// Sets the width and the height of the picture, in pixels; both at least 1.
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.size = (width, height);
        self
    }

    /// Sets the seed of all random numbers. Two runs with the same seed and the same driver give the same picture, bit for
    /// bit.
    pub fn seed(mut self, seed: u32) -> Self {
        self.seed = seed;
        self
    }

    /// Sets the maximum number of scattering events of a path: 0 shows only emitters, 1 adds direct light, 2 or more add
    /// indirect light.
    pub fn bounces(mut self, bounces: u32) -> Self {
        self.bounces = bounces;
        self
    }

    /// If `jitter` is true, primary rays pass through random points of a pixel (a box filter), which smooths edges over
    /// several samples. Otherwise they pass through its centre.
    pub fn jitter(mut self, jitter: bool) -> Self {
        self.jitter = jitter;
        self
    }

    /// Selects the device by its index, its name or a part of its name. Without this call, discrete GPUs come before
    /// integrated ones, and these before virtual GPUs and CPUs.
    pub fn device(mut self, device: &str) -> Self {
        self.device = Some(device.to_owned());
        self
    }

    /// Opens the device, uploads the scene, and makes the renderer with its passes and buffers.
    ///
    /// # Errors
    /// The picture has no pixels or too many, there is no Vulkan or no device as selected, or the scene exceeds the memory
    /// or a limit of the device.
    pub fn build(self) -> Result<Renderer> {
        let (width, height) = self.size;
        if width == 0 || height == 0 {
            return Err(Error::input(format!(
                "a picture of {width} × {height} has no pixels; both sides begin at 1"
            )));
        }
        let settings = match self.settings {
            Some(settings) => settings,
            None => Preset::named(DEFAULT)?.settings()?,
        };
        let scene = self.scene;
        let first = scene.cameras.first().cloned();
        let camera = (self.camera.or(first)).unwrap_or_else(|| framing_camera(scene));
        let instance = Instance::new(InstanceOptions::default())?;
        let (info, _) = instance.choose(self.device.as_deref())?;
        let selection = select(&info, Request::default(), &SceneSizes::of(scene))?;
        let device = Device::open(&instance, info, selection.features())?;
        let origin = camera.camera_to_world.translation;
        let uploaded = GpuScene::new(&device, scene, origin, selection.variant)?;
        let view = View {
            camera,
            width,
            height,
            seed: self.seed,
            bounces: self.bounces,
            jitter: self.jitter,
        };
        Renderer::new(&device, Arc::new(uploaded), &view, &settings)
    }
}
