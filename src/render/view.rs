//! A view of a scene: camera, size, seed, length of paths, jitter.

use crate::scene::Camera;

/// A view of a scene: camera, size of the picture, and the sampling of paths.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera in the scene's world.
    pub camera: Camera,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The run's seed.
    pub seed: u32,
    /// Maximum scattering events of a path.
    pub bounces: u32,
    /// Rays over the whole pixel instead of through its centre.
    pub jitter: bool,
}
