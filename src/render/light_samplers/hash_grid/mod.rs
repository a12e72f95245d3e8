//! The hash grid: reservoirs of direct light that belong to cells of space. A reservoir is found by a hash of its cell. Each
//! reservoir is made from many candidates, and pixels merge it with their own candidates, so that already the first frame
//! has little noise ("Normal-aware hash grid of precomputed reservoirs", 2025).
//!
//! `glsl/lights/samplers/hash_grid/hash_grid.glsl` describes the grid. By default, the surfaces that pixels show fill the
//! grid in each frame, so that it fits the picture and follows all motion. With `hash_grid.mode=published`, random points on
//! the surfaces of the whole scene fill it once, in the first frame.

pub mod settings;

use super::{Kind, LightSampler, Made, SamplerInputs, SamplerSettings};
use crate::Result;
use crate::device_scene::geometry::pack_octahedral;
use crate::device_scene::surface_points::SurfacePoint;
use crate::gpu::{Buffer, ComputePass, Recording, Usage, in_rows};
use crate::render::frame_inputs::FrameInputs;
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::{
    GRID_BLOCK, GpuGridPoint, GpuGridSlot, GridConstants, HashGrid, RestirConstants, TILE,
    ViewConstants,
};
use settings::{GridMode, HashGridSettings};

crate::bindings! {
    /// Bindings of the pass `grid_claim`, in which surfaces claim slots of the hash grid. It selects, for each slot, the
    /// surface for which the slot's reservoir will be made. Each surface picks a random slot of its cell. If several
    /// surfaces pick the same slot, one of them is selected at random; a slot that none picks stays empty.
    pub struct ClaimGrid {
        [offers scene: SceneBindings]
        [optional read grid_points]
        uniform restir,
        read sample_data,
        write grid_slots,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass `grid_fill`. For each surface that `grid_claim` has selected for a slot of the hash grid, it
    /// makes the slot's reservoir from many light samples. Pixels merge these reservoirs with their own candidates.
    pub struct FillGrid {
        [offers scene: SceneBindings]
        [optional read grid_points]
        uniform restir,
        read sample_data,
        write grid_slots,
        write grid_reservoirs,
        write counters,
    }
}

/// The number of random points on the surfaces of the scene that fill the hash grid with `hash_grid.mode=published`. Each
/// point counts twice, once for each side of its surface. Higher: more cells have reservoirs, but the grid needs more
/// memory.
const SURFACE_POINTS: usize = 1 << 19;

/// The hash grid as a light sampler: the passes that fill it, its buffers, and its constants for shaders. The pass
/// `initial_direct` merges reservoirs of the grid with the candidates of each pixel.
pub struct HashGridLight {
    /// The pass `grid_claim`, which selects one surface for each slot of the hash grid; the slot's reservoir is then made
    /// for this surface. Each surface picks a random slot of its cell of space. If several surfaces pick the same slot, the
    /// pass selects one of them at random.
    claim: ComputePass,
    /// The pass `grid_fill`. For each slot for which `grid_claim` has selected a surface, it makes a reservoir from many
    /// light samples.
    fill: ComputePass,
    /// Random points on the scene's surfaces with their normals, which fill the grid in the first frame. `None` if the
    /// surfaces that pixels show fill it in each frame.
    points: Option<Buffer>,
    /// The slots of the hash grid, each of which has one reservoir. A slot stores the index of the surface for which its
    /// reservoir is made, and a hash. The hash is computed from the cell of space that contains the surface, and from the
    /// bin (range of directions) of the normal of the surface. A pixel uses a reservoir only if the hash is equal to that
    /// of its own surface.
    slots: Buffer,
    /// The reservoir of each slot, in the same format as the reservoirs of direct light of pixels. Pixels merge it with
    /// their own candidates.
    reservoirs: Buffer,
    constants: GridConstants,
}

/// The number of surfaces that can fill slots of the hash grid in a frame, and the number of slots; both are 0 if there is
/// no grid. The surfaces are those of one random pixel in each block of pixels, or both sides of each random point on the
/// scene's surfaces. The number of slots is a power of two and at least twice the number of surfaces, so that few cells
/// share a slot.
fn counts(filled_by: HashGrid, view: &ViewConstants) -> (u64, u64) {
    let surfaces = match filled_by {
        HashGrid::None => return (0, 0),
        HashGrid::Pixels => {
            let [x, y] = [view.width, view.height].map(|side| side.div_ceil(GRID_BLOCK));
            u64::from(x) * u64::from(y)
        }
        HashGrid::Points => 2 * SURFACE_POINTS as u64,
    };
    // At least half of the slots stay free, so that few cells share a slot.
    (surfaces, (2 * surfaces).next_power_of_two())
}

/// The name and the size in bytes of each of the three buffers of the hash grid: points on surfaces, slots and reservoirs;
/// `None` if there is no grid. The buffer of points has 0 bytes if the primary surfaces of pixels fill the grid.
/// `reservoir_bytes` is the size of one reservoir.
fn bytes(
    filled_by: HashGrid,
    view: &ViewConstants,
    reservoir_bytes: u64,
) -> Option<[(&'static str, u64); 3]> {
    let (surfaces, slots) = counts(filled_by, view);
    let points = match filled_by {
        HashGrid::None => return None,
        HashGrid::Pixels => 0,
        HashGrid::Points => surfaces,
    };
    Some([
        ("grid_points", points * size_of::<GpuGridPoint>() as u64),
        ("grid_slots", slots * size_of::<GpuGridSlot>() as u64),
        ("grid_reservoirs", slots * reservoir_bytes),
    ])
}

impl HashGridLight {
    /// The functions with which `LightSamplers` makes the hash grid, and computes the sizes of its buffers.
    pub(super) const KIND: Kind = Kind {
        bytes: |settings, view, reservoir_bytes| {
            let sizes = bytes(settings.filled_by, view, reservoir_bytes);
            sizes.into_iter().flatten().collect()
        },
        make: Self::make,
    };

    fn make(inputs: &SamplerInputs<'_>) -> Result<Made> {
        let SamplerInputs {
            device,
            settings,
            view,
            ..
        } = *inputs;
        let SamplerSettings {
            filled_by,
            hash_grid: grid,
            light_samples,
            ..
        } = settings;
        let Some(sizes) = bytes(filled_by, view, inputs.reservoir_bytes) else {
            return Ok(None);
        };
        let (surfaces, slots) = counts(filled_by, view);
        let mut sources = surfaces as u32;
        let [points, grid_slots, reservoirs] = sizes;
        let buffer = |(name, bytes)| Buffer::new(device, name, bytes, Usage::default());
        let mut cell = grid.cell as f32;
        let points = match filled_by {
            HashGrid::Points => {
                let surfaces = inputs.scene.surface_points(SURFACE_POINTS)?;
                cell = cell_size(&surfaces, grid.cells);
                let both_sides: Vec<GpuGridPoint> = (surfaces.iter())
                    .flat_map(|point| [1.0, -1.0].map(|side| (point.position, side * point.normal)))
                    .map(|(position, normal)| GpuGridPoint {
                        position,
                        normal: pack_octahedral(normal),
                    })
                    .collect();
                // A scene without surfaces has no such points.
                sources = both_sides.len() as u32;
                let points = buffer(points)?;
                points.write(&both_sides)?;
                Some(points)
            }
            HashGrid::None | HashGrid::Pixels => None,
        };
        let HashGridSettings {
            mode,
            bins,
            reservoirs: per_cell,
            candidates,
            merged,
            confidence,
            until_frame,
            ..
        } = *grid;
        Ok(Some(Box::new(Self {
            claim: (inputs.pass)("grid_claim")?,
            fill: (inputs.pass)("grid_fill")?,
            points,
            slots: buffer(grid_slots)?,
            reservoirs: buffer(reservoirs)?,
            constants: GridConstants {
                cell,
                bins,
                slots: slots as u32,
                sources,
                reservoirs: per_cell,
                candidates,
                merged,
                confidence: match mode {
                    GridMode::Unbiased => confidence as f32,
                    GridMode::Published => (candidates as f32 / light_samples as f32).max(1.0),
                },
                until_frame: match until_frame {
                    0 => u32::MAX,
                    frame => frame,
                },
            },
        })))
    }
}

impl LightSampler for HashGridLight {
    fn buffers(&self) -> Vec<(&'static str, &Buffer)> {
        let points = self.points.iter().map(|points| ("grid_points", points));
        let others = [
            ("grid_slots", &self.slots),
            ("grid_reservoirs", &self.reservoirs),
        ];
        points.chain(others).collect()
    }

    fn set_constants(&self, constants: &mut RestirConstants) {
        constants.grid = self.constants;
    }

    fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        restir: &'a Buffer,
    ) -> Result<()> {
        let is_kept = self.points.is_some();
        if inputs.frame >= self.constants.until_frame || (is_kept && !inputs.is_first) {
            return Ok(());
        }
        let FrameInputs {
            scene,
            sample_data,
            counters,
            ..
        } = *inputs;
        let groups = in_rows(self.constants.sources.div_ceil(TILE * TILE));
        recording.clear(&self.slots);
        let bindings = ClaimGrid {
            scene,
            restir,
            sample_data,
            grid_points: self.points.as_ref(),
            grid_slots: &self.slots,
            counters,
        };
        recording.pass(&self.claim, &bindings, &(), groups)?;
        let bindings = FillGrid {
            scene,
            restir,
            sample_data,
            grid_points: self.points.as_ref(),
            grid_slots: &self.slots,
            grid_reservoirs: &self.reservoirs,
            counters,
        };
        recording.pass(&self.fill, &bindings, &(), groups)
    }
}

/// The side of a cell, in the same unit as the coordinates of `points`: the longest side of the bounding box of all
/// points, divided by `cells`. This side is used if points in the whole scene fill the grid. It is 1 if the bounding box
/// has no extent, for example without points.
fn cell_size(points: &[SurfacePoint], cells: u32) -> f32 {
    let positions = points.iter().map(|point| point.position);
    let low = positions
        .clone()
        .reduce(glam::Vec3::min)
        .unwrap_or_default();
    let high = positions.reduce(glam::Vec3::max).unwrap_or_default();
    match (high - low).max_element() {
        side if side > 0.0 => side / cells as f32,
        _ => 1.0,
    }
}
