//! The sums of radiance over the samples of a picture, on the CPU, and the means and standard errors that follow from them.

use crate::shader_interface::PixelSums;
use glam::DVec3;

/// The sums of radiance and of squared radiance over the samples of each pixel, as read from the device. The mean radiance
/// of each pixel and its standard error are computed from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    /// The sums of each pixel, row by row from the top. They are in the device's unit of radiance, in which squares neither
    /// overflow nor vanish in f32.
    pub pixels: Vec<PixelSums>,
    /// The number of samples of each pixel whose primary ray met a surface, in the same order as `pixels`. `None` unless
    /// [`Tracking::coverage`](crate::render::Tracking::coverage) is true.
    pub coverage: Option<Vec<u32>>,
    /// The device's unit of radiance: a radiance of 1 on the device is this radiance in the scene's unit. Means and standard
    /// errors are multiplied by it, so that they are in the scene's unit.
    pub unit: f64,
}

impl Sums {
    /// The mean radiance of each pixel (RGB), row by row from the top, in the scene's unit. `samples` is the number of
    /// samples per pixel that the sums contain, at least 1.
    pub fn mean(&self, samples: u32) -> Vec<DVec3> {
        let mean = |pixel: &PixelSums| pixel.mean(samples) * self.unit;
        self.pixels.iter().map(mean).collect()
    }

    /// The alpha of each pixel, in [0, 1]: the fraction of its samples whose primary ray met a surface. `samples` is the
    /// number of samples per pixel that the sums contain, at least 1. `None` if these samples were not counted.
    pub fn alpha(&self, samples: u32) -> Option<Vec<f32>> {
        let coverage = self.coverage.as_ref()?;
        let fraction = |covered: &u32| (f64::from(*covered) / f64::from(samples)) as f32;
        Some(coverage.iter().map(fraction).collect())
    }

    /// The standard error of each mean that [`Self::mean`] returns, in the same order and unit. `samples` is the number of
    /// samples per pixel that the sums contain, at least 2. The samples must be independent of each other.
    pub fn standard_error(&self, samples: u32) -> Vec<DVec3> {
        let error = |pixel: &PixelSums| pixel.error_squared(samples).map(f64::sqrt) * self.unit;
        self.pixels.iter().map(error).collect()
    }
}
