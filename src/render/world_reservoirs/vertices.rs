//! The world reservoirs of a frame, and the bindings or addresses by which shaders find them.

use crate::gpu::{Buffer, Resource};
use crate::render::history::History;
use crate::shader_interface::WorldAddresses;

/// The reservoirs of a frame, in the order of the paths' vertices. Points and samples are in separate buffers, because a device
/// may bind too few bytes for both together.
pub struct WorldVertices {
    /// The points of the vertices.
    pub points: Buffer,
    /// The samples in the reservoirs.
    pub samples: Buffer,
    /// The addresses of both buffers, for shaders that use addresses; zeros for other shaders, which bind the buffers.
    pub addresses: WorldAddresses,
}

impl History<WorldVertices> {
    /// The reservoirs of the previous frame. In the first frame they are empty, since a restart clears both copies.
    pub fn last(&self) -> &WorldVertices {
        self.spare()
    }

    /// The bindings for shaders that do not use addresses.
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
