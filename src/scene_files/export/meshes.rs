//! Writes meshes as glTF primitives.

use super::{Binary, FLOAT};
use crate::scene::Mesh;
use bytemuck::cast_slice;
use glam::{DVec3, Vec4};
use serde_json::{Value, json};

const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The JSON of a mesh, with one primitive for each of its parts (runs of triangles with one material). All primitives refer
/// to the same vertices. The vertices and indices are appended to `binary`, the binary chunk of the GLB file.
pub fn mesh(mesh: &Mesh, binary: &mut Binary) -> Value {
    let bounds = mesh.bounds();
    let [low, high] = bounds.map_or([DVec3::ZERO; 2], |bounds| [bounds.min, bounds.max]);
    let positions = json!({
        "componentType": FLOAT, "type": "VEC3", "count": mesh.positions.len(),
        "min": low.to_array(), "max": high.to_array(),
    });
    let mut attributes =
        json!({ "POSITION": binary.push(&mesh.positions, Some(ARRAY_BUFFER), positions) });
    let mut add = |name: &str, kind: &str, count: usize, values: &[f32]| {
        if count > 0 {
            let accessor = json!({ "componentType": FLOAT, "type": kind, "count": count });
            attributes[name] = json!(binary.push(values, Some(ARRAY_BUFFER), accessor));
        }
    };
    let (normals, colors, uvs) = (&mesh.normals, &mesh.colors, &mesh.uvs);
    add("NORMAL", "VEC3", normals.len(), cast_slice(normals));
    if !normals.is_empty() {
        // Vertices without a normal map have none, but glTF wants unit vectors.
        let unit = |tangent: &Vec4| match *tangent == Vec4::ZERO {
            true => Vec4::new(1.0, 0.0, 0.0, 1.0),
            false => *tangent,
        };
        let tangents: Vec<Vec4> = mesh.tangents.iter().map(unit).collect();
        add("TANGENT", "VEC4", tangents.len(), cast_slice(&tangents));
    }
    add("COLOR_0", "VEC4", colors.len(), cast_slice(colors));
    add("TEXCOORD_0", "VEC2", uvs[0].len(), cast_slice(&uvs[0]));
    add("TEXCOORD_1", "VEC2", uvs[1].len(), cast_slice(&uvs[1]));
    let primitives: Vec<Value> = mesh
        .parts
        .iter()
        .map(|part| {
            let first = part.first_triangle as usize;
            let triangles = &mesh.triangles[first..first + part.triangle_count as usize];
            let indices = json!({
                "componentType": UNSIGNED_INT, "type": "SCALAR", "count": 3 * triangles.len(),
            });
            json!({
                "attributes": attributes,
                "indices": binary.push(triangles, Some(ELEMENT_ARRAY_BUFFER), indices),
                "material": part.material,
            })
        })
        .collect();
    json!({ "name": mesh.name, "primitives": primitives })
}
