//! World reservoirs: each vertex of an indirect path merges its light sample with samples of vertices that were close to it
//! in the previous frame (Boissé, "World-Space Spatiotemporal Reservoir Reuse for Ray-Traced Global Illumination", 2021).
//!
//! The pass `initial_indirect` merges the reservoirs of the previous frame and stores the reservoirs of this frame
//! (`glsl/world_reservoirs/world_reservoirs.glsl`). Further passes then make the table with which the next frame finds
//! these reservoirs.

pub mod prefix_sum;
pub mod settings;
pub mod table;
mod vertices;

pub use vertices::WorldVertices;

use crate::gpu::{Buffer, ComputePass, Device, Offers, Resource, Usage};
use crate::render::history::History;
use crate::shader_interface::{
    GpuGridPoint, GpuWorldSample, WORLD_VERTEX_BITS, WorldAddresses, WorldConstants,
};
use crate::{Error, Result};
use settings::{WorldReservoirsSettings, WorldStores};
use std::sync::Arc;
use table::{TableSize, WorldTable};

/// The world reservoirs of a renderer: the reservoirs of path vertices, the table that finds them by position, and the
/// constants that shaders read. A world reservoir stores a light sample at a path vertex, so that paths of the next frame
/// that pass nearby can reuse this sample.
pub struct WorldLight {
    /// The reservoirs of path vertices, in two copies: vertices of this frame write one copy, and merge reservoirs of the
    /// other copy, which the previous frame wrote.
    pub vertices: History<WorldVertices>,
    /// The table that lists the reservoirs of each cell of space. It is made after the paths of a frame are traced, so that
    /// vertices of the next frame find the reservoirs that this frame stored in their cell.
    pub table: WorldTable,
    /// The constants of world reservoirs that shaders read: settings and sizes. The buffer addresses are zeros here. The
    /// renderer copies these constants, and [`Self::begin_frame`] writes the addresses of each frame to the copy.
    pub constants: WorldConstants,
}

/// The number of world reservoirs (the reservoirs of path vertices) of a picture, and the size of the table that finds them.
/// The sizes of all their buffers follow from it, and can be checked before the buffers are made.
#[derive(Clone, Copy, Debug)]
pub struct WorldSize {
    /// The number of vertices of each path that have a world reservoir, counted from the second vertex on; 0 if there are no
    /// world reservoirs.
    depth: u32,
    table: TableSize,
}

impl WorldSize {
    /// Computes the number of world reservoirs and the size of their table, for paths with at most `bounces` scattering
    /// events. `slots` is the number of pixels, padded to whole tiles. If `is_used` is false, there are no world reservoirs,
    /// and `bounces` has no effect.
    pub fn new(
        settings: &WorldReservoirsSettings,
        is_used: bool,
        bounces: u32,
        slots: u64,
    ) -> Self {
        let depth = if is_used {
            settings.depth.min(bounces - 1)
        } else {
            0
        };
        Self {
            depth,
            table: TableSize::new(slots * u64::from(depth), settings.table),
        }
    }

    /// Checks that the lists of the table can name every vertex: an entry has only `WORLD_VERTEX_BITS` bits for the index of
    /// a vertex plus 1. With more vertices, an entry could name a wrong one.
    ///
    /// # Errors
    /// There are more vertices than `WORLD_VERTEX_BITS` bits can name.
    pub fn check(&self) -> Result<()> {
        let vertices = self.table.vertices;
        let most = (1 << WORLD_VERTEX_BITS) - 1;
        if vertices <= most {
            return Ok(());
        }
        Err(Error::input(format!(
            "world reservoirs at {vertices} path vertices are too many, there may be {most}; lower world_reservoirs.depth, or choose a smaller picture"
        )))
    }

    /// The names and the sizes in bytes of the two buffers of one copy of the reservoirs: the points of the vertices,
    /// then their light samples. A renderer has two such copies, one for the current frame and one for the previous
    /// frame. Without world reservoirs, the sizes are 0. The device's limits are checked with these sizes.
    pub fn vertex_bytes(&self) -> [(&'static str, u64); 2] {
        let vertices = self.table.vertices;
        [
            ("world_points", size_of::<GpuGridPoint>()),
            ("world_samples", size_of::<GpuWorldSample>()),
        ]
        .map(|(name, bytes)| (name, vertices * bytes as u64))
    }

    /// The names and the sizes in bytes of the buffers of the table that finds the reservoirs: the keys of the vertices,
    /// the cells of space, and the lists of vertices. The device's limits are checked with these sizes.
    pub fn table_bytes(&self) -> [(&'static str, u64); 3] {
        self.table.bytes()
    }
}

impl WorldLight {
    /// Makes the buffers of the reservoirs, and the table that finds them; `None` if no path vertices have reservoirs. If
    /// `by_address` is true, shaders reach the reservoirs by buffer address, so that the device's limit on bound bytes does
    /// not matter; otherwise by bindings. `pass` makes the compute pass with a given name.
    ///
    /// # Errors
    /// A buffer exceeds a limit or the free memory of the device, or `pass` fails.
    pub fn new(
        device: &Arc<Device>,
        settings: &WorldReservoirsSettings,
        size: WorldSize,
        by_address: bool,
        pass: impl Fn(&str) -> Result<ComputePass>,
    ) -> Result<Option<Self>> {
        if size.table.vertices == 0 {
            return Ok(None);
        }
        let table = WorldTable::new(device, size.table, pass)?;
        let buffers = size.vertex_bytes();
        let vertices = (0..2).map(|_| {
            let [points, samples] =
                buffers.map(|(name, bytes)| Buffer::new(device, name, bytes, Usage::default()));
            let (points, samples) = (points?, samples?);
            let addresses = if by_address {
                WorldAddresses {
                    points: points.address_words()?,
                    samples: samples.address_words()?,
                }
            } else {
                WorldAddresses::default()
            };
            Ok(WorldVertices {
                points,
                samples,
                addresses,
            })
        });
        let WorldReservoirsSettings {
            mode: _,
            stores,
            cell,
            bins,
            jitter,
            merged,
            confidence_cap,
            table: _,
            min_lights: _,
            depth: _,
        } = *settings;
        let mut constants = WorldConstants {
            cell: cell as f32,
            bins,
            jitter,
            merged,
            confidence_cap: confidence_cap as f32,
            keeps_merged: (stores == WorldStores::Merged).into(),
            depth: size.depth,
            ..WorldConstants::default()
        };
        size.table.write(&mut constants);
        Ok(Some(Self {
            vertices: History::new(vertices.collect::<Result<_>>()?),
            table,
            constants,
        }))
    }

    /// Exchanges the two copies of the reservoirs at the start of a frame: the reservoirs of the last frame become the
    /// previous ones, which paths of the new frame merge. Writes the buffer addresses of both copies to `constants`, the
    /// constants of the new frame.
    pub fn begin_frame(&self, constants: &mut WorldConstants) {
        self.vertices.advance();
        constants.previous = self.vertices.last().addresses;
        constants.current = self.vertices.current().addresses;
    }

    /// All buffers of world reservoirs, so that a restart can clear them: those of both copies of the reservoirs, then those
    /// of the table.
    pub fn buffers(&self) -> impl Iterator<Item = &Buffer> {
        let vertices = self.vertices.all().iter();
        vertices
            .flat_map(|frame| [&frame.points, &frame.samples])
            .chain(self.table.buffers())
    }
}

impl Offers for WorldLight {
    /// The buffers that passes bind by name. For reading: the reservoirs of the previous frame, and the cells and lists
    /// of the table that finds them. For writing: the reservoirs of this frame, and the keys of their cells. Shaders that
    /// reach the reservoirs by address bind only the cells, lists and keys.
    fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let (previous, current) = (self.vertices.last(), self.vertices.current());
        vec![
            ("previous_world_points", Resource::Read(&previous.points)),
            ("previous_world_samples", Resource::Read(&previous.samples)),
            ("world_points", Resource::Write(&current.points)),
            ("world_samples", Resource::Write(&current.samples)),
            ("world_cells", Resource::Read(&self.table.cells)),
            ("world_list", Resource::Read(&self.table.list)),
            ("world_keys", Resource::Write(&self.table.keys)),
        ]
    }
}
