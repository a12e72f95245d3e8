//! The picture as a display shows it, tone-mapped on the device. The command `capture` presents this picture, because
//! some capture tools end a frame only where a picture is presented.

use super::radiance::Radiance;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage, in_rows};
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::{TILE, ToneMap};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass `tone_map`, which converts the radiance of each pixel to the values that a display shows.
    pub struct ToneMapPicture {
        read radiance,
        write display,
    }
}

/// The pass that converts radiance to the values that a display shows, and the buffer to which the pass writes the picture.
/// The command `capture` presents this picture, and can write it to a PNG file.
pub struct Display {
    device: Arc<Device>,
    pass: ComputePass,
    /// The picture: one 32-bit word per pixel with 8 bits per sRGB channel, row by row from the top. [`Self::map`] writes
    /// it; an argument decides whether red or blue is in the least significant byte.
    pub pixels: Buffer,
}

impl Display {
    /// Makes the pass `tone_map`, and the buffer to which this pass writes a picture of `pixels` pixels, with 4 bytes per
    /// pixel.
    ///
    /// # Errors
    /// The buffer exceeds a limit or the free memory of the device, or the shader's interface cannot be bound by name.
    pub fn new(device: &Arc<Device>, bindings: &SceneBindings, pixels: u64) -> Result<Self> {
        Ok(Self {
            pass: bindings.pass("tone_map", &bindings.specialisation)?,
            pixels: Buffer::new(device, "display", 4 * pixels, Usage::default())?,
            device: device.clone(),
        })
    }

    /// Computes the picture from `parts`, which together cover all its pixels, and writes it to [`Self::pixels`]. The mean
    /// radiance of each pixel is multiplied by `scale` and then tone-mapped. `scale` is the product of the exposure factor
    /// and the device's unit of radiance. If `begins_with_blue` is true, blue is in the least significant byte of a pixel,
    /// otherwise red.
    ///
    /// # Errors
    /// The driver rejects the shader, or the device fails.
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
