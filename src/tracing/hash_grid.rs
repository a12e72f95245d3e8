//! The hash grid: which points of surfaces keep reservoirs of direct light for the pixels around them ("Normal-aware hash grid
//! of precomputed reservoirs", 2025).
//!
//! Space is divided into cells, and each cell by the direction of normals into bins. Points on the scene's surfaces, uniform
//! by area and on both sides, are gathered by cell and bin; a hash table finds them. What the reservoirs of the points hold is
//! made on the device.

use super::geometry::pack_octahedral;
use super::surface_points::SurfacePoint;
use crate::layouts::{GpuGridCell, GpuGridPoint, NONE};
use crate::random::Random;
use glam::Vec3;

/// How a hash grid is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HashGridOptions {
    /// Cells along the longest side of the box around all points.
    pub cells: u32,
    /// Bins of normals along each side of the octahedral map.
    pub bins: u32,
    /// Maximum number of points of a cell's bin.
    pub reservoirs: u32,
}

/// Points of surfaces, and a hash table that finds them by cell and bin.
#[derive(Clone, Debug, PartialEq)]
pub struct HashGrid {
    /// The smallest coordinates.
    pub low: Vec3,
    /// Side of a cell.
    pub cell: f32,
    /// The table; its length is a power of two.
    pub table: Vec<GpuGridCell>,
    /// The points, cell by cell.
    pub points: Vec<GpuGridPoint>,
}

impl HashGrid {
    /// Number of cells and bins that hold points.
    pub fn occupied(&self) -> usize {
        self.table.iter().filter(|cell| cell.key != NONE).count()
    }

    /// Gathers points.
    pub fn new(surfaces: &[SurfacePoint], options: HashGridOptions) -> Self {
        let positions = surfaces.iter().map(|point| point.position);
        let low = positions.clone().reduce(Vec3::min).unwrap_or_default();
        let high = positions.reduce(Vec3::max).unwrap_or_default();
        let side = (high - low).max_element();
        // Larger by a hundredth, so that no point lies on the border.
        let cell = if side > 0.0 { 1.01 * side } else { 1.0 } / options.cells as f32;
        let low = 0.5 * (low + high) - 0.5 * cell * options.cells as f32;

        // Those of a cell in random order, of which the first ones stay.
        let mut random = Random::new(1);
        let mut keyed: Vec<(u32, u32, SurfacePoint)> = (surfaces.iter())
            .flat_map(|point| [1.0, -1.0].map(|side| (point, side)))
            .map(|(point, side)| {
                let normal = side * point.normal;
                let key = key((point.position - low) / cell, normal, options.bins);
                (key, random.bits(), SurfacePoint { normal, ..*point })
            })
            .collect();
        keyed.sort_by_key(|(key, order, _)| (*key, *order));

        let count = keyed.chunk_by(|a, b| a.0 == b.0).count();
        let mut table = vec![
            GpuGridCell {
                key: NONE,
                ..GpuGridCell::default()
            };
            (2 * count).next_power_of_two()
        ];
        let mut points = Vec::new();
        for members in keyed.chunk_by(|a, b| a.0 == b.0) {
            let key = members[0].0;
            let mask = table.len() - 1;
            let mut slot = hash(key) as usize & mask;
            while table[slot].key != NONE {
                slot = (slot + 1) & mask;
            }
            let kept = &members[..members.len().min(options.reservoirs as usize)];
            table[slot] = GpuGridCell {
                key,
                first: points.len() as u32,
                count: kept.len() as u32,
                padding: 0,
            };
            points.extend(kept.iter().map(|(_, _, point)| GpuGridPoint {
                position: point.position,
                normal: pack_octahedral(point.normal),
                slot: slot as u32,
            }));
        }
        Self {
            low,
            cell,
            table,
            points,
        }
    }
}

/// The number of a cell and bin, for a position in cells. `glsl/lights/hash_grid.glsl` has the same.
fn key(at: Vec3, normal: Vec3, bins: u32) -> u32 {
    let cell = at.as_uvec3();
    let sum = normal.abs().element_sum();
    let (x, y) = (normal.x / sum, normal.y / sum);
    let side = |value: f32| if value >= 0.0 { 1.0 } else { -1.0 };
    let folded = match normal.z < 0.0 {
        true => [(1.0 - y.abs()) * side(x), (1.0 - x.abs()) * side(y)],
        false => [x, y],
    };
    let [u, v] = folded.map(|e| (((0.5 * e + 0.5) * bins as f32) as u32).min(bins - 1));
    cell.x | cell.y << 8 | cell.z << 16 | (v * bins + u) << 24
}

/// Where the search for a key begins. `glsl/lights/hash_grid.glsl` has the same.
fn hash(key: u32) -> u32 {
    let bits = (key ^ key >> 16).wrapping_mul(0x7FEB_352D);
    let bits = (bits ^ bits >> 15).wrapping_mul(0x846C_A68B);
    bits ^ bits >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points all over a square that faces up.
    fn floor(count: usize) -> Vec<SurfacePoint> {
        let mut random = Random::new(5);
        (0..count)
            .map(|_| SurfacePoint {
                position: Vec3::new(random.unit(), 0.0, random.unit()) * 1e6,
                normal: Vec3::Y,
            })
            .collect()
    }

    #[test]
    fn every_cell_keeps_as_many_points_as_asked_for() {
        let options = HashGridOptions {
            cells: 16,
            bins: 8,
            reservoirs: 10,
        };
        let grid = HashGrid::new(&floor(100_000), options);
        let used = |cell: &&GpuGridCell| cell.key != NONE;
        assert_eq!(grid.occupied(), 2 * 16 * 16);
        assert!(grid.table.iter().filter(used).all(|cell| cell.count == 10));
        for (index, point) in (0..).zip(&grid.points) {
            let cell = &grid.table[point.slot as usize];
            assert!((cell.first..cell.first + cell.count).contains(&index));
        }
    }

    #[test]
    fn a_scene_without_surfaces_has_no_points() {
        let options = HashGridOptions {
            cells: 16,
            bins: 1,
            reservoirs: 10,
        };
        let grid = HashGrid::new(&[], options);
        assert_eq!((grid.points.len(), grid.table.len()), (0, 1));
    }
}
