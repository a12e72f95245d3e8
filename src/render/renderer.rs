//! One view of a scene, rendered by the integrator that the settings select.
//!
//! Methods that return a [`Result`] fail if the device does; other errors are named where they can occur.

use super::camera::gpu_camera;
use super::counters::Counts;
use super::integrators::{PathTracer, Restir};
use super::light_samplers::light_bvh::LightBvhBuffer;
use super::lighting::Lighting;
use super::outputs::Sums;
use super::outputs::display::Display;
use super::outputs::primary_surfaces::PrimarySurfaces;
use super::resolved_settings::ResolvedSettings;
use super::scene_bindings::SceneBindings;
use super::settings::{DirectMode, Energy, Integrator, Settings, Variant};
use super::tracking::Tracking;
use super::view::View;
use crate::device_scene::GpuScene;
use crate::gpu::{Device, PassTime};
use crate::scene::{Camera, MovingCamera};
use crate::shader_interface::{
    FrameConstants, GpuCamera, PixelSums, PrimarySurface, ReservoirAov, Specialisation,
    ViewConstants,
};
use crate::{Error, Result};
use glam::Vec3;
use std::sync::Arc;

/// Renders one view of a scene; what each call adds is summed up for each pixel.
pub struct Renderer {
    device: Arc<Device>,
    bindings: Arc<SceneBindings>,
    constants: FrameConstants,
    technique: Technique,
    primary_surfaces: Option<PrimarySurfaces>,
    /// The moment of the next frame.
    next: Moment,
    /// The moments of the last frame and of the one before it, if there were any.
    shown: [Option<Moment>; 2],
}

/// A time, and the camera at that time.
#[derive(Clone, Copy)]
struct Moment {
    /// In seconds.
    time: f64,
    camera: GpuCamera,
}

enum Technique {
    PathTracing(Box<PathTracer>),
    Restir(Box<Restir>),
}

impl Renderer {
    /// Makes the passes and buffers that `settings` need.
    ///
    /// # Errors
    /// More memory than the device has. A shader that the driver rejects is an error of the first frame.
    pub fn new(
        device: &Arc<Device>,
        scene: Arc<GpuScene>,
        view: &View,
        settings: &Settings,
    ) -> Result<Self> {
        let settings = ResolvedSettings::new(settings, &scene, view.bounces);
        Self::tracking(device, scene, view, &settings, Tracking::default())
    }

    /// [`Self::new`], with what is to be kept besides the picture. `settings` are resolved for this scene and the bounces of
    /// the view.
    ///
    /// # Errors
    /// The errors of [`Self::new`].
    pub fn tracking(
        device: &Arc<Device>,
        scene: Arc<GpuScene>,
        view: &View,
        settings: &ResolvedSettings,
        tracking: Tracking,
    ) -> Result<Self> {
        let constants = FrameConstants {
            view: ViewConstants {
                camera: gpu_camera(&view.camera, &scene.units, view.width, view.height),
                width: view.width,
                height: view.height,
                interleave: device.info.interleave(),
                seed: view.seed,
                bounces: view.bounces,
                roulette_start: settings.roulette.start,
                roulette_floor: settings.roulette.floor,
            },
            first_sample: 0,
            samples: 1,
            jitter: view.jitter.into(),
            heuristic: settings.heuristic as u32,
            without_direct_light: (settings.direct.mode == DirectMode::Off).into(),
        };
        let specialisation = Specialisation {
            energy_compensated: settings.energy == Energy::Compensated,
            ..scene.specialisation(settings.variant == Variant::Full)
        };
        let options = settings.light_bvh_options();
        let light_bvh = LightBvhBuffer::new(device, &scene, &settings.light_bvh, options)?;
        let light_nodes = light_bvh.node_count;
        let bindings = SceneBindings::new(device, scene, specialisation, Box::new(light_bvh))?;
        let bindings = Arc::new(bindings);
        let technique = match settings.integrator {
            Integrator::PathTracing => {
                let tracer = PathTracer::new(device, &bindings, constants, tracking.counts)?;
                Technique::PathTracing(Box::new(tracer))
            }
            Integrator::Restir => {
                let (view, jitter) = (&constants.view, view.jitter);
                let restir = Restir::new(
                    device,
                    &bindings,
                    view,
                    jitter,
                    settings,
                    light_nodes,
                    tracking,
                )?;
                Technique::Restir(Box::new(restir))
            }
        };
        Ok(Self {
            device: device.clone(),
            bindings,
            next: Moment {
                time: 0.0,
                camera: constants.view.camera,
            },
            shown: [None; 2],
            constants,
            technique,
            primary_surfaces: None,
        })
    }

    /// Name and bytes of the light BVH's buffer, if something draws from it.
    pub fn light_bvh_memory(&self) -> Option<(&'static str, u64)> {
        self.bindings.light_bvh_memory()
    }

    /// Sets the time, in seconds, that the next frames and samples show; at first it is 0. The camera stays
    /// where it is.
    pub fn set_time(&mut self, seconds: f64) {
        self.next.time = seconds;
    }

    /// Sets the camera of the next frames and samples, for example to
    /// [`crate::scene::Scene::camera_at`].
    pub fn set_camera(&mut self, camera: &Camera) {
        let ViewConstants { width, height, .. } = self.constants.view;
        let units = &self.bindings.scene.units;
        self.next.camera = gpu_camera(camera, units, width, height);
    }

    /// Sets the time of the next frames and samples, in seconds, and the camera to where `camera` is then, if it moves.
    ///
    /// # Errors
    /// The camera has no direction then.
    pub fn set_moment(&mut self, seconds: f64, camera: Option<&MovingCamera>) -> Result<()> {
        self.set_time(seconds);
        if let Some(camera) = camera {
            self.set_camera(&camera.at(seconds)?);
        }
        Ok(())
    }

    /// Poses the scene as the next frame shows it.
    fn begin(&mut self) -> Result<GpuCamera> {
        let next = self.next;
        let before = self.shown[0].unwrap_or(next);
        self.bindings.set_pose(next.time, before.time)?;
        self.shown = [Some(next), self.shown[0]];
        Ok(next.camera)
    }

    /// True if a frame depends on those before it.
    pub fn has_history(&self) -> bool {
        match &self.technique {
            Technique::PathTracing(_) => false,
            Technique::Restir(frame) => frame.has_history(),
        }
    }

    /// Adds `samples` samples or frames, numbered from `first`, to every pixel.
    pub fn add_samples(&mut self, first: u32, samples: u32) -> Result<Vec<PassTime>> {
        self.add_samples_watched(first, samples, &mut |_| Ok(()))
    }

    /// [`Self::add_samples`]; `watch` is called now and then with the share of the work that is done, 0 to 1.
    /// If it returns an error the work ends, and pixels then differ in their number of samples.
    ///
    /// # Errors
    /// The errors of [`Self::add_samples`] and of `watch`.
    pub fn add_samples_watched(
        &mut self,
        first: u32,
        samples: u32,
        watch: &mut dyn FnMut(f64) -> Result<()>,
    ) -> Result<Vec<PassTime>> {
        let mut times = Vec::new();
        let frames = match self.technique {
            // Samples of one moment are added in one call.
            Technique::PathTracing(_) => 1,
            Technique::Restir(_) => samples,
        };
        for number in 0..frames {
            if number > 0 {
                watch(f64::from(number) / f64::from(frames))?;
            }
            let camera = self.begin()?;
            times = match &mut self.technique {
                Technique::PathTracing(tracer) => {
                    tracer.set_camera(camera);
                    tracer.add_samples(first, samples, watch)?
                }
                Technique::Restir(frame) => {
                    PassTime::by_name(frame.add_frame(first + number, camera)?)
                }
            };
        }
        Ok(times)
    }

    /// Renders a frame only as the history of those that follow.
    pub fn skip_frame(&mut self, number: u32) -> Result<Vec<PassTime>> {
        let camera = self.begin()?;
        match &mut self.technique {
            Technique::PathTracing(_) => Ok(Vec::new()),
            Technique::Restir(frame) => frame.render(number, camera),
        }
    }

    /// Bytes on the device that resampling keeps for each pixel, over all buffers; 0 for path
    /// tracing, whose sums are its result.
    pub fn bytes_per_pixel(&self) -> f64 {
        let Technique::Restir(frame) = &self.technique else {
            return 0.0;
        };
        let ViewConstants { width, height, .. } = self.constants.view;
        frame.bytes() as f64 / (f64::from(width) * f64::from(height))
    }

    /// Begins anew with another seed, without history or sums.
    pub fn restart(&mut self, seed: u32) -> Result<()> {
        self.shown = [None; 2];
        match &mut self.technique {
            Technique::PathTracing(tracer) => tracer.restart(seed),
            Technique::Restir(frame) => frame.restart(seed),
        }
    }

    /// Submits a frame without waiting for it, if it is one of resampling; [`Device::wait_for_running`] does, and returns the
    /// times. Path tracing waits, and returns them here.
    pub fn submit_frame(&mut self, number: u32) -> Result<Option<Vec<PassTime>>> {
        if let Technique::PathTracing(_) = self.technique {
            return self.single_frame(number).map(Some);
        }
        let camera = self.begin()?;
        if let Technique::Restir(frame) = &mut self.technique {
            frame.submit(number, camera)?;
        }
        Ok(None)
    }

    /// Renders one frame by itself, for [`Self::frame_radiance`]. Returns the time of each run of a pass.
    pub fn single_frame(&mut self, number: u32) -> Result<Vec<PassTime>> {
        let camera = self.begin()?;
        match &mut self.technique {
            Technique::PathTracing(tracer) => {
                tracer.set_camera(camera);
                tracer.forget()?;
                tracer.add_samples(number, 1, &mut |_| Ok(()))
            }
            Technique::Restir(frame) => frame.render(number, camera),
        }
    }

    /// Makes the last single frame the only one in the sums.
    pub fn keep_single_frame(&mut self) -> Result<()> {
        match &mut self.technique {
            // It is alone in there.
            Technique::PathTracing(_) => Ok(()),
            Technique::Restir(frame) => frame.keep_last_frame(),
        }
    }

    /// A pass that makes pictures as a display shows them.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn display(&self) -> Result<Display> {
        let ViewConstants { width, height, .. } = self.constants.view;
        let pixels = u64::from(width) * u64::from(height);
        Display::new(&self.device, &self.bindings, pixels)
    }

    /// Shows the last frame, or the mean of `samples` samples of path tracing, on `display`: radiance × 2^`exposure`,
    /// tone-mapped.
    pub fn show(
        &self,
        display: &Display,
        samples: u32,
        exposure: f32,
        begins_with_blue: bool,
    ) -> Result<()> {
        let unit = self.bindings.scene.units.radiance * f64::from(exposure).exp2();
        let (parts, scale) = match &self.technique {
            Technique::PathTracing(tracer) => (tracer.radiance(), unit / f64::from(samples)),
            Technique::Restir(frame) => (vec![frame.radiance()], unit),
        };
        display.map(&parts, scale as f32, begins_with_blue)
    }

    /// The radiance of the last single frame, row by row from the top.
    pub fn frame_radiance(&self) -> Result<Vec<[f32; 3]>> {
        let unit = self.bindings.scene.units.radiance;
        let in_scene = |radiance: Vec3| (radiance.as_dvec3() * unit).as_vec3().to_array();
        match &self.technique {
            Technique::PathTracing(tracer) => {
                let sums = tracer.sums()?;
                Ok(sums.iter().map(|p| in_scene(p.sum)).collect())
            }
            Technique::Restir(frame) => Ok(frame.color()?.into_iter().map(in_scene).collect()),
        }
    }

    /// The surfaces through the pixels' centres in the last frame, row by row from the top.
    pub fn primary_surfaces(&mut self) -> Result<Vec<PrimarySurface>> {
        let primary_surfaces = match self.primary_surfaces.take() {
            Some(made) => made,
            None => PrimarySurfaces::new(&self.device, &self.bindings)?,
        };
        let shown = self.shown[0].unwrap_or(self.next);
        let before = self.shown[1].unwrap_or(shown);
        self.bindings.scene.set_pose(shown.time, before.time)?;
        let mut constants = self.constants;
        constants.view.camera = shown.camera;
        let surfaces = primary_surfaces.read(&constants, before.camera);
        self.primary_surfaces = Some(primary_surfaces);
        let length = self.bindings.scene.units.length;
        let mut surfaces = surfaces?;
        for surface in &mut surfaces {
            surface.depth = (f64::from(surface.depth) * length) as f32;
        }
        Ok(surfaces)
    }

    /// The contents of the last frame's reservoirs of a kind of light, row by row from the top.
    ///
    /// # Errors
    /// Path tracing, which has none, or the device fails.
    pub fn reservoir_aovs(&self, lighting: Lighting) -> Result<Vec<ReservoirAov>> {
        match &self.technique {
            Technique::PathTracing(_) => Err(Error::input(
                "path tracing has no reservoirs to look into; use integrator=restir",
            )),
            Technique::Restir(frame) => {
                let mut reservoirs = frame.reservoir_aovs(lighting)?;
                // Samples of direct light on other lights than triangles have other measures.
                let triangles = self.bindings.scene.counts.triangle_lights;
                let area = self.bindings.scene.units.length.powi(2);
                for reservoir in &mut reservoirs {
                    if lighting == Lighting::Indirect || u64::from(reservoir.light) < triangles {
                        reservoir.weight = (f64::from(reservoir.weight) * area) as f32;
                    }
                }
                Ok(reservoirs)
            }
        }
    }

    /// The sums of all pixels.
    pub fn sums(&self) -> Result<Sums> {
        Ok(Sums {
            pixels: match &self.technique {
                Technique::PathTracing(tracer) => tracer.sums()?,
                Technique::Restir(frame) => frame.sums(),
            },
            unit: self.bindings.scene.units.radiance,
        })
    }

    /// Replaces each pixel's sums by those of an earlier run of the same scene, as many as the picture has pixels.
    ///
    /// # Errors
    /// The device fails, or frames depend on a history that sums do not hold.
    pub fn set_sums(&self, sums: &[PixelSums]) -> Result<()> {
        match &self.technique {
            Technique::PathTracing(tracer) => tracer.set_sums(sums),
            Technique::Restir(_) => Err(Error::input(
                "only path tracing can be resumed; use --preset path-tracing",
            )),
        }
    }

    /// The counts of each pass since the last call; empty unless [`Tracking::counts`].
    pub fn counts(&mut self) -> Result<Vec<Counts>> {
        match &mut self.technique {
            Technique::PathTracing(tracer) => tracer.counts(),
            Technique::Restir(frame) => frame.counts(),
        }
    }

    /// Values refused so far because they were NaN, negative or beyond
    /// [`crate::shader_interface::MAX_RADIANCE`].
    pub fn rejected(&self) -> Result<u32> {
        match &self.technique {
            Technique::PathTracing(tracer) => tracer.rejected(),
            Technique::Restir(frame) => frame.rejected(),
        }
    }
}
