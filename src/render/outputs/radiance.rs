//! The location of a picture's radiance in buffers on the device. All integrators describe it in the same form, so that
//! any picture can be read or tone-mapped in the same way.

use crate::Result;
use crate::gpu::Buffer;
use glam::Vec3;

/// The location of the radiance of consecutive pixels of a picture in a buffer on the device, so that it can be read or
/// tone-mapped. The pixels are in rows from the top. A large picture has several such parts, each in a separate buffer.
pub struct Radiance<'a> {
    /// A buffer of 32-bit floats. The first three of each pixel are its red, green and blue radiance, in the device's unit
    /// of radiance, summed over the samples.
    pub buffer: &'a Buffer,
    /// The distance from the first word of one pixel to the first word of the next, in words of 32 bits.
    pub stride: u32,
    /// The index in the picture of the first pixel in the buffer; indices count row by row from the top.
    pub first_pixel: u32,
    /// The number of pixels whose radiance the buffer contains.
    pub pixels: u32,
    /// The number of samples in each pixel's sum. The mean radiance of a pixel is its sum divided by this number.
    pub samples: u32,
}

impl Radiance<'_> {
    /// Reads, for each pixel, the sum of the RGB radiance of its samples, in the device's unit of radiance. The sums are
    /// not divided by the number of samples. The pixels are in the order in which the buffer stores them.
    ///
    /// # Errors
    /// The device fails.
    pub fn read(&self) -> Result<Vec<Vec3>> {
        let words: Vec<f32> = self.buffer.read((self.pixels * self.stride) as usize)?;
        let pixels = words.chunks_exact(self.stride as usize);
        Ok(pixels.map(Vec3::from_slice).collect())
    }
}
