//! A scene on the device, with the data that all configurations of a study use on it.

use super::plan::Resolved;
use super::reference::{Reference, References, Shot, blocks_of_side};
use super::run::{self, Run};
use super::store::Store;
use crate::Result;
use crate::base::progress::Watch;
use crate::base::short_hash::short;
use crate::device_scene::GpuScene;
use crate::device_scene::shaders::Fingerprints;
use crate::gpu::Device;
use crate::render::counters::Counts;
use crate::render::settings::Integrator;
use crate::render::{Renderer, ResolvedSettings, Settings, Tracking, View};
use crate::scene::{MovingCamera, Scene};
use crate::shader_interface::Variant;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::PathBuf;
use std::sync::Arc;

/// A scene on the device with its references, and renderers by configuration.
pub struct Subject {
    /// The scene's name in the plan.
    pub name: String,
    device: Arc<Device>,
    scene: Arc<GpuScene>,
    view: View,
    camera: Option<MovingCamera>,
    /// True if anything in the scene moves.
    moves: bool,
    scene_hash: String,
    shaders: Fingerprints,
    references: HashMap<String, Arc<Reference>>,
    /// The renderers by their inputs, and by the presence of counters.
    renderers: HashMap<(String, bool), Renderer>,
    folder: PathBuf,
}

impl Subject {
    /// Uploads `scene`. `camera` is given if it may move from the one in `view`; `folder` keeps references.
    ///
    /// # Errors
    /// The device fails, or `HEADWATER_GLSL` names a folder that cannot be read.
    pub fn new(
        name: &str,
        scene: &Scene,
        view: View,
        camera: Option<MovingCamera>,
        device: &Arc<Device>,
        variant: Variant,
        folder: PathBuf,
    ) -> Result<Self> {
        let origin = view.camera.camera_to_world.translation;
        Ok(Self {
            name: name.to_owned(),
            scene: Arc::new(GpuScene::new(device, scene, origin, variant)?),
            scene_hash: scene.content_hash(),
            shaders: Fingerprints::new()?,
            device: device.clone(),
            view,
            camera,
            moves: scene.motion.is_some(),
            references: HashMap::new(),
            renderers: HashMap::new(),
            folder,
        })
    }

    /// The references for a configuration's frames: made, read, or taken from memory. `watch` receives the fraction of one that
    /// is made, and can end the work.
    ///
    /// # Errors
    /// The device or the disk fails, the scene cannot be rendered at a frame's time, or `watch` ends it.
    pub fn references(
        &mut self,
        configuration: &Resolved,
        samples: u32,
        watch: &mut Watch,
    ) -> Result<References> {
        let clock = configuration.clock;
        let frames = match clock.fps {
            Some(_) if self.moves => configuration.frames,
            _ => 1,
        };
        let settings = path_tracing(&configuration.settings);
        (0..frames)
            .map(|frame| self.reference(&settings, clock.time(frame), samples, watch))
            .collect::<Result<_>>()
            .map(References::new)
    }

    fn reference(
        &mut self,
        settings: &Settings,
        time: f64,
        samples: u32,
        watch: &mut Watch,
    ) -> Result<Arc<Reference>> {
        let at = if self.moves {
            format!("at {time:?}")
        } else {
            String::new()
        };
        let key = self.hash(
            &self.shaders.path_trace,
            &format!("reference {samples} {} {at}", settings.to_value()?),
        );
        if let Some(reference) = self.references.get(&key) {
            return Ok(reference.clone());
        }
        let mut view = self.view.clone();
        if let Some(camera) = &self.camera {
            view.camera = camera.at(time)?;
        }
        let shot = Shot {
            device: &self.device,
            scene: &self.scene,
            time,
            view,
            settings,
            samples,
        };
        let path = self.folder.join(format!("{key}.exr"));
        let reference = Arc::new(Reference::obtain(&path, &shot, watch)?);
        self.references.insert(key, reference.clone());
        Ok(reference)
    }

    /// The number of blocks of its pictures.
    pub fn blocks(&self) -> usize {
        let sides = [self.view.width, self.view.height];
        (sides.iter())
            .map(|side| blocks_of_side(*side as usize))
            .product()
    }

    /// The hash of all inputs of a configuration's runs except their seeds.
    ///
    /// # Errors
    /// Never with finite settings.
    pub fn key(&self, configuration: &Resolved) -> Result<String> {
        let Resolved {
            name: _,
            settings,
            frames,
            clock,
            accumulate,
            count: _,
            scenes: _,
            expect: _,
        } = configuration;
        let settings = settings.to_value()?;
        let clock = self.moves.then_some(clock);
        let more = format!("run {settings} {frames} {accumulate} {clock:?}");
        Ok(self.hash(&self.shaders.all, &more))
    }

    /// Renders and keeps the run of a seed, unless it is there.
    ///
    /// # Errors
    /// The device or the disk fails.
    pub fn run(
        &mut self,
        configuration: &Resolved,
        seed: u32,
        references: &References,
        store: &mut Store,
    ) -> Result<()> {
        let key = self.key(configuration)?;
        if store.find(&key, seed).is_some() {
            return Ok(());
        }
        store.add(self.measure(configuration, seed, references, Tracking::default())?)
    }

    /// Repeats the run of a seed.
    ///
    /// # Errors
    /// The device fails.
    pub fn repeat(
        &mut self,
        configuration: &Resolved,
        seed: u32,
        references: &References,
    ) -> Result<Run> {
        self.measure(configuration, seed, references, Tracking::default())
    }

    /// The counts of the passes in the run of a seed. A separate run counts, because counting takes time, and because shaders
    /// that count may round differently.
    ///
    /// # Errors
    /// The device fails.
    pub fn counts(
        &mut self,
        configuration: &Resolved,
        seed: u32,
        references: &References,
    ) -> Result<Vec<Counts>> {
        let tracking = Tracking {
            counts: true,
            ..Tracking::default()
        };
        let run = self.measure(configuration, seed, references, tracking)?;
        Ok(run.counts)
    }

    fn measure(
        &mut self,
        configuration: &Resolved,
        seed: u32,
        references: &References,
        tracking: Tracking,
    ) -> Result<Run> {
        let key = self.key(configuration)?;
        let renderer = match self.renderers.entry((key.clone(), tracking.counts)) {
            Entry::Occupied(made) => made.into_mut(),
            Entry::Vacant(entry) => {
                let (scene, view) = (self.scene.clone(), &self.view);
                let settings = ResolvedSettings::new(&configuration.settings, &scene, view.bounces);
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
        let measured = run::measure(renderer, configuration, seed, references, camera)?;
        Ok(Run {
            scene: self.name.clone(),
            key,
            ..measured
        })
    }

    /// A hash of all common inputs, of a hash of shaders, and of `more`.
    fn hash(&self, shaders: &str, more: &str) -> String {
        let info = &self.device.info;
        let text = format!(
            "{} {:?} {} {:?} {} {} {} {} {more}",
            self.scene_hash,
            self.view,
            self.camera.is_some(),
            self.scene.variant,
            info.name,
            info.driver,
            shaders,
            env!("HEADWATER_COMMIT")
        );
        short(&blake3::hash(text.as_bytes()))
    }
}

/// Plain path tracing of the light for which these settings are: references and controls are made with it.
pub fn path_tracing(settings: &Settings) -> Settings {
    Settings {
        integrator: Integrator::PathTracing,
        energy: settings.energy,
        direct: settings.direct.of_path_tracing(),
        ..Settings::default()
    }
}
