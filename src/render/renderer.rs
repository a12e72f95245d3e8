//! One view of a scene, rendered by the technique that the settings ask for.

use super::aovs::Aovs;
use super::camera::gpu_camera;
use super::counters::Counts;
use super::frame::{Frame, Tracking};
use super::kind::Kind;
use super::offered::Offered;
use super::path_tracing::PathTracer;
use super::settings::{Heuristic, Integrator, Settings};
use super::view::View;
use crate::gpu::{Device, PassTime};
use crate::layouts::{
    FrameConstants, GpuCamera, HEURISTIC_BALANCE, HEURISTIC_POWER, PixelSums, PrimarySurface,
    ReservoirAov,
};
use crate::scene::Camera;
use crate::tracing::GpuScene;
use crate::{Error, Result};
use std::sync::Arc;

/// Renders one view of a scene; what each call adds is summed up for each pixel.
pub struct Renderer {
    device: Arc<Device>,
    offered: Arc<Offered>,
    constants: FrameConstants,
    technique: Technique,
    aovs: Option<Aovs>,
    /// What the next frame shows.
    next: Moment,
    /// What the last frame showed, and what the one before it did, if there were any.
    shown: [Option<Moment>; 2],
}

/// A time, and where the camera is then.
#[derive(Clone, Copy)]
struct Moment {
    /// In seconds.
    time: f64,
    camera: GpuCamera,
}

enum Technique {
    PathTracing(Box<PathTracer>),
    Resampling(Box<Frame>),
}

impl Renderer {
    /// Makes the passes and buffers that `settings` need.
    ///
    /// # Errors
    /// More memory than the device has, or a shader that it refuses.
    pub fn new(
        device: &Arc<Device>,
        scene: Arc<GpuScene>,
        view: &View,
        settings: &Settings,
    ) -> Result<Self> {
        Self::tracking(device, scene, view, settings, Tracking::default())
    }

    /// The same, keeping what is asked for beside the picture.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn tracking(
        device: &Arc<Device>,
        scene: Arc<GpuScene>,
        view: &View,
        settings: &Settings,
        tracking: Tracking,
    ) -> Result<Self> {
        let constants = FrameConstants {
            camera: gpu_camera(&view.camera, scene.origin, view.width, view.height),
            width: view.width,
            height: view.height,
            interleave: device.info.interleave(),
            seed: view.seed,
            first_sample: 0,
            samples: 1,
            bounces: view.bounces,
            jitter: view.jitter.into(),
            heuristic: match settings.heuristic {
                Heuristic::Balance => HEURISTIC_BALANCE,
                Heuristic::Power => HEURISTIC_POWER,
            },
            lights: scene.light_count,
            roulette_start: settings.roulette.start,
            roulette_floor: settings.roulette.floor,
        };
        let offered = Arc::new(Offered::new(device, scene, settings)?);
        let technique = match settings.integrator {
            Integrator::PathTracing => Technique::PathTracing(Box::new(PathTracer::new(
                device,
                &offered,
                constants,
                tracking.counts,
            )?)),
            Integrator::Restir => {
                let frame = Frame::new(device, &offered, &constants, settings, tracking)?;
                Technique::Resampling(Box::new(frame))
            }
        };
        Ok(Self {
            device: device.clone(),
            offered,
            next: Moment {
                time: 0.0,
                camera: constants.camera,
            },
            shown: [None; 2],
            constants,
            technique,
            aovs: None,
        })
    }

    /// Lets the frames and samples that follow show the scene at a time in seconds. At first it is
    /// 0. The camera stays where it is.
    pub fn set_time(&mut self, seconds: f64) {
        self.next.time = seconds;
    }

    /// Lets the frames and samples that follow be seen by another camera, such as
    /// [`crate::scene::Scene::camera_at`] gives.
    pub fn set_camera(&mut self, camera: &Camera) {
        let FrameConstants { width, height, .. } = self.constants;
        self.next.camera = gpu_camera(camera, self.offered.scene.origin, width, height);
    }

    /// Lets the scene stand as the next frame shows it.
    fn begin(&mut self) -> Result<GpuCamera> {
        let next = self.next;
        let before = self.shown[0].unwrap_or(next);
        self.offered.scene.stand(next.time, before.time)?;
        self.shown = [Some(next), self.shown[0]];
        Ok(next.camera)
    }

    /// Whether a frame depends on those before it.
    pub fn has_history(&self) -> bool {
        match &self.technique {
            Technique::PathTracing(_) => false,
            Technique::Resampling(frame) => frame.has_history(),
        }
    }

    /// Adds `samples` samples or frames, numbered from `first`, to every pixel.
    ///
    /// # Errors
    /// The device fails.
    pub fn add_samples(&mut self, first: u32, samples: u32) -> Result<Vec<PassTime>> {
        self.add_samples_watched(first, samples, &mut |_| Ok(()))
    }

    /// [`Self::add_samples`]; `watch` is told now and then which share of the work is done. It can
    /// end the work by an error: the pixels then differ in how many samples they have.
    ///
    /// # Errors
    /// Those of [`Self::add_samples`] and of `watch`.
    pub fn add_samples_watched(
        &mut self,
        first: u32,
        samples: u32,
        watch: &mut dyn FnMut(f64) -> Result<()>,
    ) -> Result<Vec<PassTime>> {
        let mut times = Vec::new();
        let frames = match self.technique {
            // Samples of one moment need not be told apart.
            Technique::PathTracing(_) => 1,
            Technique::Resampling(_) => samples,
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
                Technique::Resampling(frame) => frame.add_frame(first + number, camera)?,
            };
        }
        Ok(times)
    }

    /// Renders a frame for the sake of those that follow.
    ///
    /// # Errors
    /// The device fails.
    pub fn skip_frame(&mut self, number: u32) -> Result<Vec<PassTime>> {
        let camera = self.begin()?;
        match &mut self.technique {
            Technique::PathTracing(_) => Ok(Vec::new()),
            Technique::Resampling(frame) => frame.render(number, camera),
        }
    }

    /// Bytes on the device that resampling keeps for each pixel, over all buffers; 0 for path
    /// tracing, whose sums are its result.
    pub fn bytes_per_pixel(&self) -> f64 {
        let Technique::Resampling(frame) = &self.technique else {
            return 0.0;
        };
        frame.bytes() as f64 / (f64::from(self.constants.width) * f64::from(self.constants.height))
    }

    /// Begins anew with another seed, without history or sums.
    ///
    /// # Errors
    /// The device fails.
    pub fn restart(&mut self, seed: u32) -> Result<()> {
        self.shown = [None; 2];
        match &mut self.technique {
            Technique::PathTracing(tracer) => tracer.restart(seed),
            Technique::Resampling(frame) => frame.restart(seed),
        }
    }

    /// Renders one frame by itself, for [`Self::frame_radiance`].
    ///
    /// # Errors
    /// The device fails.
    pub fn single_frame(&mut self, number: u32) -> Result<Vec<PassTime>> {
        let camera = self.begin()?;
        match &mut self.technique {
            Technique::PathTracing(tracer) => {
                tracer.set_camera(camera);
                tracer.forget()?;
                tracer.add_samples(number, 1, &mut |_| Ok(()))
            }
            Technique::Resampling(frame) => frame.render(number, camera),
        }
    }

    /// The radiance of the last single frame, row by row from the top.
    ///
    /// # Errors
    /// The device fails.
    pub fn frame_radiance(&self) -> Result<Vec<[f32; 3]>> {
        match &self.technique {
            Technique::PathTracing(tracer) => {
                let sums = tracer.sums()?;
                Ok(sums.iter().map(|p| p.sum.to_array()).collect())
            }
            Technique::Resampling(frame) => {
                Ok(frame.color()?.into_iter().map(|c| c.to_array()).collect())
            }
        }
    }

    /// What the camera sees in the last frame through each pixel's centre, row by row from the top.
    ///
    /// # Errors
    /// The device fails.
    pub fn primary_surfaces(&mut self) -> Result<Vec<PrimarySurface>> {
        let aovs = match self.aovs.take() {
            Some(aovs) => aovs,
            None => Aovs::new(&self.device, &self.offered)?,
        };
        let shown = self.shown[0].unwrap_or(self.next);
        let before = self.shown[1].unwrap_or(shown);
        self.offered.scene.stand(shown.time, before.time)?;
        let constants = FrameConstants {
            camera: shown.camera,
            ..self.constants
        };
        let surfaces = aovs.surfaces(&constants, before.camera);
        self.aovs = Some(aovs);
        surfaces
    }

    /// What the last frame left in its reservoirs of a kind of light, row by row from the top.
    ///
    /// # Errors
    /// Path tracing, which has none, or the device fails.
    pub fn reservoir_aovs(&self, kind: Kind) -> Result<Vec<ReservoirAov>> {
        match &self.technique {
            Technique::PathTracing(_) => Err(Error::input(
                "path tracing has no reservoirs to look into; use integrator=restir",
            )),
            Technique::Resampling(frame) => frame.reservoir_aovs(kind),
        }
    }

    /// Each pixel's sums, row by row from the top.
    ///
    /// # Errors
    /// The device fails.
    pub fn sums(&self) -> Result<Vec<PixelSums>> {
        match &self.technique {
            Technique::PathTracing(tracer) => tracer.sums(),
            Technique::Resampling(frame) => Ok(frame.sums()),
        }
    }

    /// Replaces each pixel's sums by those of an earlier run, as many as the picture has pixels.
    ///
    /// # Errors
    /// The device fails, or frames depend on a history that sums do not hold.
    pub fn set_sums(&self, sums: &[PixelSums]) -> Result<()> {
        match &self.technique {
            Technique::PathTracing(tracer) => tracer.set_sums(sums),
            Technique::Resampling(_) => Err(Error::input(
                "only path tracing can be resumed; use --preset path-tracing",
            )),
        }
    }

    /// What each pass counted since the last call; empty unless [`Tracking::counts`].
    ///
    /// # Errors
    /// The device fails.
    pub fn counts(&mut self) -> Result<Vec<Counts>> {
        match &mut self.technique {
            Technique::PathTracing(tracer) => tracer.counts(),
            Technique::Resampling(frame) => frame.counts(),
        }
    }

    /// Values refused so far because they were NaN, negative or beyond
    /// [`crate::layouts::MOST_RADIANCE`].
    ///
    /// # Errors
    /// The device fails.
    pub fn rejected(&self) -> Result<u32> {
        match &self.technique {
            Technique::PathTracing(tracer) => tracer.rejected(),
            Technique::Resampling(frame) => frame.rejected(),
        }
    }
}
