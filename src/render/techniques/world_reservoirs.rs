//! World reservoirs: the vertices of paths reuse light samples of vertices that were close by in the previous frame (Boissé,
//! "World-Space Spatiotemporal Reservoir Reuse for Ray-Traced Global Illumination", 2021).
//!
//! `initial_indirect` merges the reservoirs of the previous frame and keeps those of this one
//! (`glsl/restir/world_reservoirs.glsl`). Then a table of them is made for the next frame.

use super::world_table::{TableSize, WorldTable};
use crate::gpu::{Buffer, ComputePass, Device, Usage};
use crate::render::history::History;
use crate::render::kind::Kind;
use crate::render::settings::{
    Secondary, Settings, WorldMode, WorldReservoirsSettings, WorldStores,
};
use crate::render::world_vertices::WorldVertices;
use crate::shader_interface::WorldReservoirs;
use crate::shader_interface::{
    GpuGridPoint, GpuWorldSample, ViewConstants, WORLD_VERTEX_BITS, WorldAddresses, WorldConstants,
};
use crate::{Error, Result};
use std::sync::Arc;

/// The reservoirs and their table.
pub struct WorldLight {
    /// The reservoirs.
    pub vertices: History<WorldVertices>,
    /// Where they are in space.
    pub table: WorldTable,
    /// Constants of the shaders.
    pub constants: WorldConstants,
}

impl Settings {
    /// How the vertices of paths reuse light samples of other vertices.
    pub fn world_reservoirs(&self) -> WorldReservoirs {
        match (self.indirect.secondary, self.world_reservoirs.mode) {
            (Secondary::WorldReservoirs, WorldMode::Unbiased) => WorldReservoirs::Unbiased,
            (Secondary::WorldReservoirs, WorldMode::Published) => WorldReservoirs::Published,
            _ => WorldReservoirs::None,
        }
    }
}

/// Vertices of a path that have reservoirs.
fn depth(settings: &Settings, view: &ViewConstants) -> u32 {
    match settings.world_reservoirs() {
        WorldReservoirs::None => 0,
        _ if !Kind::Indirect.is_wanted(settings, view.bounces) => 0,
        _ => (settings.world_reservoirs.depth).min(view.bounces - 1),
    }
}

fn table_size(settings: &Settings, view: &ViewConstants, slots: u64) -> TableSize {
    let vertices = slots * u64::from(depth(settings, view));
    TableSize::new(vertices, settings.world_reservoirs.table)
}

/// Refuses more vertices than the lists of the table can name.
///
/// # Errors
/// There are more.
pub fn check(settings: &Settings, view: &ViewConstants, slots: u64) -> Result<()> {
    let TableSize { vertices, .. } = table_size(settings, view, slots);
    let most = (1 << WORLD_VERTEX_BITS) - 1;
    if vertices <= most {
        return Ok(());
    }
    Err(Error::input(format!(
        "world reservoirs at {vertices} path vertices are too many, there may be {most}; lower world_reservoirs.depth, or choose a smaller picture"
    )))
}

/// Bytes of a frame's points and samples, by name, for a picture with `slots` places for pixels.
pub fn vertex_bytes(
    settings: &Settings,
    view: &ViewConstants,
    slots: u64,
) -> [(&'static str, u64); 2] {
    let vertices = table_size(settings, view, slots).vertices.max(1);
    [
        ("world_points", size_of::<GpuGridPoint>()),
        ("world_samples", size_of::<GpuWorldSample>()),
    ]
    .map(|(name, bytes)| (name, vertices * bytes as u64))
}

/// Bytes of the buffers of the table, by name.
pub fn table_bytes(
    settings: &Settings,
    view: &ViewConstants,
    slots: u64,
) -> [(&'static str, u64); 3] {
    table_size(settings, view, slots).bytes()
}

impl WorldLight {
    /// Makes what `settings` need for a picture with `slots` places for pixels. `by_address`: whether shaders reach the
    /// reservoirs by buffer address; `pass` makes a pass by name.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(
        device: &Arc<Device>,
        settings: &Settings,
        view: &ViewConstants,
        slots: u64,
        by_address: bool,
        pass: impl Fn(&str) -> Result<ComputePass>,
    ) -> Result<Self> {
        let size = table_size(settings, view, slots);
        let table = WorldTable::new(device, size, pass)?;
        let buffers = vertex_bytes(settings, view, slots);
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
        } = settings.world_reservoirs;
        let mut constants = WorldConstants {
            cell: cell as f32,
            bins,
            jitter,
            merged,
            confidence_cap: confidence_cap as f32,
            keeps_merged: (stores == WorldStores::Merged).into(),
            depth: depth(settings, view),
            ..WorldConstants::default()
        };
        size.write(&mut constants);
        Ok(Self {
            vertices: History::new(vertices.collect::<Result<_>>()?),
            table,
            constants,
        })
    }

    /// Advances the history, and says in a frame's constants where its reservoirs are.
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
