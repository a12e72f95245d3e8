//! The picture as a display shows it, made on the device: the end of a frame for capture tools.

use super::radiance::Radiance;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage, in_rows};
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::{TILE, ToneMap};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass.
    pub struct ToneMapPicture {
        read radiance,
        write display,
    }
}

/// The pass that makes display values, and its picture.
pub struct Display {
    device: Arc<Device>,
    pass: ComputePass,
    /// One 8-bit sRGB word per pixel, row by row from the top.
    pub pixels: Buffer,
}

impl Display {
    /// Makes the pass for pictures of `pixels` pixels.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(device: &Arc<Device>, bindings: &SceneBindings, pixels: u64) -> Result<Self> {
        Ok(Self {
            pass: bindings.pass("tone_map", &bindings.specialisation)?,
            pixels: Buffer::new(device, "display", 4 * pixels, Usage::default())?,
            device: device.clone(),
        })
    }

    /// Maps the parts of a picture, the mean of their samples times `scale`.
    ///
    /// # Errors
    /// The device fails.
    pub fn map(&self, parts: &[Radiance<'_>], scale: f64, begins_with_blue: bool) -> Result<()> {
        let mut recording = Recording::new(&self.device)?;
        for part in parts {
            let bindings = ToneMapPicture {
                radiance: part.buffer,
                display: &self.pixels,
            };
            let tone = ToneMap {
                stride: part.stride,
                first_pixel: part.first_pixel,
                pixels: part.pixels,
                scale: (scale / f64::from(part.samples)) as f32,
                begins_with_blue: begins_with_blue.into(),
            };
            let groups = in_rows(part.pixels.div_ceil(TILE * TILE));
            recording.pass(&self.pass, &bindings, &tone, groups)?;
        }
        recording.finish().map(drop)
    }
}
