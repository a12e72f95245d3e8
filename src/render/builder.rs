//! The builder with which users of the library make the renderer of a scene. Everything that the caller does not set has
//! a default value.

use super::presets::{DEFAULT, Preset};
use super::{Renderer, Settings, View};
use crate::device_scene::GpuScene;
use crate::device_scene::selection::{Request, select};
use crate::device_scene::sizes::SceneSizes;
use crate::gpu::{Device, Instance, InstanceOptions};
use crate::scene::camera::{Lens, framing_camera};
use crate::scene::{Camera, Scene};
use crate::{Error, Result};
use std::sync::Arc;

/// A builder of a [`Renderer`]: it collects the settings, the camera, the picture size, the device and other options, and
/// then makes the renderer. [`Renderer::builder`] makes a builder.
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
    /// The settings of the renderer; `None` stands for those of the default preset, `balanced`.
    settings: Option<Settings>,
    camera: Option<Camera>,
    lens: Option<Lens>,
    size: (u32, u32),
    seed: u32,
    bounces: u32,
    jitter: bool,
    device: Option<String>,
}

impl Renderer {
    /// Makes a builder of a renderer for `scene`. Every option has a default value, which a method of the builder can
    /// replace. The device is opened only when [`RendererBuilder::build`] is called. The scene must have passed
    /// [`Scene::validate`], which [`Scene::open`] calls: the builder does not check it, and the picture of an invalid scene
    /// can be wrong.
    pub fn builder(scene: &Scene) -> RendererBuilder<'_> {
        RendererBuilder::new(scene)
    }
}

impl<'a> RendererBuilder<'a> {
    /// A builder with the defaults: the preset `balanced`, 640 × 360 pixels, at most 5 scattering events per path, seed 0,
    /// no jitter, the first camera of the scene, and the first device in the order that [`Self::device`] describes.
    fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            settings: None,
            camera: None,
            lens: None,
            size: (640, 360),
            seed: 0,
            bounces: 5,
            jitter: false,
            device: None,
        }
    }

    /// Replaces all settings by those of the preset `name`: `path-tracing`, `fast`, `balanced`, `accurate` or `s1`. Without
    /// this call or [`Self::settings`], the settings are those of `balanced`.
    ///
    /// # Errors
    /// No preset has this name.
    pub fn preset(mut self, name: &str) -> Result<Self> {
        self.settings = Some(Preset::named(name)?.settings()?);
        Ok(self)
    }

    /// Replaces all settings by `settings`, including those of an earlier call of [`Self::preset`]. Without either call,
    /// the settings are those of the preset `balanced`.
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = Some(settings);
        self
    }

    /// Sets the camera. Without this call, the first camera of the scene is used. If the scene has no cameras, a camera is
    /// used that shows the whole scene.
    pub fn camera(mut self, camera: Camera) -> Self {
        self.camera = Some(camera);
        self
    }

    /// Gives the camera a lens, which blurs what is not at its focus distance. Without this call, the camera is used as it is:
    /// cameras of files are pinholes, which show everything sharply. A lens in the camera itself ([`Camera::with_lens`]) has
    /// the same effect.
    pub fn lens(mut self, lens: Lens) -> Self {
        self.lens = Some(lens);
        self
    }

    /// Sets the width and the height of the picture, in pixels; both must be at least 1. Without this call, the picture has
    /// 640 × 360 pixels.
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.size = (width, height);
        self
    }

    /// Sets the seed of all random numbers; without this call, it is 0. Two runs with the same seed and the same driver give
    /// the same picture, bit for bit.
    pub fn seed(mut self, seed: u32) -> Self {
        self.seed = seed;
        self
    }

    /// Sets the maximum number of scattering events of a path between emitter and camera: 0 shows only emitters, 1 adds
    /// direct light, 2 or more add indirect light. Without this call, it is 5.
    pub fn bounces(mut self, bounces: u32) -> Self {
        self.bounces = bounces;
        self
    }

    /// Sets where primary rays pass through their pixels. If `jitter` is true, they pass through random points of the pixel
    /// (a box filter), so that the mean of several samples has smooth edges. If it is false, or without this call, they pass
    /// through the centre of the pixel.
    pub fn jitter(mut self, jitter: bool) -> Self {
        self.jitter = jitter;
        self
    }

    /// Selects the Vulkan device: by its index in the list of `headwater info`, by its name or by a part of its name. If
    /// several devices have a fitting name, the first usable one is taken. Without this call, or with an empty text, the
    /// first usable device in this order is taken: discrete GPUs, integrated GPUs, virtual GPUs, CPUs.
    pub fn device(mut self, device: &str) -> Self {
        self.device = Some(device.to_owned());
        self
    }

    /// Opens the device, uploads the scene, and makes the renderer with its passes and buffers.
    ///
    /// # Errors
    /// The width or the height of the picture is 0, the picture is too large, the lens has a value outside of its range or
    /// the camera is orthographic and cannot have one, Vulkan is not available, no device fits the
    /// selection, or the scene exceeds the memory or a limit of the device.
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
        let camera = (self.camera.or(first))
            .unwrap_or_else(|| framing_camera(scene, f64::from(width) / f64::from(height)));
        let camera = match self.lens {
            Some(lens) => camera.with_lens(lens)?,
            None => camera,
        };
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
