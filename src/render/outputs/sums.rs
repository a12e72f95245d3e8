//! Sums over the samples of a picture: means and standard errors.

use crate::shader_interface::PixelSums;
use glam::DVec3;

/// The sums of all pixels of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    /// The sums, row by row from the top, in the unit of the device, so that squares neither overflow nor vanish.
    pub pixels: Vec<PixelSums>,
    /// The radiance that is 1 on the device.
    pub unit: f64,
}

impl Sums {
    /// The means of `samples` ≥ 1 samples: the radiance of each pixel and channel.
    pub fn mean(&self, samples: u32) -> Vec<DVec3> {
        let mean = |pixel: &PixelSums| pixel.mean(samples) * self.unit;
        self.pixels.iter().map(mean).collect()
    }

    /// Standard errors of these means; `samples` ≥ 2.
    pub fn standard_error(&self, samples: u32) -> Vec<DVec3> {
        let error = |pixel: &PixelSums| pixel.error_squared(samples).map(f64::sqrt) * self.unit;
        self.pixels.iter().map(error).collect()
    }
}
