//! World reservoirs: the vertices of paths reuse light samples of vertices that were close by in the previous frame (Boissé,
//! "World-Space Spatiotemporal Reservoir Reuse for Ray-Traced Global Illumination", 2021).
//!
//! `initial_indirect` merges the reservoirs of the previous frame and keeps those of this one
//! (`glsl/world_reservoirs/world_reservoirs.glsl`). Then a table of them is made for the next frame.

pub mod prefix_sum;
pub mod settings;
pub mod table;
mod vertices;

pub use vertices::WorldVertices;

use crate::gpu::{Buffer, ComputePass, Device, Usage};
use crate::render::history::History;
use crate::shader_interface::{
    GpuGridPoint, GpuWorldSample, WORLD_VERTEX_BITS, WorldAddresses, WorldConstants,
};
use crate::{Error, Result};
use settings::{WorldReservoirsSettings, WorldStores};
use std::sync::Arc;
use table::{TableSize, WorldTable};

/// The reservoirs and their table.
pub struct WorldLight {
    /// The reservoirs.
    pub vertices: History<WorldVertices>,
    /// The table that finds reservoirs by their position in space.
    pub table: WorldTable,
    /// Constants of the shaders.
    pub constants: WorldConstants,
}

/// The size of a picture's world reservoirs.
#[derive(Clone, Copy, Debug)]
pub struct WorldSize {
    /// The number of vertices per path that have reservoirs; 0: there are no world reservoirs.
    depth: u32,
    table: TableSize,
}

impl WorldSize {
    /// The size for paths with at most `bounces` scattering events and a picture with `slots` slots for pixels; without
    /// `is_used`, there are no world reservoirs.
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

    /// Refuses more vertices than the lists of the table can index.
    ///
    /// # Errors
    /// There are more vertices.
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

    /// The names and the sizes in bytes of a frame's buffers of points and samples.
    pub fn vertex_bytes(&self) -> [(&'static str, u64); 2] {
        let vertices = self.table.vertices.max(1);
        [
            ("world_points", size_of::<GpuGridPoint>()),
            ("world_samples", size_of::<GpuWorldSample>()),
        ]
        .map(|(name, bytes)| (name, vertices * bytes as u64))
    }

    /// The names and the sizes in bytes of the table's buffers.
    pub fn table_bytes(&self) -> [(&'static str, u64); 3] {
        self.table.bytes()
    }
}

impl WorldLight {
    /// Makes the reservoirs and their table. `by_address`: shaders reach the reservoirs by buffer address; `pass` makes a pass
    /// by name.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(
        device: &Arc<Device>,
        settings: &WorldReservoirsSettings,
        size: WorldSize,
        by_address: bool,
        pass: impl Fn(&str) -> Result<ComputePass>,
    ) -> Result<Self> {
        let table = WorldTable::new(device, size.table, pass)?;
        let buffers = size.vertex_bytes();
        let vertices = (0..if table.is_used() { 2 } else { 1 }).map(|_| {
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
        Ok(Self {
            vertices: History::new(vertices.collect::<Result<_>>()?),
            table,
            constants,
        })
    }

    /// Advances the history, and stores the addresses of the frame's reservoirs in its constants.
    pub fn begin_frame(&self, constants: &mut WorldConstants) {
        self.vertices.advance();
        constants.previous = self.vertices.last().addresses;
        constants.current = self.vertices.current().addresses;
    }

    /// The buffers.
    pub fn buffers(&self) -> impl Iterator<Item = &Buffer> {
        let vertices = self.vertices.all().iter();
        vertices
            .flat_map(|frame| [&frame.points, &frame.samples])
            .chain(self.table.buffers())
    }
}
