//! A scene on the device, with the references and the renderers that a study has made for it. The study uses the same scene,
//! references and renderers for all runs on the scene, because making them takes time.

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

/// A scene on the device, with the references and the renderers that were made for it. A study has one `Subject` per scene,
/// with which it makes all runs and references of the scene. Each configuration has one renderer for its runs and, if rays are
/// counted, a second one.
pub struct Subject {
    /// The name of the scene in the plan. Runs, results and messages state it, so that users know to which scene they
    /// belong.
    pub name: String,
    device: Arc<Device>,
    scene: Arc<GpuScene>,
    view: View,
    camera: Option<MovingCamera>,
    /// True if the scene has motion. If also the plan has `fps`, each frame shows its own time and is compared with its own
    /// reference; otherwise one reference serves all frames.
    moves: bool,
    scene_hash: String,
    shaders: Fingerprints,
    references: HashMap<String, Arc<Reference>>,
    /// The renderers made so far, which further seeds of the same configuration use again. The key is the key of a
    /// configuration ([`Self::key`]) and a flag: true for the renderer that counts rays, false for the one that makes runs.
    renderers: HashMap<(String, bool), Renderer>,
    folder: PathBuf,
}

impl Subject {
    /// Uploads `scene` to the device. `camera` is the scene's first camera, whose motion the view follows; it is `None` if
    /// the plan fixes the camera or the scene has no camera. `folder` is the path of the folder in which references are
    /// stored.
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

    /// The references with which the frames of a configuration are compared, with `samples` samples per pixel: each is taken
    /// from memory, read from the folder, or rendered. While a reference is rendered, `watch` is called with the fraction of
    /// this reference that is done, in [0, 1]; an error from `watch` ends the work.
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

    /// The number of blocks in a picture of the scene. Blocks are squares of 8 × 8 pixels whose mean luminance is tested for
    /// bias. A stored run with another number of blocks ([`Run::has_lengths`]) is damaged, and is rendered again.
    pub fn blocks(&self) -> usize {
        let sides = [self.view.width, self.view.height];
        (sides.iter())
            .map(|side| blocks_of_side(*side as usize))
            .product()
    }

    /// A hash, as 16 hexadecimal digits, of everything that the runs of a configuration depend on, except their seeds. The
    /// store finds finished runs by this key and the seed, so runs are rendered again if anything has changed.
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

    /// Renders the run of a configuration with one seed, measures its frames against `references`, and adds it to `store`.
    /// Does nothing if the store already has this run.
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

    /// Renders the run of a configuration with one seed once more, without storing it. A study compares the result with the
    /// stored run: if the bits differ, a pass has a data race.
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

    /// The counts of each pass in the last frame of the run with the seed `seed`, such as the numbers of rays and of merged
    /// neighbours. This renders a run only to count, because counting takes time, and because shaders that count may round
    /// differently.
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

    /// A BLAKE3 hash, cut to 16 hexadecimal digits. It covers the inputs that all runs and references of the scene share
    /// (such as the scene, the view and the device), the hash `shaders` of the shaders in use, and the text `more`, which
    /// describes the other inputs.
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
