//! Shapes of triangles, in metres, from which procedural scenes are built.

use glam::{Mat3, Vec3};

/// Triangles without shared vertices: three positions per triangle, in metres. There are either as many unit normals as
/// positions, or none; a shape without normals is shaded flat. Together with a material, a shape becomes a mesh or a part of
/// one.
#[derive(Clone, Default)]
pub struct Shape {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
}

impl Shape {
    /// One flat triangle with the three `corners`, in metres. Its front is the side from which they appear in
    /// counter-clockwise order.
    pub fn triangle(corners: [Vec3; 3]) -> Self {
        Self {
            positions: corners.to_vec(),
            normals: Vec::new(),
        }
    }

    /// A flat parallelogram of two triangles, such as a wall or a lamp. `u` and `v` are its edges that start
    /// at `corner`, in metres. Its front faces the direction u × v.
    pub fn quad(corner: Vec3, u: Vec3, v: Vec3) -> Self {
        let [a, b, c, d] = [corner, corner + u, corner + u + v, corner + v];
        Self {
            positions: vec![a, b, c, a, c, d],
            normals: Vec::new(),
        }
    }

    /// An axis-aligned box of twelve triangles between its lowest and its highest corner, in metres. Its
    /// faces point outwards.
    pub fn block(low: Vec3, high: Vec3) -> Self {
        let size = high - low;
        let mut shape = Self::default();
        for axis in 0..3 {
            let u = Vec3::AXES[(axis + 1) % 3] * size;
            let v = Vec3::AXES[(axis + 2) % 3] * size;
            let across = Vec3::AXES[axis] * size;
            shape.add(Self::quad(low + across, u, v));
            shape.add(Self::quad(low, v, u));
        }
        shape
    }

    /// A sphere of radius 1 around the origin, with smooth normals. It is an icosahedron whose triangles are
    /// divided into four, `subdivisions` times, so it has 20 × 4^`subdivisions` triangles.
    pub fn sphere(subdivisions: u32) -> Self {
        let g = (1.0 + 5_f32.sqrt()) / 2.0;
        let mut points = Vec::new();
        for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
            points.extend([
                Vec3::new(0.0, a, b),
                Vec3::new(a, b, 0.0),
                Vec3::new(b, 0.0, a),
            ]);
        }
        let points: Vec<Vec3> = points.into_iter().map(Vec3::normalize).collect();
        // Its faces are the triples of mutual neighbours, turned outwards.
        let near = |a: Vec3, b: Vec3| (a - b).length() < 1.06;
        let mut faces = Vec::new();
        for (i, &a) in points.iter().enumerate() {
            for (j, &b) in points.iter().enumerate().skip(i + 1) {
                for &c in &points[j + 1..] {
                    if near(a, b) && near(b, c) && near(a, c) {
                        let outwards = (b - a).cross(c - a).dot(a) > 0.0;
                        faces.push(if outwards { [a, b, c] } else { [a, c, b] });
                    }
                }
            }
        }
        for _ in 0..subdivisions {
            faces = faces
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let middle = |p: Vec3, q: Vec3| (p + q).normalize();
                    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        let positions: Vec<Vec3> = faces.into_iter().flatten().collect();
        Self {
            normals: positions.clone(),
            positions,
        }
    }

    /// Flat triangles from a list of their corners, in metres: three successive positions per triangle,
    /// counter-clockwise seen from the front.
    pub fn triangles(corners: &[Vec3]) -> Self {
        Self {
            positions: corners.to_vec(),
            normals: Vec::new(),
        }
    }

    /// An upright cylinder with caps and `sides` flat sides. `foot` is the centre of its lower end, from
    /// which it rises `height` along +Y; `radius` is the radius of its corners. All lengths are in metres.
    pub fn cylinder(foot: Vec3, radius: f32, height: f32, sides: u32) -> Self {
        let rim = |i: u32| {
            let turn = std::f32::consts::TAU * (i % sides) as f32 / sides as f32;
            foot + radius * Vec3::new(turn.cos(), 0.0, turn.sin())
        };
        let up = Vec3::Y * height;
        let mut shape = Self::default();
        for i in 0..sides {
            let (a, b) = (rim(i), rim(i + 1));
            shape.positions.extend([b, a, a + up, b, a + up, b + up]);
            shape
                .positions
                .extend([foot + up, b + up, a + up, foot, a, b]);
        }
        shape
    }

    /// A shape of triangles that are shaded smoothly. `positions` (in metres) and `normals` (unit vectors)
    /// have the same length, with three successive entries per triangle.
    pub fn smooth(positions: Vec<Vec3>, normals: Vec<Vec3>) -> Self {
        Self { positions, normals }
    }

    /// An axis-aligned box of twelve triangles. `middle` is its centre, and `size` has its lengths along x, y
    /// and z, in metres. Its faces point outwards.
    pub fn chunk(middle: Vec3, size: Vec3) -> Self {
        Self::block(middle - size / 2.0, middle + size / 2.0)
    }

    /// Adds the triangles of another shape to this one. If only one of the two has normals, the other gets the geometric
    /// normals of its triangles, so that it still looks flat.
    pub fn add(&mut self, mut other: Self) {
        if self.normals.is_empty() != other.normals.is_empty() {
            self.fill_normals();
            other.fill_normals();
        }
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
    }

    /// Gives a shape without normals the geometric normals of its triangles; a shape with normals is not changed. It is
    /// called before a shape is joined with another one that has normals, because a mesh has normals at all vertices or at
    /// none.
    pub(super) fn fill_normals(&mut self) {
        if self.normals.is_empty() {
            let faces = self.positions.chunks_exact(3);
            let normal = |f: &[Vec3]| (f[1] - f[0]).cross(f[2] - f[0]).normalize_or_zero();
            self.normals = faces.flat_map(|f| [normal(f); 3]).collect();
        }
    }

    /// The shape without its smooth normals, so that its triangles are shaded flat and the edges between them
    /// are visible.
    pub fn flat(mut self) -> Self {
        self.normals.clear();
        self
    }

    /// The shape with the front and the back of each triangle exchanged, for example to turn a box into a
    /// room that is seen from inside. The result has no normals: it is shaded flat, even if the shape was
    /// smooth.
    pub fn inside_out(mut self) -> Self {
        for triangle in self.positions.chunks_exact_mut(3) {
            triangle.swap(1, 2);
        }
        self.normals.clear();
        self
    }

    /// The shape with every position p replaced by `f`(p), for example to move, scale or bend it. The normals
    /// follow: they are multiplied by the inverse transpose of the derivative of `f`. `f` must not mirror,
    /// because that would exchange front and back.
    pub fn map(mut self, f: impl Fn(Vec3) -> Vec3) -> Self {
        for (normal, &p) in self.normals.iter_mut().zip(&self.positions) {
            const STEP: f32 = 1e-3;
            let slope = |axis| (f(p + axis * STEP) - f(p - axis * STEP)) / (2.0 * STEP);
            let slopes = Mat3::from_cols(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z));
            *normal = (slopes.inverse().transpose() * *normal).normalize();
        }
        for p in &mut self.positions {
            *p = f(*p);
        }
        self
    }

    /// The number of triangles of the shape. For an emissive shape, this is the number of lights that it adds
    /// to a scene.
    pub fn triangle_count(&self) -> usize {
        self.positions.len() / 3
    }

    /// True if every edge of the triangles occurs equally often in both directions. On a closed surface this is so, because
    /// each edge belongs to two triangles. Tests check with it that bodies have no holes.
    #[cfg(test)]
    pub fn is_closed(&self) -> bool {
        let mut runs = std::collections::HashMap::new();
        for face in self.positions.chunks_exact(3) {
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let [a, b] = [a, b].map(|i: usize| (face[i] + 0.0).to_array().map(f32::to_bits));
                *runs.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
            }
        }
        runs.values().all(|&sum| sum == 0)
    }

    /// The sum of the areas of all triangles, in square metres. Tests check with it that a shape covers the
    /// expected area.
    #[cfg(test)]
    pub fn area(&self) -> f32 {
        let faces = self.positions.chunks_exact(3);
        faces
            .map(|f| (f[1] - f[0]).cross(f[2] - f[0]).length() / 2.0)
            .sum()
    }

    /// Six times the volume that a closed shape encloses, in cubic metres. It is positive if the faces point outwards, and
    /// negative if they point inwards. Tests check the volume and the direction of the faces with it.
    #[cfg(test)]
    pub fn signed_volume(&self) -> f32 {
        let faces = self.positions.chunks_exact(3);
        faces.map(|f| f[0].dot(f[1].cross(f[2]))).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_shapes_face_outwards_and_have_their_triangles() {
        assert!(Shape::block(-Vec3::ONE, Vec3::ONE).signed_volume() > 0.0);
        assert!(Shape::cylinder(Vec3::ZERO, 1.0, 2.0, 7).signed_volume() > 0.0);
        let sphere = Shape::sphere(2);
        assert_eq!(sphere.triangle_count(), 20 * 16);
        let volume = sphere.signed_volume() / 6.0;
        assert!((volume - 4.19).abs() < 0.2, "{volume}");
        assert!(sphere.inside_out().signed_volume() < 0.0);
    }
}
