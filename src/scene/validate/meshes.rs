//! Checks of a mesh's attributes, indices and parts. Repairs and the renderer rely on them, so a scene that fails one is
//! refused.

use super::LARGEST_COORDINATE;
use crate::scene::notices::label;
use crate::scene::{Material, Mesh};
use crate::{Error, Result};
use std::fmt::Display;

/// Checks a mesh, and fails at the first fault: 32 bits must suffice to count its vertices and triangles; its attributes
/// must be finite and have one value per vertex or none; no coordinate may exceed [`LARGEST_COORDINATE`]; its indices must
/// be in range; its parts must cover its triangles; and it must have the texture coordinates that the textures of its
/// materials use. `index` is the mesh's index in the scene, for messages.
pub(super) fn check_mesh(index: usize, mesh: &Mesh, materials: &[Material]) -> Result<()> {
    let what = label("mesh", index, &mesh.name);
    let wrong = |fault: String| Err(Error::input(format!("{what}: {fault}")));
    let vertices = mesh.positions.len();
    if u32::try_from(vertices.max(mesh.triangles.len())).is_err() {
        return wrong(format!(
            "{vertices} vertices and {} triangles are more than 32 bits can count; split it",
            mesh.triangles.len()
        ));
    }
    let attribute = |checked: std::result::Result<(), String>| checked.or_else(wrong);
    attribute(check_attribute(
        "position",
        &mesh.positions,
        vertices,
        |p| p.is_finite(),
    ))?;
    let limit = LARGEST_COORDINATE as f32;
    if let Some(i) = mesh
        .positions
        .iter()
        .position(|p| p.abs().max_element() > limit)
    {
        return wrong(format!(
            "position {i} is {}, and {LARGEST_COORDINATE:e} is as far as can be rendered; scale the mesh down",
            mesh.positions[i]
        ));
    }
    attribute(check_attribute("normal", &mesh.normals, vertices, |n| {
        n.is_finite()
    }))?;
    attribute(check_attribute("colour", &mesh.colors, vertices, |c| {
        c.is_finite()
    }))?;
    attribute(check_attribute("tangent", &mesh.tangents, vertices, |t| {
        t.is_finite()
    }))?;
    for uvs in &mesh.uvs {
        attribute(check_attribute("texture coordinate", uvs, vertices, |uv| {
            uv.is_finite()
        }))?;
    }
    let out_of_range = |t: &[u32; 3]| t.iter().any(|&i| i as usize >= vertices);
    if let Some(i) = mesh.triangles.iter().position(out_of_range) {
        return wrong(format!(
            "triangle {i} has the corners {:?}, but there are {vertices} positions",
            mesh.triangles[i]
        ));
    }
    let mut next = 0;
    for (i, part) in mesh.parts.iter().enumerate() {
        let Some(material) = materials.get(part.material as usize) else {
            return wrong(format!(
                "part {i} has material {}, but there are {}",
                part.material,
                materials.len()
            ));
        };
        if let Some((name, texture)) = (material.textures())
            .find(|(_, t)| part.triangle_count > 0 && mesh.uvs[t.set as usize].is_empty())
        {
            return wrong(format!(
                "part {i} has no texture coordinates {} for the {name} of its material",
                texture.set
            ));
        }
        if u64::from(part.first_triangle) != next {
            return wrong(format!(
                "part {i} begins at triangle {}, not at {next} where the part before it ends",
                part.first_triangle
            ));
        }
        next += u64::from(part.triangle_count);
    }
    if next != mesh.triangles.len() as u64 {
        return wrong(format!(
            "its parts cover {next} triangles of {}",
            mesh.triangles.len()
        ));
    }
    Ok(())
}

/// Checks that an attribute of a mesh has one finite value for each of the `vertices` vertices, or no values at all.
/// Otherwise returns a description of the fault, in which `kind` names the attribute, such as `normal`.
fn check_attribute<T: Display>(
    kind: &str,
    values: &[T],
    vertices: usize,
    is_finite: impl Fn(&T) -> bool,
) -> std::result::Result<(), String> {
    if !values.is_empty() && values.len() != vertices {
        return Err(format!(
            "{} {kind}s for {vertices} positions; give one each, or none",
            values.len()
        ));
    }
    match values.iter().position(|value| !is_finite(value)) {
        Some(i) => Err(format!("{kind} {i} is {}; it must be finite", values[i])),
        None => Ok(()),
    }
}
