//! Builds the meshes of an OBJ file from its faces, one mesh at a time. Corners of faces become vertices, and faces with the
//! same material become one part of the mesh.

use super::colors::VertexColors;
use super::smoothing;
use crate::scene::{Mesh, Part};
use foldhash::fast::RandomState;
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// The value of [`Corner::normal`] for a corner without a normal, and of [`Corner::coordinates`] for a corner without
/// texture coordinates.
pub const MISSING: u32 = u32::MAX;

/// A corner of a face: indices, from 0, into the positions, normals and texture coordinates of the whole file. Equal corners
/// of a mesh become one vertex. A corner without a normal in a smoothing group has as `normal` [`super::smoothing::SMOOTH`] plus the index of a
/// sum in [`super::smoothing::Smoothing`]. `normal` and `coordinates` are [`MISSING`] if the face does not state them. `coordinates` is
/// also [`MISSING`] if the face's material has no textures, so that corners which differ only in unused texture coordinates
/// share a vertex.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Corner {
    pub position: u32,
    pub normal: u32,
    pub coordinates: u32,
}

/// The attributes of the vertices of the whole file, into which corners have indices.
#[derive(Default)]
pub struct Attributes {
    pub normals: Vec<Vec3>,
    pub coordinates: Vec<Vec2>,
    pub colors: VertexColors,
}

/// The mesh that is built from the faces since the last `o` or `g` statement, or since the start of the file. The next such
/// statement, or the end of the file, adds the mesh to the scene.
#[derive(Default)]
pub struct Building {
    pub mesh: Mesh,
    /// The corners that occurred so far, so that equal corners share a vertex.
    vertices: Vertices,
    /// True if some corner has a normal of the file.
    pub has_stated_normals: bool,
    pub has_coordinates: bool,
    /// The vertices that take their normals from a smoothing group, each with the index of its normal in
    /// [`smoothing::Smoothing`].
    pub smooth: Vec<(u32, u32)>,
}

/// Finds the vertex of a corner. Most positions have one vertex, which a table finds without a hash.
#[derive(Default)]
struct Vertices {
    /// For each vertex of the mesh, the corner from which it was made.
    corners: Vec<Corner>,
    /// For a position of the file, the first vertex of the mesh there. An entry counts only if that vertex has this position,
    /// because entries of earlier meshes stay.
    first: Vec<u32>,
    /// Maps each corner that is not the first one of its position to its vertex.
    others: HashMap<Corner, u32, RandomState>,
}

impl Vertices {
    /// The vertex of a corner. If there is none, it is the next vertex of the mesh, and the second value is true.
    fn find_or_add(&mut self, corner: Corner) -> (u32, bool) {
        let next = self.corners.len() as u32;
        let position = corner.position as usize;
        if position >= self.first.len() {
            self.first.resize(position + 1, 0);
        }
        let first = &mut self.first[position];
        let vertex = match self.corners.get(*first as usize) {
            Some(found) if *found == corner => *first,
            Some(found) if found.position == corner.position => {
                *self.others.entry(corner).or_insert(next)
            }
            _ => {
                *first = next;
                next
            }
        };
        if vertex == next {
            self.corners.push(corner);
        }
        (vertex, vertex == next)
    }
}

impl Building {
    /// An empty mesh after this one, which reuses the memory for finding vertices.
    pub fn next(&mut self) -> Self {
        let vertices = Vertices {
            first: std::mem::take(&mut self.vertices.first),
            ..Vertices::default()
        };
        Self {
            vertices,
            ..Self::default()
        }
    }

    /// Returns the index, in the mesh, of the vertex of a corner. If no equal corner was used before, a new vertex is added.
    /// `position` is the corner's position relative to the mesh's origin.
    pub fn vertex(&mut self, corner: Corner, position: Vec3, attributes: &Attributes) -> u32 {
        let (vertex, is_new) = self.vertices.find_or_add(corner);
        if is_new {
            self.add_vertex(corner, position, attributes);
        }
        vertex
    }

    fn add_vertex(&mut self, corner: Corner, position: Vec3, attributes: &Attributes) {
        let Self { mesh, smooth, .. } = self;
        let vertex = mesh.positions.len();
        if let Some(at) = attributes.coordinates.get(corner.coordinates as usize) {
            mesh.uvs[0].resize(vertex, Vec2::ZERO);
            // In OBJ, v points up.
            mesh.uvs[0].push(Vec2::new(at.x, 1.0 - at.y));
        }
        if let Some(color) = attributes.colors.of(corner.position) {
            mesh.colors.resize(vertex, Vec4::NAN);
            mesh.colors.push(color);
        }
        if let Some(index) = smoothing::index_of(corner.normal) {
            smooth.push((vertex as u32, index));
        }
        mesh.positions.push(position);
        // A normal of zero length is a missing one: validation makes it geometric.
        let normal = attributes.normals.get(corner.normal as usize).copied();
        mesh.normals.push(normal.unwrap_or(Vec3::ZERO));
    }

    pub fn push(&mut self, triangle: [u32; 3], material: u32) {
        let first_triangle = self.mesh.triangles.len() as u32;
        self.mesh.triangles.push(triangle);
        match self.mesh.parts.last_mut() {
            Some(part) if part.material == material => part.triangle_count += 1,
            _ => self.mesh.parts.push(Part {
                first_triangle,
                triangle_count: 1,
                material,
            }),
        }
    }
}

/// Sorts the triangles of a mesh by material, in the order in which the materials are first used. Afterwards each material
/// of the mesh has exactly one part, which is a range of consecutive triangles with the same material. Without this, a file
/// that often changes the material between faces would give a mesh with very many parts.
pub fn join_parts(mesh: &mut Mesh) {
    let mut order: HashMap<u32, usize> = HashMap::new();
    for part in &mesh.parts {
        let next = order.len();
        order.entry(part.material).or_insert(next);
    }
    if order.len() == mesh.parts.len() {
        return;
    }
    let mut parts = mesh.parts.clone();
    parts.sort_by_key(|part| order[&part.material]);
    let mut triangles = Vec::with_capacity(mesh.triangles.len());
    mesh.parts.clear();
    for part in parts {
        let first = part.first_triangle as usize;
        let first_triangle = triangles.len() as u32;
        triangles.extend_from_slice(&mesh.triangles[first..][..part.triangle_count as usize]);
        match mesh.parts.last_mut() {
            Some(last) if last.material == part.material => {
                last.triangle_count += part.triangle_count;
            }
            _ => mesh.parts.push(Part {
                first_triangle,
                ..part
            }),
        }
    }
    mesh.triangles = triangles;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_corners_of_a_mesh_share_a_vertex() {
        let mut random = crate::base::random::Random::new(5);
        let mut building = Building::default();
        for _ in 0..3 {
            building = building.next();
            let mut expected = HashMap::new();
            for _ in 0..1000 {
                let mut below = |count| random.index(count) as u32;
                let corner = Corner {
                    position: below(50),
                    normal: below(3),
                    coordinates: below(3),
                };
                let next = expected.len() as u32;
                let vertex = *expected.entry(corner).or_insert(next);
                let found = building.vertices.find_or_add(corner);
                assert_eq!(found, (vertex, vertex == next));
            }
            assert!(expected.len() > 350);
        }
    }
}
