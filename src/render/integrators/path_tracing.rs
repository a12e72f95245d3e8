//! The integrator of path tracing with multiple importance sampling (MIS). Each call of [`Integrator::add`] adds samples
//! to the sums of radiance of the pixels, so a picture can consist of the samples of many calls. Path tracing is the
//! unbiased reference with which all other estimators are compared.

use super::Integrator;
use crate::base::progress::Watch;
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage};
use crate::render::counters::Counters;
use crate::render::lighting::Lighting;
use crate::render::outputs::Accumulator;
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::{FrameConstants, GpuCamera, ReservoirAov};
use crate::{Error, Result};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass `path_trace`, which traces paths and adds their radiance to the sums of each pixel.
    pub struct PathTrace {
        [offers scene: SceneBindings]
        [optional write coverage]
        uniform frame,
        write sums,
        write counters,
    }
}

/// The number of loop iterations that a ray is assumed to take. On drivers that limit the loop iterations of an invocation,
/// it decides how many samples a dispatch may have; on others it has no effect. Higher: fewer samples per dispatch, so the
/// limit is less likely to be exceeded. For comparison: in the scene `night-city`, the slowest of the eight rays of a
/// subgroup takes up to 128 iterations.
const STEPS_PER_RAY: u32 = 512;

/// The integrator that traces paths for one view of a scene. Its pass adds many samples per dispatch directly to the sums of
/// radiance, so there is no picture of a single frame.
pub struct PathTracer {
    device: Arc<Device>,
    bindings: Arc<SceneBindings>,
    constants: FrameConstants,
    path_trace: ComputePass,
    frame: Buffer,
    counters: Counters,
}

impl PathTracer {
    /// Makes the integrator with its pass `path_trace` and its counters. Also makes the buffers of `sums`, to which the pass
    /// adds radiance. If `counting` is true, the pass also counts rays, lanes in use and bytes, which costs time.
    ///
    /// # Errors
    /// The buffers exceed a limit or the free memory of the device, one row of the picture is too wide for the device to
    /// bind or dispatch it, or the shader's interface cannot be bound by name.
    pub fn new(
        device: &Arc<Device>,
        bindings: &Arc<SceneBindings>,
        constants: FrameConstants,
        counting: bool,
        sums: &mut Accumulator,
    ) -> Result<Self> {
        sums.strips()?;
        let plain = Usage::default();
        let uniform = Usage {
            uniform: true,
            ..plain
        };
        let counters = Counters::new(device, counting)?;
        Ok(Self {
            path_trace: bindings.pass(
                "path_trace",
                &counters.specialise("path_trace", bindings.specialisation)?,
            )?,
            frame: Buffer::new(device, "frame", size_of::<FrameConstants>() as u64, uniform)?,
            counters,
            bindings: bindings.clone(),
            constants,
            device: device.clone(),
        })
    }

    /// The maximum number of samples per pixel and dispatch, at least 1. It is limited only on drivers that end a loop after
    /// a certain number of iterations. Such a driver would end the loop over many samples early, and pixels would be too
    /// dark.
    fn samples_at_once(&self) -> u32 {
        self.device.info.loop_turns.map_or(u32::MAX, |turns| {
            let rays = self
                .constants
                .view
                .bounces
                .saturating_add(1)
                .saturating_mul(2);
            (turns / STEPS_PER_RAY / rays).max(1)
        })
    }
}

impl Integrator for PathTracer {
    fn has_history(&self) -> bool {
        false
    }

    fn samples_per_call(&self) -> u32 {
        u32::MAX
    }

    /// Adds samples to the sums of radiance, as [`Integrator::add`] describes. The pass runs once for each strip of the
    /// picture (group of whole rows). On drivers that limit the number of loop iterations, it may run several times for each
    /// strip, each time with fewer samples.
    ///
    /// # Errors
    /// The device fails, or `watch` returns an error. On drivers that limit the number of loop iterations: a loop was ended
    /// early.
    fn add(
        &mut self,
        first: u32,
        samples: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
        watch: &mut Watch<'_>,
    ) -> Result<Vec<PassTime>> {
        self.constants.view.camera = camera;
        let mut times = Vec::new();
        let at_once = self.samples_at_once();
        let strips = sums.strips()?;
        for done in (0..samples).step_by(at_once as usize) {
            self.constants.first_sample = first + done;
            self.constants.samples = at_once.min(samples - done);
            for (index, part) in strips.iter().enumerate() {
                if index > 0 {
                    let strips_done = index as f64 / strips.len() as f64;
                    let samples_done = strips_done * f64::from(self.constants.samples);
                    watch((f64::from(done) + samples_done) / f64::from(samples))?;
                }
                let bindings = PathTrace {
                    scene: &self.bindings,
                    frame: &self.frame,
                    sums: &part.sums,
                    coverage: part.coverage.as_ref(),
                    counters: &self.counters.buffer,
                };
                let groups = part.strip.groups(self.constants.view.width);
                let mut recording = Recording::new(&self.device)?;
                recording.update(&self.frame, &self.constants)?;
                recording.pass(&self.path_trace, &bindings, &part.strip, groups)?;
                PassTime::add(&mut times, recording.finish()?);
            }
        }
        sums.count(samples);
        // On other drivers, the counters are checked when the picture is read.
        if self.device.info.loop_turns.is_some() {
            self.counters.assert_whole()?;
        }
        Ok(times)
    }

    fn render(
        &mut self,
        index: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
    ) -> Result<Vec<PassTime>> {
        sums.clear()?;
        self.add(index, 1, camera, sums, &mut |_| Ok(()))
    }

    fn color(&self) -> Option<&Buffer> {
        None
    }

    fn restart(&mut self, seed: u32) -> Result<()> {
        self.constants.view.seed = seed;
        self.counters.clear()
    }

    fn counters(&mut self) -> &mut Counters {
        &mut self.counters
    }

    fn bytes(&self) -> u64 {
        0
    }

    /// Returns an error, because path tracing has no reservoirs whose contents debug AOVs (additional channels of a picture)
    /// could show.
    ///
    /// # Errors
    /// This method always fails with an error for the user.
    fn reservoir_aovs(&self, _lighting: Lighting) -> Result<Vec<ReservoirAov>> {
        Err(Error::input(
            "path tracing has no reservoirs to look into; use integrator=restir",
        ))
    }
}
