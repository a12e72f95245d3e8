//! A scene on the device, with the renderers that a study has made for it. The study uses the same scene and renderers for
//! all runs on the scene, because making them takes time.

use super::identity::Identity;
use super::pictures::LastFrames;
use super::plan::Resolved;
use super::reference::{References, Shot};
use super::run::{self, Run};
use crate::Result;
use crate::base::progress::Watch;
use crate::base::short_hash::short;
use crate::device_scene::GpuScene;
use crate::device_scene::shaders::Fingerprints;
use crate::gpu::Device;
use crate::render::settings::Integrator;
use crate::render::{Renderer, ResolvedSettings, Settings, Tracking, View};
use crate::scene::{MovingCamera, Scene};
use crate::shader_interface::Variant;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// A scene on the device, with the renderers that were made for it. A study makes all runs and references of a scene with
/// one `Subject`. Each configuration has one renderer for its runs and, if rays are counted, a second one.
pub struct Subject {
    /// The hashes from which the keys of the scene's runs and references are made, and the size of its
    /// pictures.
    pub identity: Identity,
    device: Arc<Device>,
    scene: Arc<GpuScene>,
    view: View,
    camera: Option<MovingCamera>,
    /// The renderers made so far, which further seeds of the same configuration use again. The key is the settings as JSON,
    /// and a flag: true for the renderer that counts rays, false for the one that makes runs.
    renderers: HashMap<(String, bool), Renderer>,
}

impl Subject {
    /// Uploads `scene` to the device. `camera` is the scene's first camera, whose motion the view follows; it is `None` if
    /// the plan fixes the camera or the scene has no camera.
    ///
    /// # Errors
    /// The device fails, or the environment variable `HEADWATER_GLSL` names a folder of shaders that cannot be read.
    pub fn new(
        name: &str,
        scene: &Scene,
        view: View,
        camera: Option<MovingCamera>,
        device: &Arc<Device>,
        variant: Variant,
    ) -> Result<Self> {
        let origin = view.camera.camera_to_world.translation;
        let shaders = Fingerprints::new()?;
        let uploaded = GpuScene::new(device, scene, origin, variant)?;
        let info = &device.info;
        let inputs = format!(
            "{} {view:?} {} {:?} {} {} {}",
            scene.content_hash(),
            camera.is_some(),
            uploaded.variant,
            info.name,
            info.driver,
            env!("HEADWATER_COMMIT")
        );
        Ok(Self {
            identity: Identity {
                scene: name.to_owned(),
                size: (view.width, view.height),
                moves: scene.motion.is_some(),
                inputs: short(&blake3::hash(inputs.as_bytes())),
                shaders: shaders.all,
                path_tracing: shaders.path_trace,
            },
            scene: Arc::new(uploaded),
            device: device.clone(),
            view,
            camera,
            renderers: HashMap::new(),
        })
    }

    /// The memory on the device that the scene and its renderers fill, in bytes.
    pub fn memory(&self) -> u64 {
        let memory = self.device.records.memory_use();
        memory.values().map(|(_, bytes)| bytes).sum()
    }

    /// Renders the blocks of a reference that have no file yet: the light of the configuration at the time `time`, in
    /// seconds. `files` has the path and the samples of each block. `watch` is called with the number of samples per pixel
    /// that are done; an error from it ends the work.
    ///
    /// # Errors
    /// The device or the disk fails, the scene cannot be rendered at that time, path tracing rejected values, or `watch`
    /// returns an error.
    pub fn render_reference(
        &self,
        configuration: &Resolved,
        time: f64,
        files: &[(PathBuf, Range<u32>)],
        watch: &mut Watch,
    ) -> Result<()> {
        let mut view = self.view.clone();
        if let Some(camera) = &self.camera {
            view.camera = camera.at(time)?;
        }
        let shot = Shot {
            device: &self.device,
            scene: &self.scene,
            time,
            view,
            settings: &path_tracing(&configuration.settings),
        };
        shot.render(files, watch)
    }

    /// Renders the run of a configuration with one seed, and measures its frames against `references`. If `counts` is true,
    /// the run also counts rays in its last frame; such a run is slower, and its shaders may round differently. The caller
    /// sets the key of the run. The last frames are returned as pictures.
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at a frame's time.
    pub fn run(
        &mut self,
        configuration: &Resolved,
        seed: u32,
        references: &References,
        counts: bool,
    ) -> Result<(Run, LastFrames)> {
        let settings = configuration.settings.to_value()?.to_string();
        let renderer = match self.renderers.entry((settings, counts)) {
            Entry::Occupied(made) => made.into_mut(),
            Entry::Vacant(entry) => {
                let (scene, view) = (self.scene.clone(), &self.view);
                let settings = ResolvedSettings::new(&configuration.settings, &scene, view.bounces);
                let tracking = Tracking {
                    counts,
                    ..Tracking::default()
                };
                entry.insert(Renderer::tracking(
                    &self.device,
                    scene,
                    view,
                    &settings,
                    tracking,
                )?)
            }
        };
        let camera = self.camera.as_ref();
        let (measured, frames) = run::measure(renderer, configuration, seed, references, camera)?;
        let scene = self.identity.scene.clone();
        Ok((Run { scene, ..measured }, frames))
    }
}

/// The settings with which path tracing renders the same light as the configuration with the settings `settings`. Both
/// references and controls are rendered with them. A control shows how the blocks of pixels of pictures without bias are
/// distributed.
pub fn path_tracing(settings: &Settings) -> Settings {
    Settings {
        integrator: Integrator::PathTracing,
        energy: settings.energy,
        direct: settings.direct.of_path_tracing(),
        ..Settings::default()
    }
}
