//! Radiance on the device: the location of the picture, independent of the integrator.

use crate::Result;
use crate::gpu::Buffer;
use glam::Vec3;

/// The radiance of consecutive pixels, row by row from the top.
pub struct Radiance<'a> {
    /// A buffer of words; the first three of each pixel are its radiance, in the unit of the device, summed over the samples.
    pub buffer: &'a Buffer,
    /// The distance from one pixel to the next, in words.
    pub stride: u32,
    /// Index of the first pixel in the picture.
    pub first_pixel: u32,
    /// Number of pixels.
    pub pixels: u32,
    /// Number of samples in the sum.
    pub samples: u32,
}

impl Radiance<'_> {
    /// The sums of all pixels.
    ///
    /// # Errors
    /// The device fails.
    pub fn read(&self) -> Result<Vec<Vec3>> {
        let words: Vec<f32> = self.buffer.read((self.pixels * self.stride) as usize)?;
        let pixels = words.chunks_exact(self.stride as usize);
        Ok(pixels.map(Vec3::from_slice).collect())
    }
}
