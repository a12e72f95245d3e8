//! The table of world reservoirs (the reservoirs of path vertices): a list of the vertices in each cell of space, made on
//! the device.
//!
//! Each vertex has the key of its cell. `world_insert` puts the keys into buckets, `world_count` counts the vertices of each
//! cell, a prefix sum turns the counts into the beginnings of lists, and `world_scatter` writes the vertices into the lists
//! (`glsl/world_reservoirs/world_table.glsl`). The lists do not depend on the order of threads.

use super::prefix_sum::PrefixSum;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage, in_rows};
use crate::shader_interface::{TILE, WorldConstants};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass `world_insert`, which stores the keys of all cells with a vertex in the buckets of the table, so
    /// that each cell has a slot for its list. Cells that find no slot are dropped.
    pub struct InsertCells {
        uniform restir,
        read world_keys,
        write world_cells,
    }
}

crate::bindings! {
    /// Bindings of the pass `world_count`, which counts the vertices of each cell, from which the length of the cell's list
    /// follows. It also replaces the key of each vertex by the slot of its cell plus 1, or by 0 if the cell has no slot.
    pub struct CountVertices {
        uniform restir,
        write world_keys,
        write world_cells,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass `world_scatter`, which writes the index of each vertex into the list of the vertex's cell. From
    /// these lists, vertices of the next frame pick the reservoirs that they merge.
    pub struct ScatterVertices {
        uniform restir,
        read world_keys,
        read world_cells,
        write world_list,
        write counters,
    }
}

/// The maximum number of slots in a bucket of the table of world reservoirs. Each slot stores one cell of space. Higher:
/// fewer cells find no slot in their bucket, but a look-up of a cell compares more keys.
const BUCKET_SLOTS: u64 = 8;

/// The size of the table of world reservoirs (the reservoirs of path vertices). From the key of a cell of space, the table
/// finds the list of path vertices in this cell. It is divided into buckets, so that a look-up compares only the keys of one
/// bucket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TableSize {
    /// The number of path vertices per frame that have a world reservoir, summed over all pixels. If it is 0, there is no
    /// table.
    pub vertices: u64,
    /// The number of buckets, a power of two. The key of a cell decides its bucket, so that a look-up of the cell reads only
    /// this bucket.
    pub buckets: u64,
    /// The number of slots per bucket, a power of two. Each slot can store one cell. If more cells than this belong to a
    /// bucket, some of them are dropped, and their reservoirs are not reused.
    pub bucket_slots: u64,
}

impl TableSize {
    /// Computes the size of a table for `vertices` vertices. The number of slots is `vertices` × `fraction`, rounded up to a
    /// power of two.
    pub fn new(vertices: u64, fraction: f64) -> Self {
        let slots = (vertices as f64 * fraction).ceil().max(1.0) as u64;
        // The limit avoids an overflow. Tables of this size are too large for any device, and are refused later.
        let slots = slots.min(1 << 60).next_power_of_two();
        let bucket_slots = slots.min(BUCKET_SLOTS);
        Self {
            vertices,
            buckets: slots / bucket_slots,
            bucket_slots,
        }
    }

    /// The number of slots in all buckets together: the maximum number of cells that the table can hold.
    pub fn slots(&self) -> u64 {
        self.buckets * self.bucket_slots
    }

    /// The names and the sizes in bytes of the buffers of the table: the keys of the vertices, the cells of space, and
    /// the lists of vertices. The buffers are made with these sizes, which are first checked against the device's limits.
    pub fn bytes(&self) -> [(&'static str, u64); 3] {
        [
            ("world_keys", 4 * self.vertices),
            (
                "world_cells",
                4 * (self.slots() + PrefixSum::length(self.slots() + 1)),
            ),
            ("world_list", 4 * self.vertices),
        ]
    }

    /// Writes the number of vertices, the number of buckets, and the number of slots per bucket to `constants`, which
    /// shaders read.
    pub fn write(&self, constants: &mut WorldConstants) {
        constants.vertices = self.vertices as u32;
        constants.buckets = self.buckets as u32;
        constants.bucket_slots = self.bucket_slots as u32;
    }
}

/// The table of world reservoirs (the reservoirs of path vertices) on the device: its buffers, and the passes that fill them
/// in each frame. With it, path vertices of the next frame find the reservoirs in their cell of space.
pub struct WorldTable {
    insert: ComputePass,
    count: ComputePass,
    sum: PrefixSum,
    scatter: ComputePass,
    groups: [u32; 3],
    /// One 32-bit word per vertex, from which the lists are made. The pass that traces the paths writes the key of the
    /// vertex's cell; the word stays 0 if no path reaches the vertex. Later, `world_count` replaces the key by the slot of
    /// the cell plus 1, or by 0 if the table has no slot for the cell.
    pub keys: Buffer,
    /// The cells in the table, in 32-bit words. The first part has one word per slot: the key of its cell, or 0 if the slot
    /// is free. The second part has one word per slot: the index in `list` at which the list of the slot's cell begins. This
    /// list ends where the list of the next slot begins, so one more word follows for the end of the last list. The rest of
    /// the buffer holds the sums of blocks of values, from which the prefix sum computes the second part.
    pub cells: Buffer,
    /// The lists of all cells, one after the other, from which vertices of the next frame pick. An entry is one 32-bit
    /// word: the index of a vertex plus 1 in the lower `WORLD_VERTEX_BITS` bits, with random bits above; 0 is an entry
    /// without a vertex. If two vertices are written to the same entry, the larger word stays, and the other vertex is
    /// not reused.
    pub list: Buffer,
}

impl WorldTable {
    /// Makes the buffers of the table, and the passes that fill them. `size` has at least one vertex. `pass` makes the
    /// compute pass with a given name.
    ///
    /// # Errors
    /// A buffer exceeds a limit or the free memory of the device, or `pass` fails.
    pub fn new(
        device: &Arc<Device>,
        size: TableSize,
        pass: impl Fn(&str) -> Result<ComputePass>,
    ) -> Result<Self> {
        let [keys, cells, list] =
            (size.bytes()).map(|(name, bytes)| Buffer::new(device, name, bytes, Usage::default()));
        Ok(Self {
            insert: pass("world_insert")?,
            count: pass("world_count")?,
            sum: PrefixSum::new(size.slots(), size.slots() + 1, &pass)?,
            scatter: pass("world_scatter")?,
            groups: in_rows((size.vertices as u32).div_ceil(TILE * TILE)),
            keys: keys?,
            cells: cells?,
            list: list?,
        })
    }

    /// The buffers of the table, so that a restart can clear them: the keys of the vertices, the cells of space, and the
    /// lists of vertices.
    pub fn buffers(&self) -> [&Buffer; 3] {
        [&self.keys, &self.cells, &self.list]
    }

    /// Records the command that sets the keys of all vertices to 0, so that vertices which no path reaches belong to no
    /// cell. It must be recorded before the pass that traces paths and writes the keys of their vertices.
    pub fn begin<'a>(&'a self, recording: &mut Recording<'a>) {
        recording.clear(&self.keys);
    }

    /// Records the passes that make the list of vertices of each cell, from the keys that the paths of this frame have
    /// written. `restir` is the buffer of the frame's constants.
    ///
    /// # Errors
    /// The driver rejects a shader, or the names of the bindings differ from those in the shader.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        restir: &'a Buffer,
        counters: &'a Buffer,
    ) -> Result<()> {
        let Self {
            keys: world_keys,
            cells: world_cells,
            list: world_list,
            ..
        } = self;
        for buffer in [world_cells, world_list] {
            recording.clear(buffer);
        }
        let insert = InsertCells {
            restir,
            world_keys,
            world_cells,
        };
        recording.pass(&self.insert, &insert, &(), self.groups)?;
        let count = CountVertices {
            restir,
            world_keys,
            world_cells,
            counters,
        };
        recording.pass(&self.count, &count, &(), self.groups)?;
        self.sum.record(recording, world_cells)?;
        let scatter = ScatterVertices {
            restir,
            world_keys,
            world_cells,
            world_list,
            counters,
        };
        recording.pass(&self.scatter, &scatter, &(), self.groups)
    }
}
