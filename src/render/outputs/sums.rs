//! Sums over the samples of a picture: means and standard errors.

use crate::layouts::PixelSums;
use glam::DVec3;

/// The sums of all pixels of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    /// Row by row from the top, in the unit of the device, where squares neither overflow nor vanish.
    pub pixels: Vec<PixelSums>,
    /// The unit: radiance of 1 on the device.
    pub unit: f64,
}

impl Sums {
    /// Means of `samples` ≥ 1 samples: radiance, by pixel and channel.
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
    fn mean(&self, samples: u32) -> DVec3 {
        (self.sum.as_dvec3() + self.sum_low.as_dvec3()) / f64::from(samples)
    }

    /// Squared standard error of the mean, for each channel; `samples` ≥ 2.
    fn error_squared(&self, samples: u32) -> DVec3 {
        let n = f64::from(samples);
        let mean = self.mean(samples);
        let square = (self.square.as_dvec3() + self.square_low.as_dvec3()) / n;
        (square - mean * mean).max(DVec3::ZERO) / (n - 1.0)
    }
}
