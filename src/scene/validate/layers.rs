//! Checks of the layers of a material: clear coat, anisotropy, transmission, volume and dispersion; and of the meshes of volumes.

use crate::scene::notices::{Tally, label};
use crate::scene::{Layers, Material, Mesh};
use crate::{Error, Result};
use glam::Vec3;
use std::collections::HashMap;

/// Checks that the numbers of a material's layers are in range. Numbers outside are moved to the end of the range, with one
/// notice in `tally`; an attenuation distance of 0 or less counts as infinite. Fails at the first number that is NaN, and
/// where an angle or a scale is infinite. `what` is the name of the material in messages.
pub(super) fn check_layers(what: &str, layers: &mut Layers, tally: &mut Tally) -> Result<()> {
    let Layers {
        coat,
        anisotropy,
        transmission,
        volume,
        dispersion,
    } = layers;
    for (name, value) in [
        (
            "the scale of the clear coat's normal texture",
            coat.normal_scale,
        ),
        ("anisotropy rotation", anisotropy.rotation),
    ] {
        if !value.is_finite() {
            return Err(Error::input(format!(
                "{what}: {name} is {value}; it must be finite"
            )));
        }
    }
    let Vec3 { x, y, z } = &mut volume.attenuation_color;
    for (name, value, largest) in [
        ("clear coat factor", &mut coat.factor, 1.0),
        ("clear coat roughness", &mut coat.roughness, 1.0),
        ("anisotropy strength", &mut anisotropy.strength, 1.0),
        ("transmission factor", &mut transmission.factor, 1.0),
        ("thickness", &mut volume.thickness, f32::MAX),
        (
            "attenuation distance",
            &mut volume.attenuation_distance,
            f32::INFINITY,
        ),
        ("attenuation colour", x, 1.0),
        ("attenuation colour", y, 1.0),
        ("attenuation colour", z, 1.0),
        ("dispersion", dispersion, f32::MAX),
    ] {
        if value.is_nan() {
            return Err(Error::input(format!(
                "{what}: {name} is NaN; it must be a number"
            )));
        }
        let clamped = value.clamp(0.0, largest);
        if clamped != *value {
            *value = clamped;
            tally.add(
                "values of coats, anisotropy, transmission and volumes outside of their range are clamped",
                || format!("{name} of {what}"),
            );
        }
    }
    if volume.attenuation_distance == 0.0 {
        volume.attenuation_distance = f32::INFINITY;
        tally.add("attenuation distances of 0 count as infinite", || {
            what.into()
        });
    }
    Ok(())
}

/// Adds a notice to `tally` if a volume of the mesh has a hole: light that leaves through it is neither refracted nor absorbed.
/// The mesh must be valid; `index` is its index in the scene.
pub(super) fn check_volumes(index: usize, mesh: &Mesh, materials: &[Material], tally: &mut Tally) {
    let bounds_a_volume: Vec<bool> = (mesh.parts.iter())
        .flat_map(|part| {
            let bounds = (materials[part.material as usize].layers).bounds_a_volume();
            std::iter::repeat_n(bounds, part.triangle_count as usize)
        })
        .collect();
    if bounds_a_volume.contains(&true) && has_open_edge(mesh, &bounds_a_volume) {
        tally.add(
            "volumes with holes in their surface absorb no light that leaves through a hole; close the mesh",
            || label("mesh", index, &mesh.name),
        );
    }
}

/// True if a triangle for which `is_counted` is true has an edge that no other triangle of the mesh has. Vertices at the same
/// position are one, because a mesh has several where normals or texture coordinates change.
fn has_open_edge(mesh: &Mesh, is_counted: &[bool]) -> bool {
    let mut welded = HashMap::new();
    let vertices: Vec<u32> = (0..)
        .zip(&mesh.positions)
        .map(|(vertex, &position)| {
            // The sum makes −0 the same as 0.
            let key = (position + Vec3::ZERO).to_array().map(f32::to_bits);
            *welded.entry(key).or_insert(vertex)
        })
        .collect();
    // For each edge, the number of its triangles, and true if one of them is counted.
    let mut edges: HashMap<[u32; 2], (u32, bool)> = HashMap::new();
    for (triangle, counted) in mesh.triangles.iter().zip(is_counted) {
        let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
        if a == b || b == c || c == a {
            continue;
        }
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let edge = edges.entry([from.min(to), from.max(to)]).or_default();
            edge.0 += 1;
            edge.1 |= counted;
        }
    }
    (edges.values()).any(|&(triangles, counted)| triangles == 1 && counted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::layers::{Transmission, Volume};
    use crate::scene::{Part, Scene};

    /// A tetrahedron of glass whose faces share no vertex. The fourth face is a part of its own, with the second material.
    fn tetrahedron() -> Scene {
        let glass = Material {
            layers: Layers {
                transmission: Transmission {
                    factor: 1.0,
                    texture: None,
                },
                volume: Volume {
                    thickness: 1.0,
                    ..Volume::default()
                },
                ..Layers::default()
            },
            ..Material::default()
        };
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mut positions: Vec<Vec3> = (faces.as_flattened().iter())
            .map(|&corner: &usize| corners[corner])
            .collect();
        positions[0].x = -0.0;
        let part = |first_triangle, triangle_count, material| Part {
            first_triangle,
            triangle_count,
            material,
        };
        Scene {
            meshes: vec![Mesh {
                name: "drop".into(),
                positions,
                triangles: (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
                parts: vec![part(0, 3, 0), part(3, 1, 1)],
                ..Mesh::default()
            }],
            materials: vec![glass.clone(), glass],
            ..Scene::default()
        }
    }

    #[test]
    fn volumes_with_holes_are_noted_once() {
        let notices = |change: fn(&mut Scene)| {
            let mut scene = tetrahedron();
            change(&mut scene);
            scene.validate().unwrap();
            scene.notices
        };
        let no_notices: [fn(&mut Scene); 3] = [
            |_| {},
            // Another material may close the surface.
            |scene| scene.materials[1] = Material::default(),
            // A sheet and an opaque surface bound nothing.
            |scene| {
                scene.meshes[0].positions[9] = Vec3::splat(2.0);
                scene.materials[0].layers.volume.thickness = 0.0;
                scene.materials[1].layers.transmission.factor = 0.0;
            },
        ];
        for change in no_notices {
            assert_eq!(notices(change), [""; 0]);
        }
        let open = notices(|scene| scene.meshes[0].positions[9] = Vec3::splat(2.0));
        assert_eq!(
            open,
            [
                "volumes with holes in their surface absorb no light that leaves through a hole; close the mesh: mesh 0 \"drop\""
            ]
        );
    }
}
