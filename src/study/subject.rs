//! A scene on the device, and what all configurations of a study share on it.

use super::plan::Resolved;
use super::reference::Reference;
use super::run::{self, Run};
use super::store::Store;
use crate::gpu::Device;
use crate::render::settings::{Energy, Integrator};
use crate::render::{Renderer, Settings, View};
use crate::scene::Scene;
use crate::tracing::{GpuScene, Variant, shaders};
use crate::{Error, Result};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// A scene on the device with its references, and renderers by configuration.
pub struct Subject {
    /// The scene's name in the plan.
    pub name: String,
    /// Whether the scene has anything that gives light.
    pub is_lit: bool,
    device: Arc<Device>,
    scene: Arc<GpuScene>,
    view: View,
    scene_hash: String,
    shaders: String,
    references: HashMap<String, Arc<Reference>>,
    renderers: HashMap<String, Renderer>,
    folder: PathBuf,
}

impl Subject {
    /// Uploads `scene`; `folder` keeps references.
    ///
    /// # Errors
    /// The device fails, or `HEADWATER_GLSL` names a folder that cannot be read.
    pub fn new(
        name: &str,
        scene: &Scene,
        view: View,
        device: &Arc<Device>,
        variant: Variant,
        folder: PathBuf,
    ) -> Result<Self> {
        let origin = view.camera.camera_to_world.translation;
        Ok(Self {
            name: name.to_owned(),
            is_lit: scene.emissive_triangle_count() > 0,
            scene: Arc::new(GpuScene::new(device, scene, origin, variant)?),
            scene_hash: scene.content_hash(),
            shaders: shaders::fingerprint()?,
            device: device.clone(),
            view,
            references: HashMap::new(),
            renderers: HashMap::new(),
            folder,
        })
    }

    /// The reference for configurations with this surface model; made, read, or known already.
    /// `watch` hears how many samples are done, and can end the work.
    ///
    /// # Errors
    /// The device or the disk fails, or `watch` ends it.
    pub fn reference(
        &mut self,
        energy: Energy,
        samples: u32,
        watch: &dyn Fn(u32) -> Result<()>,
    ) -> Result<Arc<Reference>> {
        let settings = path_tracing(energy);
        let key = self.hash(&format!("reference {samples} {}", settings.to_value()?));
        if let Some(reference) = self.references.get(&key) {
            return Ok(reference.clone());
        }
        let path = self.folder.join(format!("{key}.exr"));
        let reference = Arc::new(Reference::obtain(
            &path,
            &self.device,
            &self.scene,
            &self.view,
            &settings,
            samples,
            watch,
        )?);
        self.references.insert(key, reference.clone());
        Ok(reference)
    }

    /// What a configuration's runs depend on beside their seeds, hashed.
    ///
    /// # Errors
    /// Never with finite settings.
    pub fn key(&self, configuration: &Resolved) -> Result<String> {
        let Resolved {
            name: _,
            settings,
            frames,
            accumulate,
            count,
            scenes: _,
            expect: _,
        } = configuration;
        let settings = settings.to_value()?;
        Ok(self.hash(&format!("run {settings} {frames} {accumulate} {count}")))
    }

    /// Renders and keeps the run of a seed, unless it is there.
    ///
    /// # Errors
    /// The device or the disk fails.
    pub fn run(
        &mut self,
        configuration: &Resolved,
        seed: u32,
        reference: &Reference,
        store: &mut Store,
    ) -> Result<()> {
        let key = self.key(configuration)?;
        if store.find(&key, seed).is_some() {
            return Ok(());
        }
        store.add(self.measure(configuration, seed, reference)?)
    }

    /// Whether a run comes out as it did before, to the last bit.
    ///
    /// # Errors
    /// The device fails.
    pub fn replays(
        &mut self,
        configuration: &Resolved,
        run: &Run,
        reference: &Reference,
    ) -> Result<bool> {
        let again = self.measure(configuration, run.seed, reference)?;
        Ok(again.mean == run.mean && again.blocks == run.blocks && again.rmse == run.rmse)
    }

    fn measure(
        &mut self,
        configuration: &Resolved,
        seed: u32,
        reference: &Reference,
    ) -> Result<Run> {
        let key = self.key(configuration)?;
        if !self.renderers.contains_key(&key) {
            let (scene, settings) = (self.scene.clone(), &configuration.settings);
            let make = if configuration.count {
                Renderer::counting
            } else {
                Renderer::new
            };
            let renderer = make(&self.device, scene, &self.view, settings)?;
            self.renderers.insert(key.clone(), renderer);
        }
        let renderer = (self.renderers.get_mut(&key))
            .ok_or_else(|| Error::failed("a renderer was made and is missing"))?;
        let measured = run::measure(renderer, configuration, seed, reference)?;
        Ok(Run {
            scene: self.name.clone(),
            key,
            ..measured
        })
    }

    /// A hash of what everything here depends on, and of `more`.
    fn hash(&self, more: &str) -> String {
        let text = format!(
            "{} {:?} {} {} {} {more}",
            self.scene_hash,
            self.view,
            self.device.info.driver,
            self.shaders,
            env!("HEADWATER_COMMIT")
        );
        blake3::hash(text.as_bytes()).to_hex()[..16].to_owned()
    }
}

/// Plain path tracing with a surface model: what references and controls are made with.
pub fn path_tracing(energy: Energy) -> Settings {
    Settings {
        integrator: Integrator::PathTracing,
        energy,
        ..Settings::default()
    }
}
