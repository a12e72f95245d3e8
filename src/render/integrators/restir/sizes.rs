//! The sizes in bytes of the buffers of resampling, computed before the buffers are allocated. Sizes that exceed the
//! device's limits are refused with a message that names a remedy.

use super::reservoir_layout::ReservoirLayout;
use crate::gpu::Device;
use crate::render::Tracking;
use crate::render::light_samplers::LightSamplers;
use crate::render::lighting::Lighting;
use crate::render::resolved_settings::ResolvedSettings;
use crate::render::world_reservoirs::WorldSize;
use crate::shader_interface::{
    INDIRECT_COMPACT_WORDS, PILOT_WORDS, ReservoirAov, SampleData, ViewConstants,
};
use crate::{Error, Result};
use glam::Vec3;

// A pilot fits into the reservoir that holds it.
const _: () = assert!(PILOT_WORDS <= INDIRECT_COMPACT_WORDS);

/// The sizes in bytes of the buffers of resampling for one picture. A buffer with history is allocated twice.
pub struct BufferSizes {
    /// The number of slots for pixels in a buffer, not bytes: the pixels of the picture, padded to whole tiles of the pixel
    /// order.
    pub slots: u64,
    /// Bytes of the picture: the RGB radiance of each pixel.
    pub color: u64,
    /// Bytes of the sample data, the primary surface of each pixel.
    pub sample_data: u64,
    /// Bytes of the buffer of pilots (first BSDF rays); 0 if there are no pilots, or if reservoirs of indirect light hold
    /// them.
    pub separate_pilots: u64,
    /// The distance from one pixel's pilot to the next, in bytes.
    pub pilot_stride: u64,
    /// Bytes of the reservoirs of direct light.
    pub direct: u64,
    /// Bytes of the reservoirs of indirect light, or only of its pilots if it has no reservoirs.
    pub indirect: u64,
    /// The name and the bytes of each buffer of light samplers.
    pub light_samplers: Vec<(&'static str, u64)>,
    /// The size of world reservoirs, from which the bytes of their buffers follow.
    pub world: WorldSize,
}

impl BufferSizes {
    /// The sizes for a picture of the size of `view`, with these settings and this layout of reservoirs.
    pub fn of(view: &ViewConstants, settings: &ResolvedSettings, layout: &ReservoirLayout) -> Self {
        let pixels = u64::from(view.width) * u64::from(view.height);
        let slots = layout.slots(view.width, view.height);
        let has = |lighting: Lighting| settings.renders(lighting);
        let pilot = u64::from(4 * PILOT_WORDS);
        // Indirect light without reservoirs keeps the buffer for its pilots.
        let indirect_bytes = if settings.uses_reservoirs(Lighting::Indirect) {
            layout.bytes(Lighting::Indirect)
        } else {
            pilot
        };
        let separate_pilots = has(Lighting::Direct)
            && settings.direct.draws_pilots(false)
            && !has(Lighting::Indirect);
        let pilot_stride = if has(Lighting::Indirect) {
            indirect_bytes
        } else {
            pilot
        };
        Self {
            slots,
            color: pixels * size_of::<Vec3>() as u64,
            sample_data: slots * size_of::<SampleData>() as u64,
            separate_pilots: if separate_pilots {
                pilot_stride * slots
            } else {
                0
            },
            pilot_stride,
            direct: slots * layout.bytes(Lighting::Direct),
            indirect: slots * indirect_bytes,
            light_samplers: settings.light_samplers().map_or_else(Vec::new, |samplers| {
                LightSamplers::bytes(&samplers, view, layout.bytes(Lighting::Direct))
            }),
            world: settings.world_size(slots),
        }
    }

    /// Checks that the device can bind each buffer at once. With `by_address`, the device only has to allocate the buffers
    /// of world reservoirs, since shaders reach them by address.
    ///
    /// # Errors
    /// A buffer is too large; the message names the buffer and settings that make it smaller.
    pub fn check(
        &self,
        device: &Device,
        by_address: bool,
        view: &ViewConstants,
        settings: &ResolvedSettings,
        tracking: Tracking,
    ) -> Result<()> {
        let (width, height) = (view.width, view.height);
        let mut needed = vec![
            ("sample_data", self.sample_data),
            ("color", self.color),
            ("pilots", self.separate_pilots),
        ];
        needed.extend(&self.light_samplers);
        let (world_vertices, world_table) = (self.world.vertex_bytes(), self.world.table_bytes());
        needed.extend(world_vertices);
        needed.extend(world_table);
        if tracking.origins {
            let pixels = u64::from(width) * u64::from(height);
            let bytes = pixels * size_of::<ReservoirAov>() as u64;
            needed.push(("reservoir_aovs", bytes));
        }
        for (lighting, bytes) in [
            (Lighting::Direct, self.direct),
            (Lighting::Indirect, self.indirect),
        ] {
            if settings.renders(lighting) {
                needed.push(("reservoirs", bytes));
            }
        }
        let info = &device.info;
        let bound = info.max_storage_buffer_range.min(info.max_buffer_size);
        let is_vertices = |name: &str| world_vertices.iter().any(|(own, _)| *own == name);
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
                } else if is_vertices(name) || world_table.iter().any(|(own, _)| own == name) {
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
