//! The sizes in bytes of the buffers of reservoir resampling, computed before the buffers are allocated. A size that exceeds
//! a limit of the device is refused, with a message that says how the user can avoid it.

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

// The buffer of reservoirs of indirect light can store pilots, so a pilot must not be larger than a reservoir.
const _: () = assert!(PILOT_WORDS <= INDIRECT_COMPACT_WORDS);

/// The sizes in bytes of the buffers of reservoir resampling for one picture, with which the buffers are allocated and
/// checked against the limits of the device. Some buffers need two copies (for the previous frame, or for the input and
/// the output of spatial reuse); each copy has the size that is stored here.
pub struct BufferSizes {
    /// The number of slots for pixels in each buffer (not bytes): the number of pixels of the picture, padded to whole tiles
    /// if pixels are ordered in tiles.
    pub slots: u64,
    /// Size in bytes of the buffer of the picture, which stores the RGB radiance of each pixel as three 32-bit floats.
    pub color: u64,
    /// Size in bytes of the buffer of sample data. This buffer stores the primary surface of each pixel, which is the
    /// surface that the camera sees there.
    pub sample_data: u64,
    /// Size in bytes of the separate buffer for the pilots (the first BSDF ray of each pixel). 0 if there are no pilots, or
    /// if they are stored in the buffer of the reservoirs of indirect light.
    pub separate_pilots: u64,
    /// The distance in memory from the pilot (first BSDF ray) of one pixel to that of the next, in bytes, by which shaders
    /// find pilots. It is the size of a reservoir if reservoirs of indirect light store the pilots, otherwise the size of a
    /// pilot. Shaders do not use it with `reservoirs.arrays=soa`.
    pub pilot_stride: u64,
    /// Size in bytes of one buffer of reservoirs of direct light, which has `slots` reservoirs: one for each pixel, and more
    /// if pixels are padded to whole tiles. The buffer is made only if direct light is rendered.
    pub direct: u64,
    /// Size in bytes of one buffer of reservoirs of indirect light, which is made only if indirect light is rendered. If
    /// indirect light is not stored in reservoirs, the buffer stores only the pilots, the first BSDF ray of each pixel.
    pub indirect: u64,
    /// The name and the size in bytes of each buffer of the light samplers (light lists, hash grid); empty if the settings
    /// use none.
    pub light_samplers: Vec<(&'static str, u64)>,
    /// The number of world reservoirs (the reservoirs of path vertices) and the size of the table that finds them, from
    /// which the sizes of their buffers are computed.
    pub world: WorldSize,
}

impl BufferSizes {
    /// Computes the sizes of the buffers for a picture with the width and height of `view`. `settings` are the settings of
    /// the renderer, and `layout` is the layout of reservoirs in memory.
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

    /// Checks that no buffer is larger than the device can bind. If `by_address` is true, the buffers with the path vertices
    /// of world reservoirs are not bound, because shaders reach them by address. These buffers may have any size that the
    /// device can allocate.
    ///
    /// # Errors
    /// A buffer is too large; the message names the buffer, and settings that make it smaller.
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
