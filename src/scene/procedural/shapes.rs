//! Shapes, and a scene that is put together from them.

use crate::scene::camera::look_at;
use crate::scene::{Camera, Instance, Material, Mesh, Part, Scene};
use glam::{DAffine3, DVec3, Mat3, Vec3};

/// How deep things stand in what bears them, in metres: of two faces in one plane, chance would
/// decide which is seen.
pub(super) const SINK: f32 = 0.002;

/// Triangles that share no corners; flat unless they come with normals.
#[derive(Clone, Default)]
pub(super) struct Shape {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl Shape {
    /// A flat triangle.
    pub(super) fn triangle(corners: [Vec3; 3]) -> Self {
        Self {
            positions: corners.to_vec(),
            normals: Vec::new(),
        }
    }

    /// A parallelogram; its front is the side of u × v.
    pub(super) fn quad(corner: Vec3, u: Vec3, v: Vec3) -> Self {
        let [a, b, c, d] = [corner, corner + u, corner + u + v, corner + v];
        Self {
            positions: vec![a, b, c, a, c, d],
            normals: Vec::new(),
        }
    }

    /// A box between two corners, faces outwards.
    pub(super) fn block(low: Vec3, high: Vec3) -> Self {
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

    /// A sphere of unit radius around the origin: an icosahedron whose faces are split
    /// `subdivisions` times, with smooth normals.
    pub(super) fn sphere(subdivisions: u32) -> Self {
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

    /// Flat triangles, three corners each.
    pub(super) fn triangles(corners: &[Vec3]) -> Self {
        Self {
            positions: corners.to_vec(),
            normals: Vec::new(),
        }
    }

    /// An upright cylinder with caps, flat sides.
    pub(super) fn cylinder(foot: Vec3, radius: f32, height: f32, sides: u32) -> Self {
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

    /// Triangles with a normal at each corner.
    pub(super) fn smooth(positions: Vec<Vec3>, normals: Vec<Vec3>) -> Self {
        Self { positions, normals }
    }

    /// A box by its middle and size.
    pub(super) fn chunk(middle: Vec3, size: Vec3) -> Self {
        Self::block(middle - size / 2.0, middle + size / 2.0)
    }

    /// Adds another shape's triangles; smooth and flat ones keep their looks.
    pub(super) fn add(&mut self, mut other: Self) {
        if self.normals.is_empty() != other.normals.is_empty() {
            self.fill_normals();
            other.fill_normals();
        }
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
    }

    /// Gives flat triangles their own normals, as a mesh has normals everywhere or nowhere.
    fn fill_normals(&mut self) {
        if self.normals.is_empty() {
            let faces = self.positions.chunks_exact(3);
            let normal = |f: &[Vec3]| (f[1] - f[0]).cross(f[2] - f[0]).normalize_or_zero();
            self.normals = faces.flat_map(|f| [normal(f); 3]).collect();
        }
    }

    /// The shape without smooth normals.
    pub(super) fn flat(mut self) -> Self {
        self.normals.clear();
        self
    }

    /// The shape seen from the other side.
    pub(super) fn inside_out(mut self) -> Self {
        for triangle in self.positions.chunks_exact_mut(3) {
            triangle.swap(1, 2);
        }
        self.normals.clear();
        self
    }

    /// The shape moved by a function of its points that does not mirror; where it is smooth, its
    /// normals follow the function's slope.
    pub(super) fn map(mut self, f: impl Fn(Vec3) -> Vec3) -> Self {
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

    /// Number of triangles.
    pub(super) fn triangle_count(&self) -> usize {
        self.positions.len() / 3
    }

    /// Whether every edge is run through as often one way as the other.
    #[cfg(test)]
    pub(super) fn is_closed(&self) -> bool {
        let mut runs = std::collections::HashMap::new();
        for face in self.positions.chunks_exact(3) {
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let [a, b] = [a, b].map(|i: usize| (face[i] + 0.0).to_array().map(f32::to_bits));
                *runs.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
            }
        }
        runs.values().all(|&sum| sum == 0)
    }

    /// The sum of the triangles' areas.
    #[cfg(test)]
    pub(super) fn area(&self) -> f32 {
        let faces = self.positions.chunks_exact(3);
        faces
            .map(|f| (f[1] - f[0]).cross(f[2] - f[0]).length() / 2.0)
            .sum()
    }

    /// Six times the enclosed volume, positive if faces look outwards.
    #[cfg(test)]
    pub(super) fn signed_volume(&self) -> f32 {
        let faces = self.positions.chunks_exact(3);
        faces.map(|f| f[0].dot(f[1].cross(f[2]))).sum()
    }
}

/// Shapes gathered by material, so that many things are a few large meshes.
#[derive(Default)]
pub(super) struct Heap(pub(super) Vec<(Material, Shape)>);

impl Heap {
    pub(super) fn add(&mut self, material: &Material, shape: Shape) {
        match self.0.iter_mut().find(|(m, _)| m == material) {
            Some((_, gathered)) => gathered.add(shape),
            None => self.0.push((material.clone(), shape)),
        }
    }
}

/// Puts a scene together.
#[derive(Default)]
pub(super) struct Builder(pub(super) Scene);

impl Builder {
    /// A mesh of one material, not yet placed.
    pub(super) fn mesh(&mut self, material: Material, shape: Shape) -> u32 {
        let triangles = (shape.positions.len() / 3) as u32;
        self.0.meshes.push(Mesh {
            name: material.name.clone(),
            triangles: (0..triangles)
                .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
                .collect(),
            positions: shape.positions,
            normals: shape.normals,
            parts: vec![Part {
                first_triangle: 0,
                triangle_count: triangles,
                material: self.0.materials.len() as u32,
            }],
        });
        self.0.materials.push(material);
        self.0.meshes.len() as u32 - 1
    }

    /// Places a mesh.
    pub(super) fn place(&mut self, name: &str, mesh: u32, object_to_world: DAffine3) {
        self.0.instances.push(Instance {
            name: name.into(),
            mesh,
            object_to_world,
        });
    }

    /// A mesh that stands where its shape is, once.
    pub(super) fn stand(&mut self, material: Material, shape: Shape) {
        let name = material.name.clone();
        let mesh = self.mesh(material, shape);
        self.place(&name, mesh, DAffine3::IDENTITY);
    }

    /// One mesh of many materials: boxes that overlap cost less in one tree than in many.
    pub(super) fn stand_together(&mut self, name: &str, heap: Heap) {
        let Heap(mut shapes) = heap;
        if shapes.iter().any(|(_, shape)| !shape.normals.is_empty()) {
            shapes
                .iter_mut()
                .for_each(|(_, shape)| shape.fill_normals());
        }
        let mut mesh = Mesh {
            name: name.into(),
            ..Mesh::default()
        };
        for (material, shape) in shapes {
            let first = mesh.triangles.len() as u32;
            let corners = mesh.positions.len() as u32;
            let count = shape.positions.len() as u32 / 3;
            mesh.triangles
                .extend((0..count).map(|t| [0, 1, 2].map(|i| corners + 3 * t + i)));
            mesh.positions.extend(shape.positions);
            mesh.normals.extend(shape.normals);
            mesh.parts.push(Part {
                first_triangle: first,
                triangle_count: count,
                material: self.0.materials.len() as u32,
            });
            self.0.materials.push(material);
        }
        self.0.meshes.push(mesh);
        self.place(name, self.0.meshes.len() as u32 - 1, DAffine3::IDENTITY);
    }

    /// The camera; the field of view is vertical, in degrees.
    pub(super) fn camera(&mut self, eye: DVec3, target: DVec3, degrees: f64, aspect: f64) {
        let camera = look_at(eye, target, degrees.to_radians());
        self.0.cameras.push(Camera {
            name: "camera".into(),
            aspect_ratio: Some(aspect),
            ..camera
        });
    }
}

/// A glossy surface without metal.
pub(super) fn dielectric(name: &str, color: Vec3, roughness: f32) -> Material {
    Material {
        name: name.into(),
        base_color: color,
        metallic: 0.0,
        roughness,
        ..Material::default()
    }
}

/// A metal.
pub(super) fn metal(name: &str, color: Vec3, roughness: f32) -> Material {
    Material {
        name: name.into(),
        base_color: color,
        roughness,
        ..Material::default()
    }
}

/// A lamp: emits, and reflects as a grey wall does.
pub(super) fn lamp(name: &str, radiance: Vec3) -> Material {
    Material {
        emission: radiance,
        ..Material::lambert(name, Vec3::splat(0.5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_shapes_look_outwards_and_have_their_triangles() {
        assert!(Shape::block(-Vec3::ONE, Vec3::ONE).signed_volume() > 0.0);
        assert!(Shape::cylinder(Vec3::ZERO, 1.0, 2.0, 7).signed_volume() > 0.0);
        let sphere = Shape::sphere(2);
        assert_eq!(sphere.triangle_count(), 20 * 16);
        let volume = sphere.signed_volume() / 6.0;
        assert!((volume - 4.19).abs() < 0.2, "{volume}");
        assert!(sphere.inside_out().signed_volume() < 0.0);
    }
}
