//! The sums of radiance over the samples of a picture, stored on the device. The mean radiance of each pixel and its
//! standard error are computed from them.

use super::radiance::Radiance;
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, in_rows};
use crate::render::scene_bindings::SceneBindings;
use crate::render::strips::strips_of;
use crate::shader_interface::{PixelRange, PixelSums, Strip, TILE};
use crate::{Error, Result};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass `accumulate`, which adds the radiance of a frame, as one sample, to the sums of each pixel.
    pub struct Accumulate {
        read color,
        write sums,
    }
}

/// The sums of radiance and of squared radiance of each pixel, over all samples since the last [`Self::clear`]. From them,
/// the CPU computes the mean radiance of each pixel and its standard error.
pub struct Accumulator {
    device: Arc<Device>,
    width: u32,
    height: u32,
    bindings: Arc<SceneBindings>,
    /// The pass that adds a frame to the sums; `None` until the first frame is added. Path tracing does not need it, because
    /// its own pass adds samples to the sums.
    pass: Option<ComputePass>,
    /// The strips of the picture (groups of whole rows) from top to bottom, each with the buffer of its pixels' sums. Empty
    /// before the first sample, so that a renderer of single frames uses no memory for sums.
    strips: Vec<(Strip, Buffer)>,
    samples: u32,
}

impl Accumulator {
    /// Makes the sums of a picture of `width` × `height` pixels, without samples. Their buffers are made only when they are
    /// needed, by [`Self::strips`]. [`Self::add`] makes its pass from `bindings`, the resources of the scene.
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

    /// The strips of the picture (groups of whole rows) from top to bottom, each with the buffer of its pixels' sums. If the
    /// buffers do not exist yet, this method makes them. A pass of the caller can add samples to the sums; the caller must
    /// then call [`Self::count`].
    ///
    /// # Errors
    /// The sums need more memory than the device has, or the picture is wider than the device can bind or dispatch.
    pub fn strips(&mut self) -> Result<&[(Strip, Buffer)]> {
        if self.strips.is_empty() {
            self.strips = strips_of::<PixelSums>(&self.device, "sums", self.width, self.height)?;
            self.clear()?;
        }
        Ok(&self.strips)
    }

    /// Increases the stored number of samples by `samples`. A caller of [`Self::strips`] calls it after its pass has added
    /// this many samples to the sums of every pixel.
    pub fn count(&mut self, samples: u32) {
        self.samples += samples;
    }

    /// Sets the sums of all pixels and the number of samples to zero, so that the next samples begin a new picture. The
    /// buffers stay allocated.
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

    /// Adds one sample to the sums of every pixel: the radiance of a frame, which `color` stores as RGB per pixel, row by
    /// row from the top. The pass runs once for each strip of the picture (group of whole rows), and the result is the time
    /// of each run.
    ///
    /// # Errors
    /// One of the errors of [`Self::strips`] occurs, the driver rejects the shader, or the device fails.
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

    /// Reads the sums of all pixels, row by row from the top, in the device's unit of radiance, so that the CPU can compute
    /// means and standard errors. The result is empty if the buffers of sums are not made yet.
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

    /// Continues an earlier run: replaces the sums of all pixels by `sums`, one entry per pixel, row by row from the top.
    /// `samples` is the number of samples per pixel that these sums contain.
    ///
    /// # Errors
    /// `sums` has fewer entries than the picture has pixels, one of the errors of [`Self::strips`] occurs, or the device
    /// fails.
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

    /// The location on the device of each pixel's sum of radiance, so that the sums can be tone-mapped or read: one part of
    /// the picture per strip (group of whole rows), from top to bottom. Empty if the buffers of sums are not made yet.
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
