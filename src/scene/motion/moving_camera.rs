//! A camera with its motion, without the rest of its scene, so that the camera of each frame can be computed after the scene
//! has been dropped.

use crate::Result;
use crate::scene::{Camera, Scene};

/// One camera of a scene, with its motion. Commands store it when they no longer need the scene itself, and compute from it
/// the camera of each frame.
#[derive(Clone)]
pub struct MovingCamera {
    index: usize,
    /// A copy of the scene that contains only its cameras and its motion, from which the camera at a time is computed.
    cameras: Scene,
}

impl MovingCamera {
    /// The camera with the index `index` in [`Scene::cameras`], with a copy of the motion of `scene`. If the
    /// index is out of range, only [`MovingCamera::at`] returns an error.
    pub fn of(scene: &Scene, index: usize) -> Self {
        let cameras = Scene {
            cameras: scene.cameras.clone(),
            motion: scene.motion.clone(),
            ..Scene::default()
        };
        Self { index, cameras }
    }

    /// The camera in its state at `time` (in seconds).
    ///
    /// # Errors
    /// The scene has no camera with this index, or the camera's transform at that time is not finite, has a scale of 0, or
    /// has its axes in one plane.
    pub fn at(&self, time: f64) -> Result<Camera> {
        self.cameras.camera_at(self.index, time)
    }
}
