//! The buffers and numbers of one frame that all passes of reservoir resampling have in common.

use super::scene_bindings::SceneBindings;
use crate::gpu::Buffer;

/// The buffers and numbers of one frame that all passes of reservoir resampling have in common. The functions that record
/// passes bind the buffers and read the numbers.
pub struct FrameInputs<'a> {
    /// The bindings of the scene, the light BVH, and the table of specular albedos. Every pass may use them.
    pub scene: &'a SceneBindings,
    /// The sample data of this frame: the primary surface of each pixel, which is the surface that the camera sees there.
    pub sample_data: &'a Buffer,
    /// The sample data (primary surfaces) of the previous frame, with which temporal reuse compares those of this frame.
    /// `None` in the first frame, and if neither direct nor indirect light is reused over time.
    pub previous_sample_data: Option<&'a Buffer>,
    /// The picture of this frame: the RGB radiance of each pixel, in the device's unit of radiance. Passes add light to it.
    pub color: &'a Buffer,
    /// The buffer with the counters of all passes, in which passes count faults, rays and more.
    pub counters: &'a Buffer,
    /// The index of the frame. The random numbers of the frame are computed from it and from the seed.
    pub frame: u32,
    /// True in the first frame after the renderer was made or restarted. Then there is no data of earlier frames that passes
    /// could reuse.
    pub is_first: bool,
    /// The number of workgroups along the axes x, y and z, for passes that have one invocation per pixel.
    pub groups: [u32; 3],
}
