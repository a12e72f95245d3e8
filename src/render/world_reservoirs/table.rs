//! The table of world reservoirs: a list of path vertices for each cell of space, made on the device.
//!
//! Vertices have keys of cells. `world_insert` puts the keys into buckets, `world_count` counts the vertices of each cell,
//! a prefix sum turns the numbers into the beginnings of lists, and `world_scatter` enters the vertices there
//! (`glsl/world_reservoirs/world_table.glsl`). The lists do not depend on the order of threads.

use super::prefix_sum::PrefixSum;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage, in_rows};
use crate::shader_interface::{TILE, WorldConstants};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass that puts cells into the table.
    pub struct InsertCells {
        uniform restir,
        read world_keys,
        write world_cells,
    }
}

crate::bindings! {
    /// Bindings of the pass that counts the vertices of each cell.
    pub struct CountVertices {
        uniform restir,
        write world_keys,
        write world_cells,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass that enters vertices in the lists of their cells.
    pub struct ScatterVertices {
        uniform restir,
        read world_keys,
        read world_cells,
        write world_list,
        write counters,
    }
}

/// The maximum number of slots of a bucket.
const BUCKET_SLOTS: u64 = 8;

/// The size of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TableSize {
    /// The number of vertices; with 0, no pass uses the table.
    pub vertices: u64,
    /// The number of buckets, a power of two.
    pub buckets: u64,
    /// The number of slots per bucket.
    pub bucket_slots: u64,
}

impl TableSize {
    /// A table for `vertices`, with `share` slots per vertex; the total is rounded up to a power of two.
    pub fn new(vertices: u64, share: f64) -> Self {
        let slots = (vertices as f64 * share).ceil().max(1.0) as u64;
        // Sizes near 2⁶⁴ are refused like all that are too large.
        let slots = slots.min(1 << 60).next_power_of_two();
        let bucket_slots = slots.min(BUCKET_SLOTS);
        Self {
            vertices,
            buckets: slots / bucket_slots,
            bucket_slots,
        }
    }

    /// The number of slots in all buckets.
    pub fn slots(&self) -> u64 {
        self.buckets * self.bucket_slots
    }

    /// The names and the sizes in bytes of the buffers.
    pub fn bytes(&self) -> [(&'static str, u64); 3] {
        // A pass must find a buffer for each binding, even if it does not read it.
        let vertices = self.vertices.max(1);
        [
            ("world_keys", 4 * vertices),
            (
                "world_cells",
                4 * (self.slots() + PrefixSum::length(self.slots() + 1)),
            ),
            ("world_list", 4 * vertices),
        ]
    }

    /// Writes the size to the constants of the shaders.
    pub fn write(&self, constants: &mut WorldConstants) {
        constants.vertices = self.vertices as u32;
        constants.buckets = self.buckets as u32;
        constants.bucket_slots = self.bucket_slots as u32;
    }
}

/// The passes, if there are vertices, and the buffers.
pub struct WorldTable {
    passes: Option<Passes>,
    groups: [u32; 3],
    /// The keys of the vertices' cells, 0 for vertices without a cell; afterwards the slots of the cells, plus 1.
    pub keys: Buffer,
    /// The keys of all cells, bucket by bucket; afterwards the beginning of each slot's list.
    pub cells: Buffer,
    /// The lists: indices of vertices, plus 1, in the lower bits; 0 where there is a gap.
    pub list: Buffer,
}

struct Passes {
    insert: ComputePass,
    count: ComputePass,
    sum: PrefixSum,
    scatter: ComputePass,
}

impl WorldTable {
    /// Makes a table; `pass` makes a pass by name.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(
        device: &Arc<Device>,
        size: TableSize,
        pass: impl Fn(&str) -> Result<ComputePass>,
    ) -> Result<Self> {
        let [keys, cells, list] =
            (size.bytes()).map(|(name, bytes)| Buffer::new(device, name, bytes, Usage::default()));
        let passes = (size.vertices > 0).then(|| {
            Ok::<_, crate::Error>(Passes {
                insert: pass("world_insert")?,
                count: pass("world_count")?,
                sum: PrefixSum::new(size.slots(), size.slots() + 1, &pass)?,
                scatter: pass("world_scatter")?,
            })
        });
        Ok(Self {
            passes: passes.transpose()?,
            groups: in_rows((size.vertices as u32).div_ceil(TILE * TILE)),
            keys: keys?,
            cells: cells?,
            list: list?,
        })
    }

    /// True if there are vertices.
    pub fn is_used(&self) -> bool {
        self.passes.is_some()
    }

    /// The buffers.
    pub fn buffers(&self) -> [&Buffer; 3] {
        [&self.keys, &self.cells, &self.list]
    }

    /// Records that vertices have no cell yet, before their keys are written.
    pub fn begin<'a>(&'a self, recording: &mut Recording<'a>) {
        if self.is_used() {
            recording.clear(&self.keys);
        }
    }

    /// Records the passes that make the lists.
    ///
    /// # Errors
    /// A binding that a pass does not have.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        restir: &'a Buffer,
        counters: &'a Buffer,
    ) -> Result<()> {
        let Some(passes) = &self.passes else {
            return Ok(());
        };
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
        recording.pass(&passes.insert, &insert, &(), self.groups)?;
        let count = CountVertices {
            restir,
            world_keys,
            world_cells,
            counters,
        };
        recording.pass(&passes.count, &count, &(), self.groups)?;
        passes.sum.record(recording, world_cells)?;
        let scatter = ScatterVertices {
            restir,
            world_keys,
            world_cells,
            world_list,
            counters,
        };
        recording.pass(&passes.scatter, &scatter, &(), self.groups)
    }
}
