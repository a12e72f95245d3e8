//! A camera with its motion, independent of its scene.

use crate::Result;
use crate::scene::{Camera, Scene};

/// One of a scene's cameras and its motion.
pub struct MovingCamera {
    index: usize,
    /// A scene with cameras and motion only.
    cameras: Scene,
}

impl MovingCamera {
    /// The camera of this index in `scene`.
    pub fn of(scene: &Scene, index: usize) -> Self {
        let cameras = Scene {
            cameras: scene.cameras.clone(),
            motion: scene.motion.clone(),
            ..Scene::default()
        };
        Self { index, cameras }
    }

    /// The camera at a time in seconds.
    ///
    /// # Errors
    /// No such camera, or it has no direction at that time.
    pub fn at(&self, time: f64) -> Result<Camera> {
        self.cameras.camera_at(self.index, time)
    }
}
