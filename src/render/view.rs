//! A view of a scene: camera, size of the picture, seed, maximum length of paths, jitter.

use crate::scene::Camera;

/// A view of a scene: the camera, the size of the picture, and the limits of sampling. Settings decide the rest.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera, in the coordinates of the scene's world.
    pub camera: Camera,
    /// The width of the picture in pixels.
    pub width: u32,
    /// The height of the picture in pixels.
    pub height: u32,
    /// The seed from which all random numbers of the run follow. Pictures with different seeds have independent noise.
    pub seed: u32,
    /// The maximum number of scattering events of a path: 0 shows only emitters, 1 adds direct light, 2 or more add indirect
    /// light.
    pub bounces: u32,
    /// True if primary rays cover the whole pixel, which smooths edges over several samples; false if they pass through its
    /// centre.
    pub jitter: bool,
}
