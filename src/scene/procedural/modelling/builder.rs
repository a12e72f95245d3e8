//! Puts a scene together from shapes.

use super::shape::Shape;
use crate::scene::camera::look_at;
use crate::scene::{Camera, Instance, Material, Mesh, Part, Scene};
use glam::{DAffine3, DVec3};

/// How deep things stand in what bears them, in metres: of two faces in one plane, chance would
/// decide which is seen.
pub const SINK: f32 = 0.002;

/// Shapes gathered by material, so that many things are a few large meshes.
#[derive(Default)]
pub struct Heap(pub Vec<(Material, Shape)>);

impl Heap {
    pub fn add(&mut self, material: &Material, shape: Shape) {
        match self.0.iter_mut().find(|(m, _)| m == material) {
            Some((_, gathered)) => gathered.add(shape),
            None => self.0.push((material.clone(), shape)),
        }
    }
}

/// Puts a scene together.
#[derive(Default)]
pub struct Builder(pub Scene);

impl Builder {
    /// A mesh of one material, not yet placed.
    pub fn mesh(&mut self, material: Material, shape: Shape) -> u32 {
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
    pub fn place(&mut self, name: &str, mesh: u32, object_to_world: DAffine3) {
        self.0.instances.push(Instance {
            name: name.into(),
            mesh,
            object_to_world,
        });
    }

    /// A mesh that stands where its shape is, once.
    pub fn stand(&mut self, material: Material, shape: Shape) {
        let name = material.name.clone();
        let mesh = self.mesh(material, shape);
        self.place(&name, mesh, DAffine3::IDENTITY);
    }

    /// One mesh of many materials: boxes that overlap cost less in one tree than in many.
    pub fn stand_together(&mut self, name: &str, heap: Heap) {
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
    pub fn camera(&mut self, eye: DVec3, target: DVec3, degrees: f64, aspect: f64) {
        let camera = look_at(eye, target, degrees.to_radians());
        self.0.cameras.push(Camera {
            name: "camera".into(),
            aspect_ratio: Some(aspect),
            ..camera
        });
    }
}
