//! Conversion of the surface of an implicit body (given by a signed distance function) into triangles, by dual contouring.

use super::shape::Shape;
use super::simplify::simplify;
use glam::{Mat3, Vec3};
use std::collections::HashMap;

/// The coordinates of the grid lines along one axis, in metres and in increasing order; [`surface`] takes such a list for
/// each axis. The first coordinate is `start`. Each pair (end, step) of `runs` adds coordinates from the last one so far up
/// to exactly `end`, in equal steps of about the size `step`. With several runs, regions with small details get a finer
/// grid.
pub fn ticks(start: f32, runs: &[(f32, f32)]) -> Vec<f32> {
    let mut ticks = vec![start];
    let mut from = start;
    for &(end, step) in runs {
        let count = ((end - from) / step).round().max(1.0);
        ticks.extend((1..=count as u32).map(|i| from + (end - from) * (i as f32 / count)));
        from = end;
    }
    ticks
}

/// The detail of a surface that [`surface`] makes: the number of triangles to which it is simplified, and the weights that
/// decide which regions keep more of them.
pub struct Detail<W: Fn(Vec3) -> f32> {
    /// The number of triangles to which the surface is simplified. The surface keeps more triangles if further
    /// simplification would fold it or make it non-manifold.
    pub triangles: usize,
    /// A function that takes a position in metres, in the coordinates of the body, and returns the weight of the surface
    /// there. The simplification multiplies the error of a change at this position by the weight. Regions with a higher
    /// weight keep more triangles, and a constant weight treats all regions equally.
    pub weight: W,
}

/// Triangulates the surface of `body`, a signed distance function that is negative inside. `grid` has the coordinates of
/// grid lines along x, y and z, in metres. The shape has smooth normals, and is closed if the grid encloses the body.
/// Details finer than the grid are lost.
pub fn surface<W: Fn(Vec3) -> f32>(
    grid: &[Vec<f32>; 3],
    detail: &Detail<W>,
    body: impl Fn(Vec3) -> f32,
) -> Shape {
    let (points, mut faces) = Net::new(grid, &body).surface();
    let mut points: Vec<_> = points.into_iter().map(Vec3::as_dvec3).collect();
    simplify(&mut points, &mut faces, detail.triangles, |p| {
        f64::from((detail.weight)(p.as_vec3()))
    });
    let mut corners = vec![None; points.len()];
    let corners = faces.into_iter().flatten().map(|i| {
        *corners[i].get_or_insert_with(|| {
            let p = projected(&body, points[i].as_vec3());
            (p, slope(&body, p).normalize_or_zero())
        })
    });
    let (positions, normals) = corners.unzip();
    Shape::smooth(positions, normals)
}

fn slope(body: &impl Fn(Vec3) -> f32, p: Vec3) -> Vec3 {
    const STEP: f32 = 5e-4;
    let along = |axis: Vec3| body(p + axis * STEP) - body(p - axis * STEP);
    Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)) / (2.0 * STEP)
}

/// Moves a point near the surface of the body onto the surface, along the gradient of the body's signed distance function.
/// Vertices need this because contouring and simplification place them only near the surface.
fn projected(body: &impl Fn(Vec3) -> f32, mut p: Vec3) -> Vec3 {
    for _ in 0..3 {
        let slope = slope(body, p);
        p -= slope * (body(p) / slope.length_squared().max(0.1));
    }
    p
}

/// The position of a node in a grid, as its indices (from 0) along x, y and z. It also identifies the grid
/// cell whose lowest corner is this node.
type GridIndex = [usize; 3];

/// The number of grid nodes along each side of a block. The nodes of a grid are divided into cubic blocks, which are
/// computed one after the other. If a block is far from the surface, the body's signed distance function is evaluated only
/// once for it instead of at every node, which saves time.
const BLOCK: usize = 5;
/// The assumed maximum length of the gradient of a body's signed distance function, in metres per metre. It is 1 for an
/// exact signed distance; approximate ones can change faster. It decides which blocks are far from the surface. If it were
/// too low, parts of the surface could be missed.
const MAX_SLOPE: f32 = 2.0;

/// The values of a body's signed distance function at the nodes of a grid, and the points where the body's surface crosses
/// the edges between nodes. The triangles of the surface are made from them.
struct Net<'a> {
    grid: &'a [Vec<f32>; 3],
    size: GridIndex,
    values: Vec<f32>,
    /// The points in metres where the surface crosses edges of the grid, each with the unit normal of the surface. The key
    /// is the index of the edge's lower node in `values`, and the axis of the edge (0 to 2). [`Net::corner`] places the
    /// vertices of the surface by these points.
    crossings: HashMap<(usize, usize), (Vec3, Vec3)>,
}

impl<'a> Net<'a> {
    fn new(grid: &'a [Vec<f32>; 3], body: &impl Fn(Vec3) -> f32) -> Self {
        let mut net = Self {
            grid,
            size: [0, 1, 2].map(|axis| grid[axis].len()),
            values: Vec::new(),
            crossings: HashMap::new(),
        };
        net.values = vec![0.0; net.size.iter().product()];
        for corner in net
            .grid_indices()
            .filter(|at| at.iter().all(|i| i % BLOCK == 0))
        {
            net.fill(corner, body);
        }
        for at in net.grid_indices() {
            for axis in 0..3 {
                let next = shifted(at, axis, 1);
                if !net.is_last(at, axis) && net.inside(at) != net.inside(next) {
                    let p = net.crossing(at, next, body);
                    let normal = slope(body, p).normalize_or_zero();
                    net.crossings.insert((net.index(at), axis), (p, normal));
                }
            }
        }
        net
    }

    /// Computes the values of the body's signed distance function at the nodes of one block, whose lowest node is `first`.
    /// Far from the surface, only the sign of the function matters. So if the whole block is far from the surface, all its
    /// nodes get the value at the centre of the block.
    fn fill(&mut self, first: GridIndex, body: &impl Fn(Vec3) -> f32) {
        let end = [0, 1, 2].map(|axis| (first[axis] + BLOCK).min(self.size[axis]));
        let (low, high) = (self.node(first), self.node(end.map(|i| i - 1)));
        let all = body((low + high) / 2.0);
        let is_far = all.abs() > MAX_SLOPE * (high - low).length() / 2.0;
        for k in first[2]..end[2] {
            for j in first[1]..end[1] {
                for i in first[0]..end[0] {
                    let (at, index) = ([i, j, k], self.index([i, j, k]));
                    self.values[index] = if is_far { all } else { body(self.node(at)) };
                }
            }
        }
    }

    fn grid_indices(&self) -> impl Iterator<Item = GridIndex> + use<> {
        let [width, height, depth] = self.size;
        (0..width * height * depth)
            .map(move |n| [n % width, n / width % height, n / width / height])
    }

    fn index(&self, [i, j, k]: GridIndex) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }

    fn node(&self, [i, j, k]: GridIndex) -> Vec3 {
        Vec3::new(self.grid[0][i], self.grid[1][j], self.grid[2][k])
    }

    fn value(&self, at: GridIndex) -> f32 {
        self.values[self.index(at)]
    }

    fn inside(&self, at: GridIndex) -> bool {
        self.value(at) < 0.0
    }

    /// True if the node is the last one of the grid along the axis (0 to 2). Then no edge and no cell of the grid begins at
    /// it.
    fn is_last(&self, at: GridIndex, axis: usize) -> bool {
        at[axis] + 1 == self.size[axis]
    }

    /// The position of the surface's vertex in a cell of the grid, in metres; `None` if the surface does not cross the cell.
    /// Each edge of the cell that the surface crosses has a tangent plane of the surface at the crossing. The vertex is
    /// close to all these planes, so that sharp edges of the body are kept.
    fn corner(&self, cell: GridIndex) -> Option<Vec3> {
        if (0..3).any(|axis| self.is_last(cell, axis)) {
            return None;
        }
        let around = |corner: usize| [0, 1, 2].map(|axis| cell[axis] + (corner >> axis & 1));
        if (1..8).all(|corner| self.inside(around(corner)) == self.inside(cell)) {
            return None;
        }
        let (mut middle, mut crossings) = (Vec3::ZERO, Vec::new());
        for corner in 0..8_usize {
            let a = around(corner);
            for axis in (0..3).filter(|axis| corner >> axis & 1 == 0) {
                if let Some(&(p, n)) = self.crossings.get(&(self.index(a), axis)) {
                    middle += p;
                    crossings.push((p, n));
                }
            }
        }
        middle /= crossings.len() as f32;
        // The point closest to the planes at the crossings, regularised towards their mean.
        let mut planes = Mat3::from_diagonal(Vec3::splat(0.03 * crossings.len() as f32));
        let mut pull = Vec3::ZERO;
        for (p, n) in crossings {
            planes += Mat3::from_cols(n * n.x, n * n.y, n * n.z);
            pull += n * n.dot(p - middle);
        }
        let (low, high) = (self.node(cell), self.node(cell.map(|i| i + 1)));
        // Kept off the cell's faces: equal vertices of two cells would give triangles without area.
        let rim = (high - low) * 0.03;
        let p = middle + planes.inverse() * pull;
        Some(p.clamp(low + rim, high - rim))
    }

    /// The point, in metres, where the surface crosses the edge between two neighbouring nodes, of which one is inside the
    /// body. It is found by repeated linear interpolation of the body's signed distance function.
    fn crossing(&self, a: GridIndex, b: GridIndex, body: &impl Fn(Vec3) -> f32) -> Vec3 {
        let (mut from, mut to) = ((self.node(a), self.value(a)), (self.node(b), self.value(b)));
        for _ in 0..3 {
            let p = from.0.lerp(to.0, from.1 / (from.1 - to.1));
            let value = body(p);
            if (value < 0.0) == (from.1 < 0.0) {
                from = (p, value);
            } else {
                to = (p, value);
            }
        }
        from.0.lerp(to.0, from.1 / (from.1 - to.1))
    }

    /// Makes the surface by dual contouring (Ju et al. 2002): places a vertex in every cell that the surface
    /// crosses, and a quad across every edge that the surface crosses. Unlike marching cubes, this preserves
    /// sharp edges. Returns the vertices in metres, and the triangles as indices of vertices.
    fn surface(&self) -> (Vec<Vec3>, Vec<GridIndex>) {
        let mut points = Vec::new();
        let corners: Vec<usize> = self
            .grid_indices()
            .map(|cell| {
                points.extend(self.corner(cell));
                points.len().wrapping_sub(1)
            })
            .collect();
        let mut faces = Vec::new();
        for at in self.grid_indices() {
            for axis in 0..3 {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                if self.is_last(at, axis) || at[u] == 0 || at[v] == 0 {
                    continue;
                }
                let leaves = self.inside(at);
                if leaves == self.inside(shifted(at, axis, 1)) {
                    continue;
                }
                // The four cells around the edge, counter-clockwise seen from its far end.
                let back = shifted(at, u, -1);
                let around = [shifted(back, v, -1), shifted(at, v, -1), at, back];
                let [a, b, c, d] = around.map(|cell| corners[self.index(cell)]);
                let apart = |i: usize, j: usize| points[i].distance_squared(points[j]);
                let halves = if apart(a, c) < apart(b, d) {
                    [[a, b, c], [a, c, d]]
                } else {
                    [[a, b, d], [b, c, d]]
                };
                faces.extend(halves.map(|[i, j, k]| if leaves { [i, j, k] } else { [k, j, i] }));
            }
        }
        (points, faces)
    }
}

fn shifted(mut at: GridIndex, axis: usize, by: isize) -> GridIndex {
    at[axis] = at[axis].wrapping_add_signed(by);
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_is_closed_and_faces_outwards() {
        let lines = ticks(-1.2, &[(0.0, 0.2), (1.2, 0.1)]);
        let grid = [lines.clone(), lines.clone(), lines];
        for triangles in [usize::MAX, 300] {
            let weight = |_| 1.0;
            let shape = surface(&grid, &Detail { triangles, weight }, |p| p.length() - 1.0);
            let volume = shape.signed_volume() / 6.0;
            assert!((volume - 4.19).abs() < 0.25, "{volume}");
            assert!(shape.is_closed());
            assert!(shape.triangle_count() <= triangles);
        }
    }

    #[test]
    fn ticks_end_where_they_should() {
        assert_eq!(ticks(0.0, &[(1.0, 0.5), (2.0, 0.9)]), [0.0, 0.5, 1.0, 2.0]);
    }
}
