//! Makes normals for smoothing groups (`s`). All faces of a group share one normal at each position where they meet. It is
//! the mean of their normals, weighted by the angle of each face at the position, so that it does not depend on how a
//! polygon is cut into triangles. Faces outside of groups (`s off`) are flat.

use super::building::{Building, Corner, MISSING};
use crate::scene::Scene;
use foldhash::fast::RandomState;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// The value from which [`Corner::normal`] stands for a normal of a smoothing group, so stated normals have lower indices.
pub const SMOOTH: u32 = 1 << 31;

/// The normals of the smoothing groups of a file. They are sums until the last face is read, because a group can continue
/// in later objects.
#[derive(Default)]
pub struct Smoothing {
    /// The number of the group of the faces that follow; 0 stands for no group.
    pub group: u32,
    /// Maps a group and the index of a position in the file to the index of their normal in `sums`.
    indices: HashMap<(u32, u32), u32, RandomState>,
    sums: Vec<DVec3>,
    meshes: Vec<SmoothMesh>,
}

/// A mesh of the scene with vertices whose normals come from smoothing groups.
struct SmoothMesh {
    /// The index of the mesh in the scene.
    mesh: usize,
    /// Pairs of a vertex of the mesh and its normal in [`Smoothing::sums`].
    vertices: Vec<(u32, u32)>,
    /// True if other vertices have normals from the file.
    has_stated_normals: bool,
}

impl Smoothing {
    /// Begins the group that an `s` statement names. False if `name` is neither a number nor `on` or `off`; the faces that
    /// follow are then flat.
    pub fn begin_group(&mut self, name: &str) -> bool {
        let group = match name.to_ascii_lowercase().as_str() {
            "" | "off" => Some(0),
            "on" => Some(1),
            number => number.parse().ok(),
        };
        self.group = group.unwrap_or(0);
        group.is_some()
    }

    /// The value of [`Corner::normal`] for a corner without a normal at the index `position`: [`MISSING`] outside of groups.
    pub fn normal_at(&mut self, position: u32) -> u32 {
        let next = self.sums.len() as u32;
        if self.group == 0 || next == MISSING - SMOOTH {
            return MISSING;
        }
        let index = *self
            .indices
            .entry((self.group, position))
            .or_insert_with(|| {
                self.sums.push(DVec3::ZERO);
                next
            });
        SMOOTH + index
    }

    /// Adds a face to the normals of its corners. `points` are the positions of `corners`, in their order around the face.
    pub fn add_face(&mut self, corners: &[Corner], points: &[Vec3]) {
        if self.group == 0 {
            return;
        }
        let count = points.len();
        let point = |i: usize| points[i % count].as_dvec3();
        let area_vector: DVec3 = (1..count - 1)
            .map(|i| (point(i) - point(0)).cross(point(i + 1) - point(0)))
            .sum();
        let normal = area_vector.normalize_or_zero();
        for (i, corner) in corners.iter().enumerate() {
            if let Some(sum) = index_of(corner.normal) {
                let next = point(i + 1) - point(i);
                let previous = point(i + count - 1) - point(i);
                let angle = f64::atan2(normal.dot(next.cross(previous)), next.dot(previous));
                // A corner of a concave face can have more than 180°.
                self.sums[sum as usize] += normal * angle.rem_euclid(std::f64::consts::TAU);
            }
        }
    }

    /// Notes the vertices of a finished mesh that take normals from groups; `mesh` is its index in the scene.
    pub fn finish_mesh(&mut self, mesh: usize, building: &mut Building) {
        if !building.smooth.is_empty() {
            self.meshes.push(SmoothMesh {
                mesh,
                vertices: std::mem::take(&mut building.smooth),
                has_stated_normals: building.has_stated_normals,
            });
        }
    }

    /// Sets the normals of all vertices in groups, after the last face is read. Vertices without a normal become flat, but
    /// not in a mesh with normals of the file, whose missing normals are reported later.
    pub fn finish(self, scene: &mut Scene) {
        for smooth in self.meshes {
            let mesh = &mut scene.meshes[smooth.mesh];
            for (vertex, sum) in smooth.vertices {
                let normal = self.sums[sum as usize].normalize_or_zero();
                mesh.normals[vertex as usize] = normal.as_vec3();
            }
            if !smooth.has_stated_normals {
                mesh.fill_missing_normals();
            }
        }
    }
}

/// The index of a normal among the sums, if a corner's `normal` stands for one of a smoothing group.
pub fn index_of(normal: u32) -> Option<u32> {
    (SMOOTH..MISSING).contains(&normal).then(|| normal - SMOOTH)
}
