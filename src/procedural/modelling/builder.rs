//! Builders that assemble a scene from shapes, materials and models.

use super::shape::Shape;
use crate::scene::camera::look_at;
use crate::scene::{Camera, Image, Instance, Material, Mesh, Part, Scene};
use glam::{DAffine3, DVec3, Vec2, Vec3};

/// The depth in metres by which objects sink into the surface below them. Without it, two faces would lie in one plane, and
/// it would be arbitrary which one is visible.
pub const SINK: f32 = 0.002;

/// A mesh of several materials that is still being built; [`Builder::add_model`] adds it to a scene. It consists of pairs of
/// a material and one shape, which has all triangles of that material. Each pair becomes one part of the mesh. Shapes of
/// equal materials are merged, so that there are few large parts.
#[derive(Default)]
pub struct Model(pub Vec<(Material, Shape)>);

impl Model {
    pub fn add(&mut self, material: &Material, shape: Shape) {
        match self.0.iter_mut().find(|(m, _)| m == material) {
            Some((_, gathered)) => gathered.add(shape),
            None => self.0.push((material.clone(), shape)),
        }
    }
}

/// A scene that is being built step by step, with functions that add meshes, images, instances and cameras.
/// The field is the scene with all objects that were added so far; it starts empty.
#[derive(Default)]
pub struct Builder(pub Scene);

impl Builder {
    /// Adds a mesh with one part and one material, and returns the index of the mesh. [`Builder::place`] adds
    /// an instance of it, which makes it visible.
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
            ..Mesh::default()
        });
        self.0.materials.push(material);
        self.0.meshes.len() as u32 - 1
    }

    /// Gives the mesh with the index `mesh` its first set of texture coordinates, by which the textures of
    /// its material are mapped. `laid` computes the coordinates of a vertex from its position in object
    /// space, in metres.
    pub fn lay(&mut self, mesh: u32, laid: impl Fn(Vec3) -> Vec2) {
        let mesh = &mut self.0.meshes[mesh as usize];
        mesh.uvs[0] = mesh.positions.iter().map(|p| laid(*p)).collect();
    }

    /// Adds an image of `side` × `side` texels for textures, and returns its index in the scene, by which
    /// textures refer to it. `texel` returns the RGBA bytes of the texel at (column, row), counted from the
    /// top left.
    pub fn image(&mut self, name: &str, side: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> u32 {
        self.0.images.push(Image {
            name: name.into(),
            width: side,
            height: side,
            texels: (0..side * side)
                .map(|i| texel(i % side, i / side))
                .collect(),
        });
        self.0.images.len() as u32 - 1
    }

    /// Adds an instance of the mesh with the index `mesh`, so that it is visible in the scene.
    /// `object_to_world` converts positions of the mesh to world space, in metres.
    pub fn place(&mut self, name: &str, mesh: u32, object_to_world: DAffine3) {
        self.0.instances.push(Instance {
            name: name.into(),
            mesh,
            object_to_world,
        });
    }

    /// Adds a shape as a new mesh of this material, and one instance of it. The positions of the shape are in world space,
    /// in metres.
    pub fn add(&mut self, material: Material, shape: Shape) {
        let name = material.name.clone();
        let mesh = self.mesh(material, shape);
        self.place(&name, mesh, DAffine3::IDENTITY);
    }

    /// Adds a model as one mesh with a part for each material, and one instance of it without a transform. One large mesh is
    /// used because rays traverse it faster than many meshes whose bounding boxes overlap.
    pub fn add_model(&mut self, name: &str, model: Model) {
        let Model(mut shapes) = model;
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

    /// Adds a camera at `eye` that looks at `target`, both positions in metres. `degrees` is its vertical field of view, and
    /// `aspect` is the width of its picture divided by the height.
    pub fn camera(&mut self, eye: DVec3, target: DVec3, degrees: f64, aspect: f64) {
        let camera = look_at(eye, target, degrees.to_radians());
        self.0.cameras.push(Camera {
            name: "camera".into(),
            aspect_ratio: Some(aspect),
            ..camera
        });
    }
}
