//! The world reservoirs of a frame: the reservoirs of path vertices, which paths of the next frame reuse.

use crate::gpu::Buffer;
use crate::render::history::History;
use crate::shader_interface::WorldAddresses;

/// The world reservoirs of one frame, which vertices of the next frame merge. There is one per path vertex: first those of
/// the second vertices of all paths, in the order in which pixels are stored (`reservoirs.order`), then those of the third
/// vertices, and so on. Points and samples are in separate buffers, because one buffer with both could be larger than the
/// part of a buffer that a device can bind.
pub struct WorldVertices {
    /// The position and the normal of each vertex, as an array of `GpuGridPoint`, in the device's world space and unit of
    /// length. A merge evaluates light samples at these points to compute MIS weights.
    pub points: Buffer,
    /// The light sample, contribution weight and confidence of each vertex, as an array of `GpuWorldSample` in the order of
    /// `points`. Vertices of the next frame merge them with their own light samples.
    pub samples: Buffer,
    /// The device addresses of both buffers, for shaders that reach them by address, because the vertices of a large picture
    /// may be too many for a binding. Zeros if the shaders bind the buffers.
    pub addresses: WorldAddresses,
}

impl History<WorldVertices> {
    /// The reservoirs of the previous frame, which vertices of this frame merge. In the first frame, and in the first one
    /// after a restart, they are empty: a restart clears both copies.
    pub fn last(&self) -> &WorldVertices {
        self.spare()
    }
}
