//! The inputs of a race: what is rendered, and how long it may take.

use super::candidates::Candidate;
use super::chain::Course;
use crate::Result;
use crate::device_scene::GpuScene;
use crate::gpu::Device;
use crate::render::{Renderer, View};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The inputs of a race: the scene on the device, the view, and the motion of the camera.
pub struct Track<'a> {
    /// The device.
    pub device: &'a Arc<Device>,
    /// The scene on the device.
    pub scene: &'a Arc<GpuScene>,
    /// The view at the size that the user wants.
    pub view: &'a View,
    /// The motion of the camera and of the scene.
    pub course: &'a Course,
    /// True if all candidates come into the final, so that all are measured well; false if the worse ones are left out.
    pub keeps_all: bool,
}

impl Track<'_> {
    /// The renderer of a candidate for the view `view`.
    pub(super) fn renderer(&self, view: &View, candidate: &Candidate) -> Result<Renderer> {
        Renderer::new(
            self.device,
            self.scene.clone(),
            view,
            &candidate.settings()?,
        )
    }
}

/// The time that a race may take. Compilation of shaders does not count.
pub struct Time {
    started: Instant,
    /// The time in seconds.
    pub(super) seconds: f64,
    /// The time that compilation took, which does not count.
    pub(super) compilation: Duration,
}

impl Time {
    /// Begins to count now.
    pub fn of(seconds: f64) -> Self {
        Self {
            started: Instant::now(),
            seconds,
            compilation: Duration::ZERO,
        }
    }

    /// The seconds that have passed, without compilation.
    pub(super) fn passed(&self) -> f64 {
        (self.started.elapsed().saturating_sub(self.compilation)).as_secs_f64()
    }

    /// The fraction of the time that has passed, at most 1.
    pub(super) fn fraction(&self) -> f64 {
        (self.passed() / self.seconds).min(1.0)
    }

    /// True if the fraction `end` of the time will have passed after work of `more` seconds.
    pub(super) fn is_past(&self, end: f64, more: f64) -> bool {
        self.passed() + more > end * self.seconds
    }
}
