//! A view of a scene: camera, size of the picture, seed, maximum length of paths, and jitter of primary rays.

use crate::scene::Camera;

/// A view of a scene, from which a renderer is made: the camera, the size of the picture, the seed, the maximum length of
/// paths, and the jitter of primary rays. [`Settings`](super::Settings) decide how the picture is computed.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera of the first frame, in the world space of the scene, in scene units.
    pub camera: Camera,
    /// The width of the picture in pixels, at least 1. The ratio of width and height decides how much the camera shows
    /// horizontally.
    pub width: u32,
    /// The height of the picture in pixels, at least 1. What the picture shows vertically is decided by `camera`, for any height.
    pub height: u32,
    /// The seed from which all random numbers of the renderer are computed. Pictures with different seeds have independent
    /// noise.
    pub seed: u32,
    /// The maximum number of scattering events of a path. With 0, the picture shows only emitters; with 1, direct light is
    /// added; with 2 or more, indirect light.
    pub bounces: u32,
    /// True if the primary rays of a pixel pass through different points of the pixel, so that edges become smooth over
    /// several samples. False if all pass through the pixel's centre.
    pub jitter: bool,
}
