//! MIS path tracing: samples add up over calls. It is the reference for everything else.

use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage};
use crate::render::counters::{Counters, Counts};
use crate::render::outputs::display::Radiance;
use crate::render::scene_bindings::SceneBindings;
use crate::render::strips::strips_of;
use crate::shader_interface::{FrameConstants, GpuCamera, PixelSums, Strip};
use crate::{Error, Result};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass.
    pub struct PathTrace {
        [offers scene: SceneBindings]
        uniform frame,
        write sums,
        write counters,
    }
}

/// Loop iterations that a ray may take on drivers that limit them. Rays in `night-city` take up to 128, the
/// maximum over the eight rays of a subgroup.
const STEPS_PER_RAY: u32 = 512;

/// Path traces one view of a scene; each pixel's samples add up over calls.
pub struct PathTracer {
    device: Arc<Device>,
    bindings: Arc<SceneBindings>,
    constants: FrameConstants,
    path_trace: ComputePass,
    frame: Buffer,
    /// The picture from top to bottom, each strip with its pixels' sums.
    strips: Vec<(Strip, Buffer)>,
    counters: Counters,
}

impl PathTracer {
    /// Makes the pass and its buffers.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(
        device: &Arc<Device>,
        bindings: &Arc<SceneBindings>,
        constants: FrameConstants,
        counting: bool,
    ) -> Result<Self> {
        let plain = Usage::default();
        let uniform = Usage {
            uniform: true,
            ..plain
        };
        let (width, height) = (constants.view.width, constants.view.height);
        let counters = Counters::new(device, counting)?;
        let tracer = Self {
            path_trace: bindings.pass(
                "path_trace",
                &counters.specialise("path_trace", bindings.specialisation)?,
            )?,
            frame: Buffer::new(device, "frame", size_of::<FrameConstants>() as u64, uniform)?,
            strips: strips_of::<PixelSums>(device, "sums", width, height)?,
            counters,
            bindings: bindings.clone(),
            constants,
            device: device.clone(),
        };
        tracer.forget()?;
        Ok(tracer)
    }

    /// Sets all sums to zero.
    pub fn forget(&self) -> Result<()> {
        let mut recording = Recording::new(&self.device)?;
        for (_, sums) in &self.strips {
            recording.clear(sums);
        }
        recording.finish().map(drop)
    }

    /// Begins anew with another seed.
    pub fn restart(&mut self, seed: u32) -> Result<()> {
        self.constants.view.seed = seed;
        self.counters.clear()?;
        self.forget()
    }

    /// Sets the camera of the next samples.
    pub fn set_camera(&mut self, camera: GpuCamera) {
        self.constants.view.camera = camera;
    }

    /// Adds `samples` samples, numbered from `first`, to every pixel. `watch` is called between
    /// strips with the share of the work that is done. If it returns an error the work ends, and pixels then
    /// differ in their number of samples.
    ///
    /// # Errors
    /// The device fails, its driver is known to end loops early and did, or those of `watch`.
    pub fn add_samples(
        &mut self,
        first: u32,
        samples: u32,
        watch: &mut dyn FnMut(f64) -> Result<()>,
    ) -> Result<Vec<PassTime>> {
        let mut times = Vec::new();
        let at_once = self.samples_at_once();
        for done in (0..samples).step_by(at_once as usize) {
            self.constants.first_sample = first + done;
            self.constants.samples = at_once.min(samples - done);
            for (number, (strip, sums)) in self.strips.iter().enumerate() {
                if number > 0 {
                    let of_strips = number as f64 / self.strips.len() as f64;
                    let samples_done = of_strips * f64::from(self.constants.samples);
                    watch((f64::from(done) + samples_done) / f64::from(samples))?;
                }
                let bindings = PathTrace {
                    scene: &self.bindings,
                    frame: &self.frame,
                    sums,
                    counters: &self.counters.buffer,
                };
                let groups = strip.groups(self.constants.view.width);
                let mut recording = Recording::new(&self.device)?;
                recording.update(&self.frame, &self.constants)?;
                recording.pass(&self.path_trace, &bindings, strip, groups)?;
                PassTime::add(&mut times, recording.finish()?);
            }
        }
        // Elsewhere the counters are looked at when the picture is read.
        if self.device.info.loop_turns.is_some() {
            self.counters.assert_whole()?;
        }
        Ok(times)
    }

    /// Maximum samples of a dispatch, so that a driver that limits loop iterations does not end it early.
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

    /// Each pixel's sums, row by row from the top.
    pub fn sums(&self) -> Result<Vec<PixelSums>> {
        let (width, height) = (self.constants.view.width, self.constants.view.height);
        let mut all = Vec::with_capacity(width as usize * height as usize);
        for (strip, sums) in &self.strips {
            all.extend(sums.read::<PixelSums>(strip.pixels(width))?);
        }
        Ok(all)
    }

    /// The sums of all pixels, on the device.
    pub fn radiance(&self) -> Vec<Radiance<'_>> {
        let width = self.constants.view.width;
        let parts = self.strips.iter().map(|(strip, sums)| Radiance {
            buffer: sums,
            stride: (size_of::<PixelSums>() / size_of::<f32>()) as u32,
            first_pixel: strip.first_row * width,
            pixels: strip.rows * width,
        });
        parts.collect()
    }

    /// Replaces each pixel's sums by those of an earlier run, as many as the picture has pixels.
    pub fn set_sums(&self, sums: &[PixelSums]) -> Result<()> {
        let mut rest = sums;
        for (strip, buffer) in &self.strips {
            let (own, after) = rest
                .split_at_checked(strip.pixels(self.constants.view.width))
                .ok_or_else(|| Error::failed("the earlier run has too few pixels"))?;
            buffer.write(own)?;
            rest = after;
        }
        Ok(())
    }

    /// Values refused so far because they were NaN, negative or beyond [`crate::shader_interface::MAX_RADIANCE`].
    ///
    /// # Errors
    /// The device fails, or its driver ended loops early.
    pub fn rejected(&self) -> Result<u32> {
        self.counters.rejected()
    }

    /// The counts since the last call, if counting was asked for.
    pub fn counts(&mut self) -> Result<Vec<Counts>> {
        self.counters.since_last()
    }
}
