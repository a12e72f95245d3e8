//! The library's entrance: a renderer of a scene on a device, with defaults for all that is not set.

use super::presets::Preset;
use super::{Renderer, Settings, View};
use crate::device_scene::GpuScene;
use crate::device_scene::selection::{Request, select};
use crate::device_scene::sizes::SceneSizes;
use crate::gpu::{Device, Instance, InstanceOptions};
use crate::scene::camera::framing_camera;
use crate::scene::{Camera, Scene};
use crate::{Error, Result};
use std::sync::Arc;

/// The settings, camera, size and device of a [`Renderer`] that is to be built; [`Renderer::builder`] makes one.
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
    settings: Settings,
    camera: Option<Camera>,
    size: (u32, u32),
    seed: u32,
    bounces: u32,
    jitter: bool,
    device: Option<String>,
}

impl Renderer {
    /// Begins a renderer of a scene with defaults; [`RendererBuilder::build`] opens the device.
    pub fn builder(scene: &Scene) -> RendererBuilder<'_> {
        RendererBuilder::new(scene)
    }
}

impl<'a> RendererBuilder<'a> {
    /// The defaults: the preset `balanced`, 640 × 360 pixels, 5 bounces, seed 0, the scene's first camera.
    fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            settings: Settings::default(),
            camera: None,
            size: (640, 360),
            seed: 0,
            bounces: 5,
            jitter: false,
            device: None,
        }
    }

    /// Takes the settings of a preset: `path-tracing`, `fast`, `balanced`, `accurate` or `s1`.
    ///
    /// # Errors
    /// There is no such preset.
    pub fn preset(mut self, name: &str) -> Result<Self> {
        self.settings = Preset::named(name)?.settings()?;
        Ok(self)
    }

    /// Takes these settings.
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    /// Takes this camera instead of the scene's first one, or of one that frames a scene without cameras.
    pub fn camera(mut self, camera: Camera) -> Self {
        self.camera = Some(camera);
        self
    }

    /// Sets the size of the picture, in pixels; both at least 1.
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.size = (width, height);
        self
    }

    /// Sets the seed of all random numbers. The same seed gives the same bits on the same driver.
    pub fn seed(mut self, seed: u32) -> Self {
        self.seed = seed;
        self
    }

    /// Sets the maximum number of scattering events of a path; 1 is direct light only.
    pub fn bounces(mut self, bounces: u32) -> Self {
        self.bounces = bounces;
        self
    }

    /// With `jitter`, primary rays begin anywhere in a pixel (a box filter) instead of at its centre.
    pub fn jitter(mut self, jitter: bool) -> Self {
        self.jitter = jitter;
        self
    }

    /// Takes the device with this name, a part of its name, or this index, instead of the first GPU.
    pub fn device(mut self, device: &str) -> Self {
        self.device = Some(device.to_owned());
        self
    }

    /// Opens the device, uploads the scene, and makes passes and buffers.
    ///
    /// # Errors
    /// A picture without pixels, no Vulkan or no such device, or a scene that the device has no room for.
    pub fn build(self) -> Result<Renderer> {
        let (width, height) = self.size;
        if width == 0 || height == 0 {
            return Err(Error::input(format!(
                "a picture of {width} × {height} has no pixels; both sides begin at 1"
            )));
        }
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
        Renderer::new(&device, Arc::new(uploaded), &view, &self.settings)
    }
}
