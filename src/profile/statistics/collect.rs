//! Compiles the pipelines with which scenes are rendered, and collects what the driver's compiler reports about them, such
//! as the number of registers. The device only compiles; no shader runs.

use super::settings::CONFIGURATIONS;
use super::{Pipeline, WAVES, value};
use crate::device_scene::selection::{self, Request};
use crate::device_scene::{GpuScene, SceneSizes};
use crate::gpu::{Compiled, ComputePass, Device, DeviceInfo, Features, Instance};
use crate::render::ray_list::RayTracer;
use crate::render::{Lighting, Renderer, Settings, View};
use crate::scene::Scene;
use crate::scene::camera::{DEFAULT_ASPECT, framing_camera};
use crate::shader_interface::Tracer;
use crate::shader_interface::compiler;
use crate::{Error, Result};
use std::sync::Arc;

/// GLSL of a shader that needs no registers, so that a SIMD unit holds as many of its subgroups as possible. The occupancy
/// of other shaders is computed relative to this number of subgroups.
const EMPTY: &str = "#version 460\nlayout(local_size_x = 64) in;\nvoid main() {}\n";

/// The size of the device's memory, in bytes, that is assumed for every device; no scene exceeds it. A driver that works
/// without its GPU reports no memory, so every scene would be refused as too large.
const NO_LIMIT: u64 = 1 << 50;

/// Width and height of the picture for which pipelines are made, in pixels. Any size is sufficient, because
/// the shaders do not depend on it.
const SIDE: u32 = 64;

/// The maximum number of scattering events of a path in the frames for which pipelines are made. It is large enough that the
/// passes of direct and of indirect light are compiled.
const BOUNCES: u32 = 5;

/// A device that only compiles, and the pipelines that it has made so far, for all scenes. `headwater statistics` adds one
/// scene after the other, and then prints, stores or compares the pipelines.
pub struct Compiler {
    device: Arc<Device>,
    /// The number of subgroups of the shader [`EMPTY`] that a SIMD unit holds at once (`waves`), divided by the number of
    /// invocations in such a subgroup. This value times the subgroup size of another pass is the largest possible `waves` of
    /// that pass, from which its occupancy is computed. `None` if the driver does not report `waves`.
    waves_per_invocation: Option<f64>,
    /// The pipelines made so far, each with the hash of its SPIR-V. If another scene or configuration (named settings) uses
    /// the same pipeline, it is recognised by this hash, its pass and its tracer, and is not listed a second time.
    made: Vec<(String, Pipeline)>,
    /// Number of entries in the device's list of compiled pipelines that [`Self::take`] has already read. The next call
    /// begins with the entry after them.
    seen: usize,
}

impl Compiler {
    /// Opens a device that only compiles, with all features that shaders may use, as far as the device has them.
    ///
    /// # Errors
    /// The driver does not report statistics of its compiler, or the device cannot be opened.
    pub fn open(instance: &Arc<Instance>, mut info: DeviceInfo) -> Result<Self> {
        if !info.executable_properties {
            return Err(Error::failed(format!(
                "the driver of device '{}' does not report what its compiler makes of shaders (VK_KHR_pipeline_executable_properties); --device takes another, tools/gpu-statistics brings one",
                info.name
            )));
        }
        let features = Features {
            ray_query: info.ray_query,
            buffer_addresses: info.buffer_addresses,
            image_arrays: info.image_arrays,
            executable_properties: true,
            compiles_only: true,
            ..Features::default()
        };
        // A driver without its GPU has no memory, and none is needed.
        info.device_memory = NO_LIMIT;
        let device = Device::open(instance, info, features)?;
        let words = compiler::compile("empty", EMPTY, &compiler::Sources::new(), &[]);
        let words = words.map_err(Error::failed)?;
        drop(ComputePass::new(&device, "empty", &words, &[])?);
        let compiled = device.records.compiled();
        let per_invocation = |empty: &Compiled| {
            let size = f64::from(empty.report.subgroup_size);
            Some(value(&empty.report, WAVES)? as f64 / size)
        };
        Ok(Self {
            waves_per_invocation: compiled.first().and_then(per_invocation),
            seen: compiled.len(),
            device,
            made: Vec::new(),
        })
    }

    /// The tracers (methods that trace rays) for which the device can compile shaders, and for which pipelines are made
    /// unless the user selects one: `compute-bvh`, and `ray-query` if the device has ray queries.
    pub fn tracers(&self) -> Vec<Tracer> {
        let mut tracers = vec![Tracer::ComputeBvh];
        if self.device.info.ray_query {
            tracers.push(Tracer::RayQuery);
        }
        tracers
    }

    /// Makes every pipeline that `tracer` needs to render `scene`, with each of the [`CONFIGURATIONS`] (named settings). How
    /// shaders access buffers and textures is chosen by [`selection::select`] for the device and the scene. `name` is the
    /// name of the scene in the result. `watch` is called before each configuration; if it returns an error, the work ends.
    ///
    /// # Errors
    /// The tracer or the device does not fit the scene, the driver rejects a shader, or `watch` returns an error.
    pub fn add(
        &mut self,
        name: &str,
        scene: &Scene,
        tracer: Tracer,
        watch: &mut dyn FnMut() -> Result<()>,
    ) -> Result<()> {
        let wanted = Request {
            tracer: Some(tracer),
            ..Request::default()
        };
        let info = &self.device.info;
        let variant = selection::select(info, wanted, &SceneSizes::of(scene))?.variant;
        let camera = scene.cameras.first().cloned();
        let camera = camera.unwrap_or_else(|| framing_camera(scene, DEFAULT_ASPECT));
        let origin = camera.camera_to_world.translation;
        let gpu_scene = Arc::new(GpuScene::new(&self.device, scene, origin, variant)?);
        let view = View {
            camera,
            width: SIDE,
            height: SIDE,
            seed: 0,
            bounces: BOUNCES,
            jitter: false,
        };
        let tracer = variant.tracer.name();
        for configuration in CONFIGURATIONS {
            watch()?;
            self.compile(&gpu_scene, &view, &configuration.settings()?)?;
            self.take(name, tracer, configuration.name);
        }
        Ok(())
    }

    /// Makes all pipelines with which `scene` is rendered, for one camera and picture size (`view`) and one set of settings.
    /// For this purpose, it records two frames: the first has no previous frame to reuse, the second has one. It also
    /// records the passes that read results, such as AOVs. When a pass is recorded, the recording waits until its pipeline
    /// is compiled, so all pipelines exist when this method returns.
    fn compile(&self, scene: &Arc<GpuScene>, view: &View, settings: &Settings) -> Result<()> {
        let device = &self.device;
        let mut renderer = Renderer::new(device, scene.clone(), view, settings)?;
        renderer.single_frame(0)?;
        renderer.single_frame(1)?;
        renderer.keep_single_frame()?;
        renderer.primary_surfaces()?;
        if renderer.has_history() {
            renderer.reservoir_aovs(Lighting::Direct)?;
            renderer.reservoir_aovs(Lighting::Indirect)?;
        }
        renderer.show(&renderer.display()?, 0.0, false)?;
        RayTracer::new(device, scene.clone(), &[])?.run()?;
        Ok(())
    }

    /// Adds the pipelines that the device has compiled since the last call. `scene`, `tracer` and `settings` are the names
    /// of the scene, the tracer and the configuration for which they were compiled. If a pipeline was added before, only the
    /// scene and the configuration are added to its lists of names.
    fn take(&mut self, scene: &str, tracer: &str, settings: &str) {
        let compiled = self.device.records.compiled();
        for Compiled {
            name,
            shader,
            report,
            ..
        } in compiled[self.seen..].iter()
        {
            let same = |(hash, made): &&mut (String, Pipeline)| {
                hash == shader && made.pass == *name && made.tracer == tracer
            };
            let index = self.made.iter_mut().position(|mut one| same(&mut one));
            let index = index.unwrap_or_else(|| {
                let mut pipeline = Pipeline {
                    device: self.device.info.name.clone(),
                    driver: self.device.info.driver.clone(),
                    tracer: tracer.to_owned(),
                    pass: name.clone(),
                    ..Pipeline::default()
                };
                // A SIMD unit has as many slots for subgroups of any size.
                let size = f64::from(report.subgroup_size);
                let most = self.waves_per_invocation.map(|waves| waves * size);
                pipeline.set(report, most);
                self.made.push((shader.clone(), pipeline));
                self.made.len() - 1
            });
            let pipeline = &mut self.made[index].1;
            for (list, one) in [
                (&mut pipeline.scenes, scene),
                (&mut pipeline.settings, settings),
            ] {
                if !list.iter().any(|other| other == one) {
                    list.push(one.to_owned());
                }
            }
        }
        self.seen = compiled.len();
    }

    /// Ends the work, and returns the pipelines of all scenes. They are sorted by tracer, then by pass, by the scenes and
    /// configurations that use them, and by their number of instructions.
    pub fn finish(self) -> Vec<Pipeline> {
        let mut made: Vec<Pipeline> = self
            .made
            .into_iter()
            .map(|(_, pipeline)| pipeline)
            .collect();
        // Passes are compiled in threads, so their order is another one in each run.
        made.sort_by(|a, b| key(a).cmp(&key(b)));
        made
    }
}

/// The key by which pipelines are sorted: tracer, pass, uses (scenes and configurations), number of instructions. With it,
/// the order is the same in every run, although the passes are compiled in parallel threads.
fn key(one: &Pipeline) -> impl Ord {
    let uses = (one.scenes.clone(), one.settings.clone());
    (one.tracer.clone(), one.pass.clone(), uses, one.instructions)
}
