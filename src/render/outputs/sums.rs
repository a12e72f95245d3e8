//! Sums over a pixel's samples: mean and standard error.

use crate::layouts::PixelSums;
use glam::DVec3;

impl PixelSums {
    /// From the sum and the sum of squares of each channel.
    pub fn of([sum, square]: &[DVec3; 2]) -> Self {
        let pair = |value: &DVec3| {
            let high = value.as_vec3();
            (high, (value - high.as_dvec3()).as_vec3())
        };
        let ((sum, sum_low), (square, square_low)) = (pair(sum), pair(square));
        Self {
            sum,
            sum_low,
            square,
            square_low,
        }
    }

    /// Mean of `samples` ≥ 1 samples, for each channel.
    pub fn mean(&self, samples: u32) -> DVec3 {
        (self.sum.as_dvec3() + self.sum_low.as_dvec3()) / f64::from(samples)
    }

    /// Squared standard error of the mean, for each channel; `samples` ≥ 2.
    pub fn error_squared(&self, samples: u32) -> DVec3 {
        let n = f64::from(samples);
        let mean = self.mean(samples);
        let square = (self.square.as_dvec3() + self.square_low.as_dvec3()) / n;
        (square - mean * mean).max(DVec3::ZERO) / (n - 1.0)
    }
}
