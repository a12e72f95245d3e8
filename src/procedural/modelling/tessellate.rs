//! Subdivision of emissive triangles. It changes the number of lights, as tests of light sampling need, but not the light
//! that they emit together. The parameter `tessellation` of the scene `night-city` uses it.

use crate::scene::{Mesh, Part, Scene};
use glam::{DVec3, Vec3};

/// Divides each edge of each emissive triangle of a scene into `pieces` equal parts, so that a triangle becomes `pieces`²
/// triangles. Two triangles that share an edge get new vertices at the same positions on it, so that no gaps arise. Meshes
/// with emissive triangles must not have texture coordinates or vertex colours, because the new vertices get none.
pub fn tessellate_lights(scene: &mut Scene, pieces: u32) {
    for mesh in scene.meshes.iter_mut().filter(|_| pieces > 1) {
        let old = std::mem::take(&mut mesh.triangles);
        for mut part in std::mem::take(&mut mesh.parts) {
            let triangles = &old[part.first_triangle as usize..][..part.triangle_count as usize];
            part.first_triangle = mesh.triangles.len() as u32;
            if scene.materials[part.material as usize].is_emissive() {
                for triangle in triangles {
                    divide(mesh, *triangle, pieces);
                }
            } else {
                mesh.triangles.extend(triangles);
            }
            let triangle_count = mesh.triangles.len() as u32 - part.first_triangle;
            mesh.parts.push(Part {
                triangle_count,
                ..part
            });
        }
    }
}

/// Divides each edge of one triangle into `pieces` equal parts, and adds the `pieces`² small triangles and their vertices to
/// the mesh. `corners` has the indices in the mesh of the three vertices of the divided triangle.
fn divide(mesh: &mut Mesh, corners: [u32; 3], pieces: u32) {
    let first = mesh.positions.len() as u32;
    for row in 0..=pieces {
        for column in 0..=pieces - row {
            let weights = [pieces - row - column, column, row].map(f64::from);
            // In f64 the same wherever an edge starts, since the third weight is 0 there.
            let mixed = |values: &[Vec3]| {
                let terms = [0, 1, 2].map(|i| values[corners[i] as usize].as_dvec3() * weights[i]);
                terms.into_iter().sum::<DVec3>() / f64::from(pieces)
            };
            mesh.positions.push(mixed(&mesh.positions).as_vec3());
            if !mesh.normals.is_empty() {
                mesh.normals
                    .push(mixed(&mesh.normals).normalize_or_zero().as_vec3());
            }
        }
    }
    let mut at = first;
    for row in 0..pieces {
        let width = pieces - row;
        for column in 0..width {
            let (low, high) = (at + column, at + width + 1 + column);
            mesh.triangles.push([low, low + 1, high]);
            if column + 1 < width {
                mesh.triangles.push([low + 1, high + 1, high]);
            }
        }
        at += width + 1;
    }
}
