//! A view of a scene: camera, size, seed, maximum length of paths, jitter.

use crate::scene::Camera;

/// A view of a scene: camera, size of the picture, and the sampling of paths.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera in the scene's world.
    pub camera: Camera,
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The seed of the run.
    pub seed: u32,
    /// The maximum number of scattering events of a path.
    pub bounces: u32,
    /// True if primary rays cover the whole pixel instead of passing through its centre.
    pub jitter: bool,
}
