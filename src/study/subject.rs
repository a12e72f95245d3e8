//! A scene on the device, with the references and renderers that the configurations of a study use on it.

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

/// A scene on the device, with its references and one renderer for each configuration. It makes the runs and references of a
/// study.
pub struct Subject {
    /// The name of the scene in the plan.
    pub name: String,
    device: Arc<Device>,
    scene: Arc<GpuScene>,
    view: View,
    camera: Option<MovingCamera>,
    /// True if the scene has motion. Then each frame has its own time and reference, if the plan has `fps`.
    moves: bool,
    scene_hash: String,
    shaders: Fingerprints,
    references: HashMap<String, Arc<Reference>>,
    /// The renderers by the key of their configuration ([`Self::key`]), and by a flag that is true if they count rays.
    renderers: HashMap<(String, bool), Renderer>,
    folder: PathBuf,
}

impl Subject {
    /// Uploads `scene` to the device. `camera` is the scene's own camera, whose motion the view follows, or `None` if the
    /// plan fixes the camera. References are stored in `folder`.
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

    /// The references for a configuration's frames, with `samples` samples per pixel: taken from memory, read from the
    /// folder, or rendered. `watch` receives the fraction of the current reference that is rendered, in [0, 1], and can end
    /// the work by an error.
    ///
    /// # Errors
    /// The device or the disk fails, a file is not a valid reference, the scene cannot be rendered at a frame's time, path
    /// tracing rejected values, or `watch` returns an error.
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

    /// The number of blocks (squares of 8 × 8 pixels whose mean luminance is tested for bias) in a picture of the scene.
    pub fn blocks(&self) -> usize {
        let sides = [self.view.width, self.view.height];
        (sides.iter())
            .map(|side| blocks_of_side(*side as usize))
            .product()
    }

    /// The hash, as 16 hexadecimal digits, of everything that the runs of a configuration depend on, except their seeds. The
    /// store keeps finished runs under it; if something changes, runs are rendered again.
    ///
    /// # Errors
    /// The settings have no JSON form, which cannot happen with finite numbers.
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

    /// Renders and stores the run of a configuration with one seed, unless the store holds it.
    ///
    /// # Errors
    /// The device or the disk fails, or the scene cannot be rendered at a frame's time.
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

    /// Renders the run of a configuration with one seed, without storing it, so that it can be compared with the stored run.
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at a frame's time.
    pub fn repeat(
        &mut self,
        configuration: &Resolved,
        seed: u32,
        references: &References,
    ) -> Result<Run> {
        self.measure(configuration, seed, references, Tracking::default())
    }

    /// The counts of each pass in the last frame of a run, such as rays and neighbours. A separate run counts, because
    /// counting takes time, and because shaders that count may round differently.
    ///
    /// # Errors
    /// The device fails, or the scene cannot be rendered at a frame's time.
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

    /// A BLAKE3 hash, cut to 16 hexadecimal digits. It covers the inputs that all runs and references of the scene have,
    /// `shaders`, which is a hash of the shaders in use, and the text `more`.
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

/// The settings of plain path tracing that renders the same light as `settings`. References and controls are made with them.
pub fn path_tracing(settings: &Settings) -> Settings {
    Settings {
        integrator: Integrator::PathTracing,
        energy: settings.energy,
        direct: settings.direct.of_path_tracing(),
        ..Settings::default()
    }
}
