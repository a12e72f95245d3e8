//! The renderer of one view of a scene, with the integrator that the settings select.
//!
//! Methods that return a [`Result`] fail if the device fails, if its driver rejects a shader, or if the scene cannot be
//! posed at the time of a frame. `# Errors` sections name other errors.

use super::camera::{camera_model, gpu_camera};
use super::counters::Counts;
use super::integrators::{Integrator, PathTracer, Restir};
use super::light_samplers::light_bvh::LightBvhBuffer;
use super::lighting::Lighting;
use super::outputs::display::Display;
use super::outputs::primary_surfaces::PrimarySurfaces;
use super::outputs::{Accumulator, Radiance, Sums};
use super::resolved_settings::ResolvedSettings;
use super::scene_bindings::SceneBindings;
use super::settings::{self, DirectMode, Energy, Settings, Variant};
use super::tracking::Tracking;
use super::view::View;
use crate::base::progress::Watch;
use crate::device_scene::GpuScene;
use crate::gpu::{Device, PassTime};
use crate::scene::{Camera, MovingCamera};
use crate::shader_interface::{
    CameraModel, FrameConstants, GpuCamera, PixelSums, PrimarySurface, ReservoirAov,
    Specialisation, ViewConstants,
};
use crate::{Error, Result};
use glam::Vec3;
use std::sync::Arc;

/// The renderer of one view of a scene (camera, size of the picture, seed and bounces). It renders single frames, or adds
/// samples to one sum per pixel, over all calls of [`Self::add_samples`].
pub struct Renderer {
    device: Arc<Device>,
    bindings: Arc<SceneBindings>,
    constants: FrameConstants,
    integrator: Box<dyn Integrator>,
    sums: Accumulator,
    primary_surfaces: Option<PrimarySurfaces>,
    /// The time and the camera of the next frame, which the setters of this type change.
    next: Moment,
    /// The time and the camera of the last frame, then those of the frame before it. Motion vectors, and the state of the
    /// scene in the previous frame that shaders see, follow from them. An entry is `None` if there was no such frame since
    /// the last restart.
    shown: [Option<Moment>; 2],
}

/// A time in the scene, and the camera of the frame that shows the scene at that time. The renderer stores the moments of
/// successive frames, because motion is the difference between them.
#[derive(Clone, Copy)]
struct Moment {
    /// The time in the scene, in seconds.
    time: f64,
    camera: GpuCamera,
    /// The model of the camera, which must be that of the renderer's shaders.
    model: CameraModel,
}

impl Renderer {
    /// Makes a renderer with the passes and buffers that `settings` need. Settings that depend on the scene, such as
    /// `candidates=auto`, are decided first.
    ///
    /// # Errors
    /// The picture is too large, or a buffer exceeds a limit or the free memory of the device. A shader that the driver
    /// rejects is an error of the first frame.
    pub fn new(
        device: &Arc<Device>,
        scene: Arc<GpuScene>,
        view: &View,
        settings: &Settings,
    ) -> Result<Self> {
        let settings = ResolvedSettings::new(settings, &scene, view.bounces);
        Self::tracking(device, scene, view, &settings, Tracking::default())
    }

    /// Makes a renderer from `settings` in which all choices are already made for this scene and for the bounces of `view`.
    /// Unlike with [`Self::new`], the caller also selects the data that the renderer collects besides the picture
    /// (`tracking`), such as the number of rays.
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
            camera_model: camera_model(&view.camera),
            tracks_coverage: tracking.coverage,
            ..scene.specialisation(settings.variant == Variant::Full)
        };
        let options = settings.light_bvh_options();
        let light_bvh = LightBvhBuffer::new(device, &scene, &settings.light_bvh, options)?;
        let light_nodes = light_bvh.node_count;
        let bindings = SceneBindings::new(device, scene, specialisation, Box::new(light_bvh))?;
        let bindings = Arc::new(bindings);
        let mut sums = Accumulator::new(device, &bindings, view.width, view.height);
        let integrator: Box<dyn Integrator> = match settings.integrator {
            settings::Integrator::PathTracing => Box::new(PathTracer::new(
                device,
                &bindings,
                constants,
                tracking.counts,
                &mut sums,
            )?),
            settings::Integrator::Restir => Box::new(Restir::new(
                device,
                &bindings,
                &constants.view,
                view.jitter,
                settings,
                light_nodes,
                tracking,
            )?),
        };
        Ok(Self {
            device: device.clone(),
            bindings,
            next: Moment {
                time: 0.0,
                camera: constants.view.camera,
                model: camera_model(&view.camera),
            },
            shown: [None; 2],
            constants,
            integrator,
            sums,
            primary_surfaces: None,
        })
    }

    /// The name and the size in bytes of the light BVH's buffer, for reports of memory; `None` if no candidates are drawn
    /// from a light BVH (a tree of lights).
    pub fn light_bvh_memory(&self) -> Option<(&'static str, u64)> {
        self.bindings.light_bvh_memory()
    }

    /// Sets the time in the scene, in seconds, that the next frames and samples show; it is 0 before the first call. The
    /// camera does not move.
    pub fn set_time(&mut self, seconds: f64) {
        self.next.time = seconds;
    }

    /// Sets the camera of the next frames and samples, for example to the camera that [`crate::scene::Scene::camera_at`]
    /// returns. A camera of another model than the first one (pinhole, lens, orthographic) is an error of the next frame,
    /// because the shaders are specialised for it.
    pub fn set_camera(&mut self, camera: &Camera) {
        let ViewConstants { width, height, .. } = self.constants.view;
        let units = &self.bindings.scene.units;
        self.next.camera = gpu_camera(camera, units, width, height);
        self.next.model = camera_model(camera);
    }

    /// Sets the time in the scene, in seconds, that the next frames and samples show, and moves the camera to where `camera`
    /// is at that time. With `None`, the camera does not move.
    ///
    /// # Errors
    /// The camera does not exist in the scene, or has no direction at that time.
    pub fn set_moment(&mut self, seconds: f64, camera: Option<&MovingCamera>) -> Result<()> {
        self.set_time(seconds);
        if let Some(camera) = camera {
            self.set_camera(&camera.at(seconds)?);
        }
        Ok(())
    }

    /// Begins the next frame: moves the scene to its state at the time of this frame, and lets shaders also see the state at
    /// the time of the last frame. The time and the camera of the new frame become the first entry of `shown`. Returns the
    /// camera of the new frame.
    fn begin(&mut self) -> Result<GpuCamera> {
        let next = self.next;
        let model = self.bindings.specialisation.camera_model;
        if next.model != model {
            return Err(Error::input(format!(
                "the camera is of the model {:?}, but this renderer was made for {model:?}; make another renderer for it",
                next.model
            )));
        }
        let before = self.shown[0].unwrap_or(next);
        self.bindings.set_pose(next.time, before.time)?;
        self.shown = [Some(next), self.shown[0]];
        Ok(next.camera)
    }

    /// True if a frame depends on the frames before it, because it reuses their samples. Then every frame of a run must be
    /// rendered, in order. Such a run cannot be continued later from its sums of radiance alone.
    pub fn has_history(&self) -> bool {
        self.integrator.has_history()
    }

    /// Adds `samples` samples per pixel to the sums of radiance. The samples have the indices `first`, `first` + 1 and so
    /// on, from which their random numbers follow. With resampling, each sample is a frame, and the result is the time of
    /// each pass in the last frame. With path tracing, the result is the time of the pass over all samples of the call, which
    /// one dispatch per strip of the picture renders. Some drivers end a dispatch that takes seconds, so add few samples per
    /// call.
    ///
    /// # Errors
    /// The device fails.
    pub fn add_samples(&mut self, first: u32, samples: u32) -> Result<Vec<PassTime>> {
        self.add_samples_watched(first, samples, &mut |_| Ok(()))
    }

    /// Adds `samples` samples per pixel to the sums and returns the times, as [`Self::add_samples`] does, but reports its
    /// progress. It calls `watch` repeatedly with the fraction of the work that is done, in [0, 1]. If `watch` returns an
    /// error, the work ends, and pixels may then differ in their number of samples.
    ///
    /// # Errors
    /// The errors of [`Self::add_samples`] and of `watch`.
    pub fn add_samples_watched(
        &mut self,
        first: u32,
        samples: u32,
        watch: &mut Watch<'_>,
    ) -> Result<Vec<PassTime>> {
        let most = self.integrator.samples_per_call();
        let mut times = Vec::new();
        for done in (0..samples).step_by(most as usize) {
            let count = most.min(samples - done);
            let mut watch_all = |fraction: f64| {
                watch((f64::from(done) + fraction * f64::from(count)) / f64::from(samples))
            };
            if done > 0 {
                watch_all(0.0)?;
            }
            let camera = self.begin()?;
            let (integrator, sums) = (&mut self.integrator, &mut self.sums);
            times = integrator.add(first + done, count, camera, sums, &mut watch_all)?;
        }
        Ok(times)
    }

    /// Renders the frame with the index `index` only as history for later frames; its radiance is not added to the sums. If
    /// frames do not depend on each other, it renders nothing and returns no times. It then only poses the scene, so that
    /// the motion vectors of the next frame are right.
    pub fn skip_frame(&mut self, index: u32) -> Result<Vec<PassTime>> {
        let camera = self.begin()?;
        if !self.integrator.has_history() {
            return Ok(Vec::new());
        }
        self.integrator.render(index, camera, &mut self.sums)
    }

    /// The size in bytes, divided by the number of pixels, of all buffers in which the integrator stores data between passes
    /// or between frames. Studies report it as the memory that the settings cost. The buffers of the scene and of the sums
    /// do not count, so the result is 0 for path tracing.
    pub fn bytes_per_pixel(&self) -> f64 {
        let ViewConstants { width, height, .. } = self.constants.view;
        self.integrator.bytes() as f64 / (f64::from(width) * f64::from(height))
    }

    /// Begins a new run with the same passes and buffers, so that it can be measured with another seed: sets the seed of the
    /// next frames, forgets the history (the data of earlier frames), and sets the sums of radiance to zero. The time and
    /// the camera of the next frame stay the same.
    pub fn restart(&mut self, seed: u32) -> Result<()> {
        self.shown = [None; 2];
        self.sums.clear()?;
        self.integrator.restart(seed)
    }

    /// Submits the frame with the index `index`, as [`Self::single_frame`] renders it, without waiting for the device, so
    /// that the next frame can be submitted meanwhile. Returns `None`; [`Device::wait_for_running`] then waits, and returns
    /// the times of the frame's passes. With path tracing, this method waits, and returns the times itself.
    pub fn submit_frame(&mut self, index: u32) -> Result<Option<Vec<PassTime>>> {
        let camera = self.begin()?;
        self.integrator.submit(index, camera, &mut self.sums)
    }

    /// Renders the frame with the index `index`. [`Self::frame_radiance`] then reads its radiance, which is not added to the
    /// sums. With path tracing, the sums are first set to zero, and then contain this frame alone. Returns the time of each
    /// run of a pass.
    pub fn single_frame(&mut self, index: u32) -> Result<Vec<PassTime>> {
        let camera = self.begin()?;
        self.integrator.render(index, camera, &mut self.sums)
    }

    /// Replaces the sums of radiance by the radiance of the last single frame, so that [`Self::sums`] returns the sums of
    /// this one sample. The caller must have called [`Self::single_frame`] before. With path tracing, this method does
    /// nothing, because the sums contain the frame already.
    pub fn keep_single_frame(&mut self) -> Result<()> {
        // Path tracing has no buffer of a single frame: its sums already contain this frame alone.
        if let Some(color) = self.integrator.color() {
            self.sums.clear()?;
            self.sums.add(color, self.integrator.covered())?;
        }
        Ok(())
    }

    /// The location on the device of the radiance that [`Self::show`] and [`Self::frame_radiance`] use. With resampling, it
    /// is the radiance of the last frame, in one part. With path tracing, it is the sums over all samples, with one part for
    /// each strip of the picture (group of whole rows).
    fn radiance(&self) -> Vec<Radiance<'_>> {
        let ViewConstants { width, height, .. } = self.constants.view;
        self.integrator.color().map_or_else(
            || self.sums.radiance(),
            |color| {
                vec![Radiance {
                    buffer: color,
                    stride: 3,
                    first_pixel: 0,
                    pixels: width * height,
                    samples: 1,
                }]
            },
        )
    }

    /// Makes the pass and the buffer with which [`Self::show`] converts the radiance of this renderer to the picture that a
    /// display shows.
    ///
    /// # Errors
    /// The buffer exceeds a limit or the free memory of the device.
    pub fn display(&self) -> Result<Display> {
        let ViewConstants { width, height, .. } = self.constants.view;
        let pixels = u64::from(width) * u64::from(height);
        Display::new(&self.device, &self.bindings, pixels)
    }

    /// Writes a picture to the buffer of `display`: the last frame or, with path tracing, the mean of all samples. The
    /// values are radiance × 2^`exposure`, tone-mapped. If `begins_with_blue` is true, blue is in the least significant byte
    /// of a pixel, otherwise red.
    pub fn show(&self, display: &Display, exposure: f32, begins_with_blue: bool) -> Result<()> {
        let unit = self.bindings.scene.units.radiance * f64::from(exposure).exp2();
        display.map(&self.radiance(), unit, begins_with_blue)
    }

    /// Reads the RGB radiance of the last frame: one entry per pixel, row by row from the top, in the scene's unit of
    /// radiance. Entries are 0 before the first frame. With path tracing, an entry is the sum over that frame and all
    /// samples that [`Self::add_samples`] added since; it is not divided by their number.
    pub fn frame_radiance(&self) -> Result<Vec<[f32; 3]>> {
        let unit = self.bindings.scene.units.radiance;
        let mut pixels = Vec::new();
        for part in self.radiance() {
            let in_scene = |radiance: Vec3| (radiance.as_dvec3() * unit).as_vec3().to_array();
            pixels.extend(part.read()?.into_iter().map(in_scene));
        }
        Ok(pixels)
    }

    /// Finds the surface that the ray through each pixel's centre (and a lens's centre) hits in the last frame (in the next frame, if none was
    /// rendered yet): one per pixel, row by row from the top. Depths are in scene units; 0 means that the pixel shows no
    /// surface. This call traces these rays, separately from the rays of the picture.
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

    /// The contents of the last frame's reservoirs of direct or of indirect light, for debugging: one entry per pixel, row
    /// by row from the top. Contribution weights that have the unit of an area are in squared scene units. All entries are
    /// empty if no frame was rendered, or if the light is not stored in reservoirs.
    ///
    /// # Errors
    /// The integrator is path tracing, which has no reservoirs, or the device fails.
    pub fn reservoir_aovs(&self, lighting: Lighting) -> Result<Vec<ReservoirAov>> {
        let mut reservoirs = self.integrator.reservoir_aovs(lighting)?;
        // Weights of samples on other lights than triangles do not have the unit of an area.
        let triangles = self.bindings.scene.counts.triangle_lights;
        let area = self.bindings.scene.units.length.powi(2);
        for reservoir in &mut reservoirs {
            if lighting == Lighting::Indirect || u64::from(reservoir.light) < triangles {
                reservoir.weight = (f64::from(reservoir.weight) * area) as f32;
            }
        }
        Ok(reservoirs)
    }

    /// Reads the radiance of each pixel, summed over the samples, from which the caller computes means and standard errors.
    /// Before the first sample, all sums are 0 with path tracing; with resampling, the result contains no pixels.
    pub fn sums(&self) -> Result<Sums> {
        Ok(Sums {
            pixels: self.sums.read()?,
            coverage: self.sums.read_coverage()?,
            unit: self.bindings.scene.units.radiance,
        })
    }

    /// Continues an earlier run of the same scene: replaces the sums of all pixels by `sums`, and the numbers of samples
    /// whose primary ray met a surface by `coverage`. They contain `samples` samples per pixel. There is one entry per pixel,
    /// row by row from the top. `coverage` has no effect unless [`Tracking::coverage`] is true.
    ///
    /// # Errors
    /// Frames depend on earlier frames, so that sums are not enough to continue a run; `sums` or `coverage` has fewer entries
    /// than there are pixels; or the device fails.
    pub fn set_sums(&mut self, sums: &[PixelSums], coverage: &[u32], samples: u32) -> Result<()> {
        if self.has_history() {
            return Err(Error::input(
                "frames that reuse those before them cannot be resumed; use --preset path-tracing",
            ));
        }
        self.sums.write(sums, coverage, samples)
    }

    /// The counts of each pass, such as its number of rays, since the last call or the last restart. Empty unless
    /// [`Tracking::counts`] is true.
    pub fn counts(&mut self) -> Result<Vec<Counts>> {
        self.integrator.counters().since_last()
    }

    /// The number of values that shaders replaced by 0 since the renderer was made or restarted; if it is not 0, the picture
    /// may be too dark. These are radiances that were NaN, negative or larger than
    /// [`crate::shader_interface::MAX_RADIANCE`], and weights of reservoirs that were NaN, negative or infinite.
    ///
    /// # Errors
    /// The device fails, or its driver ended loops of shaders early, so that some pixels are too dark.
    pub fn rejected(&mut self) -> Result<u32> {
        let passes = self.rejected_by_pass()?;
        Ok(passes
            .iter()
            .fold(0, |sum, (_, count)| sum.saturating_add(*count)))
    }

    /// The values of [`Self::rejected`] pass by pass: the name of each pass that rejected values, and the number of its
    /// values.
    ///
    /// # Errors
    /// As for [`Self::rejected`].
    pub fn rejected_by_pass(&mut self) -> Result<Vec<(String, u32)>> {
        self.integrator.counters().rejected()
    }
}
