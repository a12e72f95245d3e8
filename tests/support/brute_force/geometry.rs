//! Triangles in world space, and the local axes at a point of a triangle.

use glam::{DMat3, DVec3};
use headwater::scene::Scene;

pub struct Triangle {
    pub corners: [DVec3; 3],
    /// Unit geometric normal on the front side, from which the corners appear counter-clockwise; zero for a degenerate
    /// triangle.
    pub normal: DVec3,
    /// Unit shading normals at the three corners; `None` for a flat mesh.
    pub corner_normals: Option<[DVec3; 3]>,
    pub instance: u32,
    pub triangle: u32,
    pub material: usize,
}

/// All triangles of all instances of the scene, with corners in world space.
pub fn triangles_of(scene: &Scene) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for (number, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        let to_world = instance.object_to_world;
        let normals_to_world: DMat3 = to_world.matrix3.inverse().transpose();
        for part in &mesh.parts {
            for index in part.range() {
                let corners = mesh.triangles[index as usize].map(|i| i as usize);
                let local = corners.map(|i| mesh.positions[i].as_dvec3());
                let cross = (local[1] - local[0]).cross(local[2] - local[0]);
                triangles.push(Triangle {
                    corners: local.map(|p| to_world.transform_point3(p)),
                    normal: (normals_to_world * cross.normalize_or_zero()).normalize_or_zero(),
                    corner_normals: (!mesh.normals.is_empty()).then(|| {
                        corners.map(|i| {
                            (normals_to_world * mesh.normals[i].as_dvec3()).normalize_or_zero()
                        })
                    }),
                    instance: number as u32,
                    triangle: index,
                    material: part.material as usize,
                });
            }
        }
    }
    triangles
}

impl Triangle {
    /// The intersection of a ray with the triangle as (t, u, v): ray parameter, and weights of the second and third corner.
    /// `None` for a miss. From Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
    #[inline]
    pub fn meets(&self, origin: DVec3, direction: DVec3) -> Option<(f64, f64, f64)> {
        let [a, b, c] = self.corners;
        let (edge1, edge2) = (b - a, c - a);
        let p = direction.cross(edge2);
        let determinant = edge1.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let from = origin - a;
        let u = from.dot(p) / determinant;
        if !(0.0..=1.0).contains(&u) {
            return None;
        }
        let q = from.cross(edge1);
        let v = direction.dot(q) / determinant;
        if v < 0.0 || u + v > 1.0 {
            return None;
        }
        Some((edge2.dot(q) / determinant, u, v))
    }

    /// Unit shading normal at the point with barycentric weights `u` and `v`, flipped to the side of `geometric`.
    pub fn shading_normal(&self, geometric: DVec3, u: f64, v: f64) -> DVec3 {
        let Some([a, b, c]) = self.corner_normals else {
            return geometric;
        };
        let normal = (a * (1.0 - u - v) + b * u + c * v).normalize_or(geometric);
        if normal.dot(geometric) < 0.0 {
            -normal
        } else {
            normal
        }
    }
}

/// The orthonormal axes at a shading point; the shading normal is the local +Z axis.
pub struct Frame {
    axes: DMat3,
    pub geometric: DVec3,
}

impl Frame {
    pub fn new(shading: DVec3, geometric: DVec3) -> Self {
        let (x, y) = shading.any_orthonormal_pair();
        Self {
            axes: DMat3::from_cols(x, y, shading),
            geometric,
        }
    }

    pub fn to_local(&self, world: DVec3) -> DVec3 {
        self.axes.transpose() * world
    }

    pub fn to_world(&self, local: DVec3) -> DVec3 {
        self.axes * local
    }
}
