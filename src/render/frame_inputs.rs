//! The buffers and numbers of one frame that all passes of resampling use.

use super::scene_bindings::SceneBindings;
use crate::gpu::Buffer;

/// The buffers and numbers of one frame that all passes of resampling use.
pub struct FrameInputs<'a> {
    /// The scene, the light BVH, and the table of specular albedos, which every pass may bind.
    pub scene: &'a SceneBindings,
    /// The sample data of this frame: the primary surface of each pixel.
    pub sample_data: &'a Buffer,
    /// The sample data of the previous frame; `None` in the first frame, and without reuse over time.
    pub previous_sample_data: Option<&'a Buffer>,
    /// The picture: the RGB radiance of each pixel, to which passes add light.
    pub color: &'a Buffer,
    /// The buffer of the counters of all passes.
    pub counters: &'a Buffer,
    /// The index of the frame, from which its random numbers follow.
    pub frame: u32,
    /// True in the first frame after the renderer was made or restarted. Then nothing of earlier frames may be used.
    pub is_first: bool,
    /// The number of workgroups along each axis of a pass that has one invocation per pixel.
    pub groups: [u32; 3],
}
