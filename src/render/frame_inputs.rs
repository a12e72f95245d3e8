//! The buffers and numbers of one frame that all passes of reservoir resampling have in common.

use super::scene_bindings::SceneBindings;
use crate::gpu::Buffer;

/// The buffers and numbers of one frame that all passes of reservoir resampling have in common. The functions that record
/// passes bind the buffers. From the numbers, they decide which passes a frame needs, and how many workgroups a pass has.
pub struct FrameInputs<'a> {
    /// The bindings of the scene, the light BVH, and the table of specular albedos. Every pass may use them.
    pub scene: &'a SceneBindings,
    /// The sample data of this frame: the primary surface of each pixel, which is the surface that the camera sees there.
    /// Passes compute direct and indirect light at these surfaces.
    pub sample_data: &'a Buffer,
    /// The primary surfaces (sample data) of the previous frame. Temporal reuse compares them with the primary surfaces of
    /// this frame, to find reservoirs of similar surfaces. `None` in the first frame, and if neither direct nor indirect
    /// light is reused over time.
    pub previous_sample_data: Option<&'a Buffer>,
    /// The picture of this frame: the RGB radiance of each pixel, to which passes add light, in the device's unit of
    /// radiance (the scene's unit times a power of two).
    pub color: &'a Buffer,
    /// The buffer with the counters of all passes, in which passes count faults, rays and more.
    pub counters: &'a Buffer,
    /// The index of the frame. Shaders compute the random numbers of the frame from it and from the seed. The passes of the
    /// hash grid (a light sampler) can run only in frames whose index is less than the setting `hash_grid.until_frame`; if
    /// this setting is 0, there is no such limit.
    pub frame: u32,
    /// True in the first frame after the renderer was made or restarted. There is then no data of earlier frames that passes
    /// could reuse. Passes whose results are kept for all later frames, such as those of a hash grid that is filled once,
    /// run in this frame.
    pub is_first: bool,
    /// The number of workgroups along the axes x, y and z, for passes that have one invocation per pixel; z is 1.
    pub groups: [u32; 3],
}
