//! The inputs of a race: the scene, the view and the motion that are rendered, and the time that the race may
//! take.

use super::candidates::Candidate;
use super::chain::Course;
use crate::Result;
use crate::device_scene::GpuScene;
use crate::gpu::Device;
use crate::render::{Renderer, View};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The inputs of a race: the device, the scene on it, the view, and the motion of the camera and of the
/// scene.
pub struct Track<'a> {
    /// The device on which all candidates render and are timed.
    pub device: &'a Arc<Device>,
    /// The scene as buffers and images on the device, which all candidates render.
    pub scene: &'a Arc<GpuScene>,
    /// Camera, seed, number of bounces and size of the picture that the user wants. The race itself may
    /// render smaller pictures.
    pub view: &'a View,
    /// The motion of the camera and of the scene in the frames that a candidate renders with one seed, and
    /// the purpose of the advice.
    pub course: &'a Course,
    /// True if all candidates come into the final, so that all are measured well; false if the race leaves
    /// out the worse ones.
    pub keeps_all: bool,
}

impl Track<'_> {
    /// Makes a renderer with the settings of `candidate` for the view `view`, whose pictures may be smaller
    /// than the user wants.
    pub(super) fn renderer(&self, view: &View, candidate: &Candidate) -> Result<Renderer> {
        Renderer::new(
            self.device,
            self.scene.clone(),
            view,
            &candidate.settings()?,
        )
    }
}

/// The time that a race may take, and a clock of the time that has passed. The compilation of shaders does
/// not count.
pub struct Time {
    started: Instant,
    /// Time on the host that the race may take, in seconds, without the compilation of shaders.
    pub(super) seconds: f64,
    /// Time on the host that the compilation of shaders has taken so far. It is subtracted from the time that
    /// has passed.
    pub(super) compilation: Duration,
}

impl Time {
    /// Starts the clock of a race that may take `seconds` seconds, without the compilation of shaders.
    pub fn of(seconds: f64) -> Self {
        Self {
            started: Instant::now(),
            seconds,
            compilation: Duration::ZERO,
        }
    }

    /// Time since the start of the race, in seconds, without the compilation of shaders.
    pub(super) fn passed(&self) -> f64 {
        (self.started.elapsed().saturating_sub(self.compilation)).as_secs_f64()
    }

    /// Fraction of the race's time that has passed, in [0, 1], for the display of progress.
    pub(super) fn fraction(&self) -> f64 {
        (self.passed() / self.seconds).min(1.0)
    }

    /// True if work that takes `more` seconds from now would end after the fraction `end` (in [0, 1]) of the
    /// race's time. The race then does not begin this work.
    pub(super) fn is_past(&self, end: f64, more: f64) -> bool {
        self.passed() + more > end * self.seconds
    }
}
