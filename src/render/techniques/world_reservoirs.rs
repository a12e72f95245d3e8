//! World reservoirs: the vertices of paths reuse light samples of vertices that were close by in the previous frame (Boissé,
//! "World-Space Spatiotemporal Reservoir Reuse for Ray-Traced Global Illumination", 2021).
//!
//! `initial_indirect` merges the reservoirs of the previous frame and keeps those of this one
//! (`glsl/restir/world_reservoirs.glsl`). Then a table of them is made for the next frame.

use super::world_table::{TableSize, WorldTable};
use crate::Result;
use crate::choices::WorldReservoirs;
use crate::gpu::{Buffer, ComputePass, Device, Usage};
use crate::layouts::{GpuWorldVertex, ViewConstants, WorldConstants};
use crate::render::history::History;
use crate::render::settings::{
    Secondary, Settings, WorldMode, WorldReservoirsSettings, WorldStores,
};
use std::sync::Arc;

/// The reservoirs and their table.
pub struct WorldLight {
    /// Reservoirs, vertex by vertex of the paths of all pixels.
    pub vertices: History<Buffer>,
    /// Where they are in space.
    pub table: WorldTable,
    /// What the shaders need to know of it.
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
        _ => (settings.world_reservoirs.depth).min(view.bounces.saturating_sub(1)),
    }
}

fn table_size(settings: &Settings, view: &ViewConstants, slots: u64) -> TableSize {
    let vertices = slots * u64::from(depth(settings, view));
    TableSize::new(vertices, settings.world_reservoirs.table)
}

/// Bytes of the buffers, by name, for a picture with `slots` places for pixels.
pub fn bytes(settings: &Settings, view: &ViewConstants, slots: u64) -> [(&'static str, u64); 5] {
    let size = table_size(settings, view, slots);
    let [keys, table, offsets, list] = size.bytes();
    let vertices = size.vertices.max(1) * size_of::<GpuWorldVertex>() as u64;
    [("world_vertices", vertices), keys, table, offsets, list]
}

impl WorldLight {
    /// Makes what `settings` need for a picture with `slots` places for pixels; `pass` makes a pass by name.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(
        device: &Arc<Device>,
        settings: &Settings,
        view: &ViewConstants,
        slots: u64,
        pass: impl Fn(&str) -> Result<ComputePass>,
    ) -> Result<Self> {
        let size = table_size(settings, view, slots);
        let table = WorldTable::new(device, size, pass)?;
        let [(name, vertex_bytes), ..] = bytes(settings, view, slots);
        let vertices = (0..if table.is_used() { 2 } else { 1 })
            .map(|_| Buffer::new(device, name, vertex_bytes, Usage::default()));
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

    /// The buffers.
    pub fn buffers(&self) -> impl Iterator<Item = &Buffer> {
        self.vertices.all().iter().chain(self.table.buffers())
    }
}
