//! The sums of a picture's samples on the CPU, and the means and standard errors that follow from them.

use crate::shader_interface::PixelSums;
use glam::DVec3;

/// The sums of the radiance and of the squared radiance of all pixels, on the CPU.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    /// The sums of each pixel, row by row from the top, in the device's unit of radiance, so that squares neither overflow
    /// nor vanish.
    pub pixels: Vec<PixelSums>,
    /// The radiance in the scene that is 1 on the device. Means and standard errors are multiplied by it.
    pub unit: f64,
}

impl Sums {
    /// The mean radiance of each pixel (RGB), row by row from the top, in the scene's unit. `samples` is the number of
    /// samples in the sums, at least 1.
    pub fn mean(&self, samples: u32) -> Vec<DVec3> {
        let mean = |pixel: &PixelSums| pixel.mean(samples) * self.unit;
        self.pixels.iter().map(mean).collect()
    }

    /// The standard error of each mean that [`Self::mean`] returns, in the same order and unit. `samples` is the number of
    /// samples in the sums, at least 2; they must be independent of each other.
    pub fn standard_error(&self, samples: u32) -> Vec<DVec3> {
        let error = |pixel: &PixelSums| pixel.error_squared(samples).map(f64::sqrt) * self.unit;
        self.pixels.iter().map(error).collect()
    }
}
