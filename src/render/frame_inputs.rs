//! The buffers and numbers that all passes of a frame use.

use super::scene_bindings::SceneBindings;
use crate::gpu::Buffer;

/// The buffers and numbers that all passes of a frame use.
pub struct FrameInputs<'a> {
    /// The scene and its tables.
    pub scene: &'a SceneBindings,
    /// Primary surfaces.
    pub sample_data: &'a Buffer,
    /// The sample data of the previous frame, if there was one.
    pub previous_sample_data: Option<&'a Buffer>,
    /// The picture.
    pub color: &'a Buffer,
    /// The counters of all passes.
    pub counters: &'a Buffer,
    /// Index of the frame.
    pub frame: u32,
    /// True for the first frame and for the first one after a restart.
    pub is_first: bool,
    /// The number of workgroups of a pass over all pixels.
    pub groups: [u32; 3],
}
