//! A camera that moves, kept when its scene is gone.

use crate::Result;
use crate::scene::{Camera, Scene};

/// One of a scene's cameras and how it moves.
pub struct MovingCamera {
    index: usize,
    /// Nothing but cameras and motion.
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

    /// Where it is at a time in seconds.
    ///
    /// # Errors
    /// There is no such camera, or at that time it has no direction.
    pub fn at(&self, time: f64) -> Result<Camera> {
        self.cameras.camera_at(self.index, time)
    }
}
