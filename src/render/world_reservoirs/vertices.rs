//! World reservoirs of a frame, and how shaders find them; passes bind them.

use crate::gpu::{Buffer, Resource};
use crate::render::history::History;
use crate::shader_interface::WorldAddresses;

/// The reservoirs of a frame, vertex by vertex of the paths of all pixels. Points and samples are apart because a device may
/// bind too little for both together.
pub struct WorldVertices {
    /// Where the vertices are.
    pub points: Buffer,
    /// The samples in their reservoirs.
    pub samples: Buffer,
    /// The addresses of both buffers, for shaders that take addresses; zeros for others, which bind the buffers.
    pub addresses: WorldAddresses,
}

impl History<WorldVertices> {
    /// The reservoirs of the previous frame. In the first frame they are empty, since a restart clears both copies.
    pub fn last(&self) -> &WorldVertices {
        self.spare()
    }

    /// The bindings of shaders that take no addresses.
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
