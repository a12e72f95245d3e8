//! Sums over the samples of a picture, on the device.

use super::radiance::Radiance;
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, in_rows};
use crate::render::scene_bindings::SceneBindings;
use crate::render::strips::strips_of;
use crate::shader_interface::{PixelRange, PixelSums, Strip, TILE};
use crate::{Error, Result};
use std::sync::Arc;

crate::bindings! {
    /// The bindings of the pass.
    pub struct Accumulate {
        read color,
        write sums,
    }
}

/// The sums of each pixel over the samples that were added since the last [`Self::clear`].
pub struct Accumulator {
    device: Arc<Device>,
    width: u32,
    height: u32,
    bindings: Arc<SceneBindings>,
    /// Adds a picture; made at the first one, since path tracing adds none.
    pass: Option<ComputePass>,
    /// The picture from top to bottom, each strip with the sums of its pixels; empty before the first sample, so that single
    /// frames use no memory for sums.
    strips: Vec<(Strip, Buffer)>,
    samples: u32,
}

impl Accumulator {
    /// Sums of a picture of `width` × `height` pixels, without samples.
    pub fn new(
        device: &Arc<Device>,
        bindings: &Arc<SceneBindings>,
        width: u32,
        height: u32,
    ) -> Self {
        Self {
            device: device.clone(),
            width,
            height,
            bindings: bindings.clone(),
            pass: None,
            strips: Vec::new(),
            samples: 0,
        }
    }

    /// The strips with their sums, for a pass that adds to them; [`Self::count`] follows it.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn strips(&mut self) -> Result<&[(Strip, Buffer)]> {
        if self.strips.is_empty() {
            self.strips = strips_of::<PixelSums>(&self.device, "sums", self.width, self.height)?;
            self.clear()?;
        }
        Ok(&self.strips)
    }

    /// Notes that a pass has added this many samples to every pixel.
    pub fn count(&mut self, samples: u32) {
        self.samples += samples;
    }

    /// Sets all sums to zero.
    ///
    /// # Errors
    /// The device fails.
    pub fn clear(&mut self) -> Result<()> {
        self.samples = 0;
        if self.strips.is_empty() {
            return Ok(());
        }
        let mut recording = Recording::new(&self.device)?;
        for (_, sums) in &self.strips {
            recording.clear(sums);
        }
        recording.finish().map(drop)
    }

    /// Adds a picture, which holds one sample per pixel, row by row from the top.
    ///
    /// # Errors
    /// More memory than the device has, or the device fails.
    pub fn add(&mut self, color: &Buffer) -> Result<Vec<PassTime>> {
        self.strips()?;
        let pass = match self.pass.take() {
            Some(pass) => pass,
            None => (self.bindings).pass("accumulate", &self.bindings.specialisation)?,
        };
        let pass = self.pass.insert(pass);
        let mut recording = Recording::new(&self.device)?;
        for (strip, sums) in &self.strips {
            let range = PixelRange {
                first_pixel: strip.first_row * self.width,
                pixels: strip.rows * self.width,
            };
            let groups = in_rows(range.pixels.div_ceil(TILE * TILE));
            recording.pass(pass, &Accumulate { color, sums }, &range, groups)?;
        }
        let times = recording.finish()?;
        self.count(1);
        Ok(times)
    }

    /// The sums of each pixel, row by row from the top; empty before the first sample.
    ///
    /// # Errors
    /// The device fails.
    pub fn read(&self) -> Result<Vec<PixelSums>> {
        let mut all = Vec::with_capacity(self.width as usize * self.height as usize);
        for (strip, sums) in &self.strips {
            all.extend(sums.read::<PixelSums>(strip.pixels(self.width))?);
        }
        Ok(all)
    }

    /// Replaces the sums by the sums of an earlier run over `samples` samples, with one entry per pixel.
    ///
    /// # Errors
    /// There are fewer entries than pixels, or the device fails.
    pub fn write(&mut self, sums: &[PixelSums], samples: u32) -> Result<()> {
        let width = self.width;
        let mut rest = sums;
        for (strip, buffer) in self.strips()? {
            let (pixels, after) = rest
                .split_at_checked(strip.pixels(width))
                .ok_or_else(|| Error::failed("the earlier run has too few pixels"))?;
            buffer.write(pixels)?;
            rest = after;
        }
        self.samples = samples;
        Ok(())
    }

    /// The sums on the device.
    pub fn radiance(&self) -> Vec<Radiance<'_>> {
        let parts = self.strips.iter().map(|(strip, sums)| Radiance {
            buffer: sums,
            stride: (size_of::<PixelSums>() / size_of::<f32>()) as u32,
            first_pixel: strip.first_row * self.width,
            pixels: strip.rows * self.width,
            samples: self.samples,
        });
        parts.collect()
    }
}
