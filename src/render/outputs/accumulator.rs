//! The sums of radiance over the samples of a picture, stored on the device. The mean radiance of each pixel and its
//! standard error are computed from them.

use super::radiance::Radiance;
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage, in_rows};
use crate::render::scene_bindings::SceneBindings;
use crate::render::strips::strips_of;
use crate::shader_interface::{PixelRange, PixelSums, Strip, TILE};
use crate::{Error, Result};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass `accumulate`, which adds the radiance of a frame, as one sample, to the sums of each pixel.
    pub struct Accumulate {
        [optional read covered]
        [optional write coverage]
        read color,
        write sums,
    }
}

/// A strip of the picture (a group of whole rows), with the buffers of its pixels' sums.
pub struct SumStrip {
    /// The rows of the picture that the strip contains.
    pub strip: Strip,
    /// The buffer of the sums of radiance and of squared radiance: one [`PixelSums`] per pixel of the strip.
    pub sums: Buffer,
    /// The buffer of the numbers of samples whose primary ray met a surface: one 32-bit word per pixel of the strip. `None`
    /// for a picture without an alpha channel.
    pub coverage: Option<Buffer>,
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
    /// The strips of the picture from top to bottom. Empty before the first sample, so that a renderer of single frames uses
    /// no memory for sums.
    strips: Vec<SumStrip>,
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

    /// The strips of the picture from top to bottom, each with the buffers of its pixels' sums. If the buffers do not exist yet, this method makes them. A pass of the caller can add samples to the sums; the caller must
    /// then call [`Self::count`].
    ///
    /// # Errors
    /// The sums need more memory than the device has, or the picture is wider than the device can bind or dispatch.
    pub fn strips(&mut self) -> Result<&[SumStrip]> {
        if self.strips.is_empty() {
            let (width, height) = (self.width, self.height);
            let counts = self.bindings.specialisation.tracks_coverage;
            for (strip, sums) in strips_of::<PixelSums>(&self.device, "sums", width, height)? {
                let bytes = (strip.pixels(width) * size_of::<u32>()) as u64;
                let coverage = counts
                    .then(|| Buffer::new(&self.device, "coverage", bytes, Usage::default()))
                    .transpose()?;
                self.strips.push(SumStrip {
                    strip,
                    sums,
                    coverage,
                });
            }
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
        for part in &self.strips {
            recording.clear(&part.sums);
            part.coverage.iter().for_each(|b| recording.clear(b));
        }
        recording.finish().map(drop)
    }

    /// Adds one sample to the sums of every pixel: the radiance of a frame, which `color` stores as RGB per pixel, row by
    /// row from the top. `covered` stores per pixel 1 if the primary ray met a surface, otherwise 0; it must exist if the
    /// picture has an alpha channel. The pass runs once for each strip of the picture, and the result is the time of each
    /// run.
    ///
    /// # Errors
    /// One of the errors of [`Self::strips`] occurs, the driver rejects the shader, or the device fails.
    pub fn add(&mut self, color: &Buffer, covered: Option<&Buffer>) -> Result<Vec<PassTime>> {
        self.strips()?;
        let pass = match self.pass.take() {
            Some(pass) => pass,
            None => (self.bindings).pass("accumulate", &self.bindings.specialisation)?,
        };
        let pass = self.pass.insert(pass);
        let mut recording = Recording::new(&self.device)?;
        for part in &self.strips {
            let range = PixelRange {
                first_pixel: part.strip.first_row * self.width,
                pixels: part.strip.rows * self.width,
            };
            let groups = in_rows(range.pixels.div_ceil(TILE * TILE));
            let bindings = Accumulate {
                color,
                sums: &part.sums,
                covered,
                coverage: part.coverage.as_ref(),
            };
            recording.pass(pass, &bindings, &range, groups)?;
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
        for part in &self.strips {
            let pixels = part.strip.pixels(self.width);
            all.extend(part.sums.read::<PixelSums>(pixels)?);
        }
        Ok(all)
    }

    /// Reads the number of samples of each pixel whose primary ray met a surface, row by row from the top. `None` for a
    /// picture without an alpha channel.
    ///
    /// # Errors
    /// The device fails.
    pub fn read_coverage(&self) -> Result<Option<Vec<u32>>> {
        if !self.bindings.specialisation.tracks_coverage {
            return Ok(None);
        }
        let mut all = Vec::new();
        for part in &self.strips {
            if let Some(coverage) = &part.coverage {
                all.extend(coverage.read::<u32>(part.strip.pixels(self.width))?);
            }
        }
        Ok(Some(all))
    }

    /// Continues an earlier run: replaces the sums of all pixels by `sums` and, in a picture with an alpha channel, the
    /// numbers of samples whose primary ray met a surface by `coverage`; one entry per pixel, row by row from the top.
    /// `samples` is the number of samples per pixel that these sums contain.
    ///
    /// # Errors
    /// `sums` or `coverage` has fewer entries than the picture has pixels, one of the errors of [`Self::strips`] occurs, or the device
    /// fails.
    pub fn write(&mut self, sums: &[PixelSums], coverage: &[u32], samples: u32) -> Result<()> {
        let width = self.width;
        let too_few = || Error::failed("the earlier run has too few pixels");
        for part in self.strips()? {
            let first = (part.strip.first_row * width) as usize;
            let pixels = first..first + part.strip.pixels(width);
            part.sums
                .write(sums.get(pixels.clone()).ok_or_else(too_few)?)?;
            if let Some(counts) = &part.coverage {
                counts.write(coverage.get(pixels).ok_or_else(too_few)?)?;
            }
        }
        self.samples = samples;
        Ok(())
    }

    /// The location on the device of each pixel's sum of radiance, so that the sums can be tone-mapped or read: one part of
    /// the picture per strip (group of whole rows), from top to bottom. Empty if the buffers of sums are not made yet.
    pub fn radiance(&self) -> Vec<Radiance<'_>> {
        let parts = self
            .strips
            .iter()
            .map(|SumStrip { strip, sums, .. }| Radiance {
                buffer: sums,
                stride: (size_of::<PixelSums>() / size_of::<f32>()) as u32,
                first_pixel: strip.first_row * self.width,
                pixels: strip.rows * self.width,
                samples: self.samples,
            });
        parts.collect()
    }
}
