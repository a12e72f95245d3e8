//! A camera with its motion, without the rest of its scene.

use crate::Result;
use crate::scene::{Camera, Scene};

/// One camera of a scene, with its motion. A renderer keeps it instead of the whole scene, to get the camera of each frame.
pub struct MovingCamera {
    index: usize,
    /// A copy of the scene that contains only its cameras and its motion.
    cameras: Scene,
}

impl MovingCamera {
    /// The camera with the index `index` in [`Scene::cameras`]. The index is not checked until [`MovingCamera::at`].
    pub fn of(scene: &Scene, index: usize) -> Self {
        let cameras = Scene {
            cameras: scene.cameras.clone(),
            motion: scene.motion.clone(),
            ..Scene::default()
        };
        Self { index, cameras }
    }

    /// The camera at `time`, in seconds.
    ///
    /// # Errors
    /// The scene has no camera with this index, or its transform at that time is not finite or gives it no direction.
    pub fn at(&self, time: f64) -> Result<Camera> {
        self.cameras.camera_at(self.index, time)
    }
}
