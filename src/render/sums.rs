//! What a pixel's sums say: mean and standard error.

use crate::layouts::PixelSums;
use glam::DVec3;

impl PixelSums {
    /// Mean of `samples` ≥ 1 samples, for each channel.
    pub fn mean(&self, samples: u32) -> DVec3 {
        (self.sum.as_dvec3() + self.sum_low.as_dvec3()) / f64::from(samples)
    }

    /// Squared standard error of the mean, for each channel. One sample has no spread to tell it
    /// by, so `samples` ≥ 2.
    pub fn error_squared(&self, samples: u32) -> DVec3 {
        let n = f64::from(samples);
        let mean = self.mean(samples);
        let square = (self.square.as_dvec3() + self.square_low.as_dvec3()) / n;
        (square - mean * mean).max(DVec3::ZERO) / (n - 1.0)
    }
}
