//! Bytes of the buffers of resampling, known before they are allocated. Buffers that a device has no room for are refused.

use super::hash_grid;
use super::light_lists::LightLists;
use super::world_reservoirs;
use crate::gpu::Device;
use crate::render::Tracking;
use crate::render::kind::Kind;
use crate::render::reservoir_layout::ReservoirLayout;
use crate::render::settings::Settings;
use crate::shader_interface::{
    INDIRECT_COMPACT_WORDS, PILOT_WORDS, ReservoirAov, SampleData, ViewConstants,
};
use crate::{Error, Result};
use glam::Vec3;

// A pilot fits into the reservoir that holds it.
const _: () = assert!(PILOT_WORDS <= INDIRECT_COMPACT_WORDS);

/// Bytes of the buffers of a picture.
pub struct BufferSizes {
    /// Places for pixels: a number, not bytes.
    pub slots: u64,
    /// Radiance.
    pub color: u64,
    /// Primary surfaces.
    pub sample_data: u64,
    /// Pilots that are in no reservoirs.
    pub own_pilots: u64,
    /// From one pilot to the next.
    pub pilot_stride: u64,
    /// Reservoirs of direct light.
    pub direct: u64,
    /// Reservoirs of indirect light.
    pub indirect: u64,
    /// Lists of lights.
    pub light_lists: u64,
    /// The hash grid, by name.
    pub hash_grid: [(&'static str, u64); 3],
    /// World reservoirs of one frame, by name.
    pub world_vertices: [(&'static str, u64); 2],
    /// The table of world reservoirs, by name.
    pub world_table: [(&'static str, u64); 3],
}

impl BufferSizes {
    /// What a picture needs with these settings and this layout of reservoirs.
    pub fn of(view: &ViewConstants, settings: &Settings, layout: &ReservoirLayout) -> Self {
        let pixels = u64::from(view.width) * u64::from(view.height);
        let slots = layout.slots(view.width, view.height);
        let has = |kind: Kind| kind.is_wanted(settings, view.bounces);
        let pilot = u64::from(4 * PILOT_WORDS);
        // Indirect light without reservoirs keeps the buffer for its pilots.
        let indirect_bytes = if Kind::Indirect.is_shared(settings) {
            layout.bytes(Kind::Indirect)
        } else {
            pilot
        };
        let own_pilots =
            has(Kind::Direct) && settings.direct.draws_pilots(false) && !has(Kind::Indirect);
        let pilot_stride = if has(Kind::Indirect) {
            indirect_bytes
        } else {
            pilot
        };
        Self {
            slots,
            color: pixels * size_of::<Vec3>() as u64,
            sample_data: slots * size_of::<SampleData>() as u64,
            // A pass must find a buffer for each binding, even if it does not read it.
            own_pilots: pilot_stride * if own_pilots { slots } else { 1 },
            pilot_stride,
            direct: slots * layout.bytes(Kind::Direct),
            indirect: slots * indirect_bytes,
            light_lists: LightLists::bytes(settings, view),
            hash_grid: hash_grid::bytes(settings, view, layout),
            world_vertices: world_reservoirs::vertex_bytes(settings, view, slots),
            world_table: world_reservoirs::table_bytes(settings, view, slots),
        }
    }

    /// Refuses what a device cannot bind at once, or allocate for shaders that take addresses.
    ///
    /// # Errors
    /// A buffer is too large.
    pub fn check(
        &self,
        device: &Device,
        by_address: bool,
        view: &ViewConstants,
        settings: &Settings,
        tracking: Tracking,
    ) -> Result<()> {
        let (width, height) = (view.width, view.height);
        let mut needed = vec![
            ("sample_data", self.sample_data),
            ("color", self.color),
            ("pilots", self.own_pilots),
            ("light_lists", self.light_lists),
        ];
        needed.extend(self.hash_grid);
        needed.extend(self.world_vertices);
        needed.extend(self.world_table);
        if tracking.origins {
            let pixels = u64::from(width) * u64::from(height);
            let bytes = pixels * size_of::<ReservoirAov>() as u64;
            needed.push(("reservoir_aovs", bytes));
        }
        for (kind, bytes) in [(Kind::Direct, self.direct), (Kind::Indirect, self.indirect)] {
            if kind.is_wanted(settings, view.bounces) {
                needed.push(("reservoirs", bytes));
            }
        }
        let info = &device.info;
        let bound = info.max_storage_buffer_range.min(info.max_buffer_size);
        let is_vertices = |name: &str| self.world_vertices.iter().any(|(own, _)| *own == name);
        let limit = |name: &str| match by_address && is_vertices(name) {
            true => ("allocates", info.max_buffer_size),
            false => ("binds", bound),
        };
        match needed.iter().find(|(name, bytes)| *bytes > limit(name).1) {
            None => Ok(()),
            Some((name, bytes)) => {
                let (does, limit) = limit(name);
                let way_out = if is_vertices(name) && info.buffer_addresses && !by_address {
                    "use --geometry buffer-addresses, lower world_reservoirs.depth, or choose a smaller picture"
                } else if *name == "world_cells" {
                    "lower world_reservoirs.depth or .table, or choose a smaller picture"
                } else if is_vertices(name) || self.world_table.iter().any(|(own, _)| own == name) {
                    "lower world_reservoirs.depth, or choose a smaller picture"
                } else if *name == "light_lists" {
                    "lower light_bvh.list, raise light_bvh.tile, or choose a smaller picture"
                } else {
                    "choose a smaller picture, or --preset path-tracing"
                };
                Err(Error::input(format!(
                    "a picture of {width} × {height} needs {bytes} bytes for its {name}, but device '{}' {does} at most {limit}; {way_out}",
                    info.name
                )))
            }
        }
    }
}
