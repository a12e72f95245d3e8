//! MIS path tracing: samples add up over calls; the reference that all else is judged against.

use super::offered::Offered;
use super::strips::strips_of;
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage};
use crate::layouts::{COUNTER_REJECTED, COUNTERS, FrameConstants, PixelSums, Strip};
use crate::{Error, Result};
use std::sync::Arc;

crate::bindings! {
    /// What the pass `path_trace` is bound to.
    pub struct PathTrace {
        [offers scene: Offered]
        uniform frame,
        write sums,
        write counters,
    }
}

/// Path traces one view of a scene; each pixel's samples add up over calls.
pub struct PathTracer {
    device: Arc<Device>,
    offered: Arc<Offered>,
    constants: FrameConstants,
    path_trace: ComputePass,
    frame: Buffer,
    /// The picture from top to bottom, each strip with its pixels' sums.
    strips: Vec<(Strip, Buffer)>,
    counters: Buffer,
}

impl PathTracer {
    /// Makes the pass and its buffers.
    ///
    /// # Errors
    /// More memory than the device has, or a shader that it refuses.
    pub fn new(
        device: &Arc<Device>,
        offered: &Arc<Offered>,
        constants: FrameConstants,
    ) -> Result<Self> {
        let plain = Usage::default();
        let uniform = Usage {
            uniform: true,
            ..plain
        };
        let (width, height) = (constants.width, constants.height);
        let tracer = Self {
            path_trace: offered.pass("path_trace", &[])?,
            frame: Buffer::new(device, "frame", size_of::<FrameConstants>() as u64, uniform)?,
            strips: strips_of::<PixelSums>(device, "sums", width, height)?,
            counters: Buffer::new(device, "counters", u64::from(COUNTERS) * 4, plain)?,
            offered: offered.clone(),
            constants,
            device: device.clone(),
        };
        let mut recording = Recording::new(device)?;
        for (_, sums) in &tracer.strips {
            recording.clear(sums);
        }
        recording.clear(&tracer.counters);
        recording.finish()?;
        Ok(tracer)
    }

    /// Adds `samples` samples, numbered from `first`, to every pixel.
    ///
    /// # Errors
    /// The device fails.
    pub fn add_samples(&mut self, first: u32, samples: u32) -> Result<Vec<PassTime>> {
        self.constants.first_sample = first;
        self.constants.samples = samples;
        self.frame.write(&[self.constants])?;
        let mut times = Vec::new();
        for (strip, sums) in &self.strips {
            let bindings = PathTrace {
                scene: self.offered.as_ref(),
                frame: &self.frame,
                sums,
                counters: &self.counters,
            };
            let groups = strip.groups(self.constants.width);
            let mut recording = Recording::new(&self.device)?;
            recording.pass(&self.path_trace, &bindings, strip, groups)?;
            PassTime::add(&mut times, recording.finish()?);
        }
        Ok(times)
    }

    /// Each pixel's sums, row by row from the top.
    ///
    /// # Errors
    /// The device fails.
    pub fn sums(&self) -> Result<Vec<PixelSums>> {
        let FrameConstants { width, height, .. } = self.constants;
        let mut all = Vec::with_capacity(width as usize * height as usize);
        for (strip, sums) in &self.strips {
            all.extend(sums.read::<PixelSums>(strip.pixels(width))?);
        }
        Ok(all)
    }

    /// Replaces each pixel's sums by those of an earlier run, as many as the picture has pixels.
    ///
    /// # Errors
    /// The device fails.
    pub fn set_sums(&self, sums: &[PixelSums]) -> Result<()> {
        let mut rest = sums;
        for (strip, buffer) in &self.strips {
            let (own, after) = rest
                .split_at_checked(strip.pixels(self.constants.width))
                .ok_or_else(|| Error::failed("the earlier run has too few pixels"))?;
            buffer.write(own)?;
            rest = after;
        }
        Ok(())
    }

    /// Values refused so far because they were NaN, negative or beyond [`crate::layouts::MOST_RADIANCE`].
    ///
    /// # Errors
    /// The device fails.
    pub fn rejected(&self) -> Result<u32> {
        let counters: Vec<u32> = self.counters.read(COUNTERS as usize)?;
        Ok(counters[COUNTER_REJECTED as usize])
    }
}
