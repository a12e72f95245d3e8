//! The world reservoirs of a frame, and the bindings or buffer addresses by which shaders find them.

use crate::gpu::{Buffer, Resource};
use crate::render::history::History;
use crate::shader_interface::WorldAddresses;

/// The world reservoirs of one frame: first those of the second vertex of every pixel's path, by slot, then those of the
/// third, and so on. Points and samples are in separate buffers, because a device may bind too few bytes for both together.
pub struct WorldVertices {
    /// The position and normal of each vertex, as an array of `GpuGridPoint`.
    pub points: Buffer,
    /// The light sample, contribution weight and confidence of each vertex, as an array of `GpuWorldSample` in the order of
    /// `points`.
    pub samples: Buffer,
    /// The device addresses of both buffers, for shaders that use addresses; zeros for shaders that bind the buffers.
    pub addresses: WorldAddresses,
}

impl History<WorldVertices> {
    /// The reservoirs of the previous frame, which the vertices of this frame merge. In the first frame they are empty,
    /// since a restart clears both copies.
    pub fn last(&self) -> &WorldVertices {
        self.spare()
    }

    /// The buffers of both frames by the names of their bindings, for shaders that do not use addresses. Shaders only read
    /// the buffers of the previous frame.
    pub fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let (previous, current) = (self.last(), self.current());
        vec![
            ("previous_world_points", Resource::Read(&previous.points)),
            ("previous_world_samples", Resource::Read(&previous.samples)),
            ("world_points", Resource::Write(&current.points)),
            ("world_samples", Resource::Write(&current.samples)),
        ]
    }
}
