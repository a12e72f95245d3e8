//! The hash grid: reservoirs of direct light at points of surfaces, and the passes that make and merge them.

use super::reuse::FrameInputs;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::layouts::{GpuGridPoint, GridConstants, TILE};
use crate::render::kind::Kind;
use crate::render::passes::{FillGrid, MarkGrid, MergeGrid};
use crate::render::reservoir_layout::ReservoirLayout;
use crate::render::settings::{Candidates, GridMode, HashGridSettings, Settings};
use crate::tracing::GpuScene;
use crate::tracing::hash_grid::{HashGrid, HashGridOptions};
use crate::{Error, Result};
use std::sync::Arc;

/// Points on surfaces from which the grid's are chosen.
const SURFACE_POINTS: usize = 1 << 19;

/// The passes and buffers.
pub struct HashGridLight {
    mark: ComputePass,
    fill: ComputePass,
    merge: ComputePass,
    cells: Buffer,
    points: Buffer,
    /// For each slot the last frame that wanted its cell, counted from 1.
    wanted: Buffer,
    reservoirs: Buffer,
    /// What the shaders need to know of it.
    pub constants: GridConstants,
    until_frame: u32,
}

impl HashGridLight {
    /// Makes what `settings` need, if they ask for it; `pass` makes a pass by name.
    ///
    /// # Errors
    /// A grid that the device cannot bind, or more memory than it has.
    pub fn new(
        device: &Arc<Device>,
        scene: &GpuScene,
        settings: &Settings,
        layout: &ReservoirLayout,
        pass: impl Fn(&str) -> Result<ComputePass>,
    ) -> Result<Option<Self>> {
        if settings.direct.resampling.candidates != Candidates::HashGrid {
            return Ok(None);
        }
        let grid = HashGrid::new(
            &scene.surface_points(SURFACE_POINTS)?,
            settings.hash_grid.options(),
        );
        // An empty scene has no points, but a buffer is never empty.
        let count = grid.points.len().max(1) as u64;
        let sizes = [
            ("grid_cells", size_of_val(grid.table.as_slice()) as u64),
            ("grid_points", count * size_of::<GpuGridPoint>() as u64),
            ("grid_reservoirs", count * layout.bytes(Kind::Direct)),
        ];
        let limit = device
            .info
            .max_storage_buffer_range
            .min(device.info.max_buffer_size);
        if let Some((name, bytes)) = sizes.iter().find(|(_, bytes)| *bytes > limit) {
            return Err(Error::input(format!(
                "the hash grid needs {bytes} bytes for its {name}, but device '{}' binds at most {limit}; lower hash_grid.reservoirs or hash_grid.cells",
                device.info.name
            )));
        }
        log::info!(
            "hash grid: {} points in {} cells",
            grid.points.len(),
            grid.occupied()
        );
        let HashGridSettings {
            mode,
            cells,
            bins,
            candidates,
            merged,
            confidence,
            refresh,
            until_frame,
            ..
        } = settings.hash_grid;
        let buffer = |name, bytes| Buffer::new(device, name, bytes, Usage::default());
        let points = match grid.points.is_empty() {
            true => &[GpuGridPoint::default()],
            false => grid.points.as_slice(),
        };
        Ok(Some(Self {
            mark: pass("grid_mark")?,
            fill: pass("grid_fill")?,
            merge: pass("grid_direct")?,
            cells: Buffer::from_slice(device, "grid_cells", &grid.table, Usage::default())?,
            points: Buffer::from_slice(device, "grid_points", points, Usage::default())?,
            wanted: buffer("grid_wanted", (grid.table.len() * size_of::<u32>()) as u64)?,
            reservoirs: buffer("grid_reservoirs", sizes[2].1)?,
            constants: GridConstants {
                low: grid.low,
                cell: grid.cell,
                cells,
                bins,
                slots: grid.table.len() as u32,
                points: grid.points.len() as u32,
                candidates,
                merged,
                confidence: match mode {
                    GridMode::Unbiased => confidence as f32,
                    GridMode::Published => (candidates as f32
                        / settings.direct.resampling.light_samples as f32)
                        .max(1.0),
                },
                // Lights may have moved or changed since.
                refresh: if scene.moves() { 1 } else { refresh },
                mixes_points: (mode == GridMode::Published).into(),
            },
            until_frame: match until_frame {
                0 => u32::MAX,
                frame => frame,
            },
        }))
    }

    /// The buffers that begin empty.
    pub fn emptied(&self) -> [&Buffer; 2] {
        [&self.wanted, &self.reservoirs]
    }

    /// Records the passes of a frame.
    ///
    /// # Errors
    /// A binding that a pass does not have.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        restir: &'a Buffer,
        reservoirs: &'a Buffer,
        frame: u32,
    ) -> Result<()> {
        if frame >= self.until_frame || self.constants.points == 0 {
            return Ok(());
        }
        let FrameInputs {
            scene,
            sample_data,
            counters,
            groups,
            ..
        } = *inputs;
        let mark = MarkGrid {
            scene,
            restir,
            sample_data,
            grid_cells: &self.cells,
            grid_wanted: &self.wanted,
        };
        recording.pass(&self.mark, &mark, &(), groups)?;
        let fill = FillGrid {
            scene,
            restir,
            grid_cells: &self.cells,
            grid_points: &self.points,
            grid_wanted: &self.wanted,
            grid_reservoirs: &self.reservoirs,
            counters,
        };
        let points = self.constants.points.div_ceil(TILE * TILE);
        // One dimension holds at least 65,535 groups everywhere; more go into rows.
        let rows = points.div_ceil(32768);
        recording.pass(&self.fill, &fill, &(), [points.div_ceil(rows), rows, 1])?;
        let merge = MergeGrid {
            scene,
            restir,
            sample_data,
            grid_cells: &self.cells,
            grid_points: &self.points,
            grid_reservoirs: &self.reservoirs,
            reservoirs,
            counters,
        };
        recording.pass(&self.merge, &merge, &(), groups)
    }
}

impl HashGridSettings {
    /// How the grid is built.
    fn options(&self) -> HashGridOptions {
        HashGridOptions {
            cells: self.cells,
            bins: self.bins,
            reservoirs: self.reservoirs,
        }
    }
}
