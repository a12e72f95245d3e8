//! The hash grid: reservoirs of direct light in cells of space, from many candidates each, which pixels merge with their own
//! candidates ("Normal-aware hash grid of precomputed reservoirs", 2025).
//!
//! `glsl/lights/samplers/hash_grid/hash_grid.glsl` has the grid. By default pixels of the frame fill it, so that it fits the picture and knows all
//! that moves; as published, points on the surfaces of the whole scene fill it once.

pub mod settings;

use crate::Result;
use crate::device_scene::GpuScene;
use crate::device_scene::geometry::pack_octahedral;
use crate::device_scene::surface_points::SurfacePoint;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage, in_rows};
use crate::render::frame_inputs::FrameInputs;
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::HashGrid;
use crate::shader_interface::{
    GRID_BLOCK, GpuGridPlace, GpuGridPoint, GridConstants, TILE, ViewConstants,
};
use settings::{GridMode, HashGridSettings};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass that decides whose the places are.
    pub struct ClaimGrid {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read grid_points,
        write grid_places,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass that makes reservoirs.
    pub struct FillGrid {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read grid_points,
        write grid_places,
        write grid_reservoirs,
        write counters,
    }
}

/// Points on surfaces that fill the published grid, from both sides each.
const SURFACE_POINTS: usize = 1 << 19;

/// The passes, where direct light has a grid, and the buffers.
pub struct HashGridLight {
    /// The passes that decide which surface has each entry, and that fill the entries.
    passes: Option<(ComputePass, ComputePass)>,
    /// True if what the first frame makes is kept.
    is_kept: bool,
    /// Points that fill it, if pixels do not.
    pub points: Buffer,
    /// Whose the places are.
    pub places: Buffer,
    /// A reservoir for each place.
    pub reservoirs: Buffer,
    /// Its constants for shaders.
    pub constants: GridConstants,
}

/// Number of surfaces that claim places, and of places.
fn counts(filled_by: HashGrid, view: &ViewConstants) -> (u64, u64) {
    let sources = match filled_by {
        // A pass must find a buffer for each binding, even if it does not read it.
        HashGrid::None => return (0, 1),
        HashGrid::Pixels => {
            let [x, y] = [view.width, view.height].map(|side| side.div_ceil(GRID_BLOCK));
            u64::from(x) * u64::from(y)
        }
        HashGrid::Points => 2 * SURFACE_POINTS as u64,
    };
    // With half of them free, few cells share one.
    (sources, (2 * sources).next_power_of_two())
}

/// Bytes of the buffers, by name, where a reservoir takes `reservoir_bytes`.
pub fn bytes(
    filled_by: HashGrid,
    view: &ViewConstants,
    reservoir_bytes: u64,
) -> [(&'static str, u64); 3] {
    let (sources, places) = counts(filled_by, view);
    let points = match filled_by {
        HashGrid::Points => sources,
        _ => 1,
    };
    [
        ("grid_points", points * size_of::<GpuGridPoint>() as u64),
        ("grid_places", places * size_of::<GpuGridPlace>() as u64),
        ("grid_reservoirs", places * reservoir_bytes),
    ]
}

impl HashGridLight {
    /// Makes the passes and buffers, for pixels with `light_samples` light samples each and reservoirs of `reservoir_bytes`;
    /// `pass` makes a pass by name.
    ///
    /// # Errors
    /// More memory than the device has.
    #[allow(clippy::too_many_arguments)]
    pub fn new(
        device: &Arc<Device>,
        scene: &GpuScene,
        filled_by: HashGrid,
        settings: &HashGridSettings,
        light_samples: u32,
        view: &ViewConstants,
        reservoir_bytes: u64,
        pass: impl Fn(&str) -> Result<ComputePass>,
    ) -> Result<Self> {
        let (sources, places) = counts(filled_by, view);
        let [points, place_buffer, reservoirs] = bytes(filled_by, view, reservoir_bytes)
            .map(|(name, bytes)| Buffer::new(device, name, bytes, Usage::default()));
        let points = points?;
        let mut sources = sources as u32;
        let mut cell = settings.cell as f32;
        if filled_by == HashGrid::Points {
            let surfaces = scene.surface_points(SURFACE_POINTS)?;
            cell = cell_size(&surfaces, settings.cells);
            let both_sides: Vec<GpuGridPoint> = (surfaces.iter())
                .flat_map(|point| [1.0, -1.0].map(|side| (point.position, side * point.normal)))
                .map(|(position, normal)| GpuGridPoint {
                    position,
                    normal: pack_octahedral(normal),
                })
                .collect();
            // An empty scene has none.
            points.write(&both_sides)?;
            sources = both_sides.len() as u32;
        }
        let passes = match filled_by {
            HashGrid::None => None,
            _ => Some((pass("grid_claim")?, pass("grid_fill")?)),
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
        } = *settings;
        Ok(Self {
            passes,
            is_kept: filled_by == HashGrid::Points,
            points,
            places: place_buffer?,
            reservoirs: reservoirs?,
            constants: GridConstants {
                cell,
                bins,
                places: places as u32,
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
        })
    }

    /// The buffers.
    pub fn buffers(&self) -> [&Buffer; 3] {
        [&self.points, &self.places, &self.reservoirs]
    }

    /// Records the passes of a frame, if there are any.
    ///
    /// # Errors
    /// A binding that a pass does not have.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        restir: &'a Buffer,
        frame: u32,
    ) -> Result<()> {
        let Some((claim, fill)) = &self.passes else {
            return Ok(());
        };
        if frame >= self.constants.until_frame || (self.is_kept && !inputs.is_first) {
            return Ok(());
        }
        let FrameInputs {
            scene,
            sample_data,
            counters,
            ..
        } = *inputs;
        let groups = in_rows(self.constants.sources.div_ceil(TILE * TILE));
        recording.clear(&self.places);
        let bindings = ClaimGrid {
            scene,
            restir,
            sample_data,
            grid_points: &self.points,
            grid_places: &self.places,
            counters,
        };
        recording.pass(claim, &bindings, &(), groups)?;
        let bindings = FillGrid {
            scene,
            restir,
            sample_data,
            grid_points: &self.points,
            grid_places: &self.places,
            grid_reservoirs: &self.reservoirs,
            counters,
        };
        recording.pass(fill, &bindings, &(), groups)
    }
}

/// Side of a cell, of which so many lie along the longest side of the box around all points.
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
