//! Materials: metallic-roughness and the extensions that Headwater follows.

use super::document::Material as FileMaterial;
use super::textures::Textures;
use crate::Result;
use crate::scene::Material;
use crate::scene::notices::{Tally, label, quoted};
use glam::{DVec3, Vec3, Vec4};

/// The file's materials, one for one.
pub fn read(
    materials: &[FileMaterial],
    textures: &Textures<'_>,
    tally: &mut Tally,
) -> Result<Vec<Material>> {
    for (index, source) in materials.iter().enumerate() {
        let mode = match source.alpha_mode.as_deref() {
            None | Some("OPAQUE") => continue,
            Some(mode @ ("MASK" | "BLEND")) => format!("alphaMode \"{mode}\""),
            Some(mode) => format!("an unknown alphaMode, {}", quoted(mode)),
        };
        tally.add("alpha is not supported, surfaces are opaque", || {
            format!("{} has {mode}", label("material", index, &source.name))
        });
    }
    let ignored = ignored_textures(materials);
    if !ignored.is_empty() {
        tally.add("textures that are not supported are ignored", || {
            ignored.join(", ")
        });
    }
    (materials.iter().enumerate())
        .map(|(index, source)| convert(index, source, textures))
        .collect()
}

fn convert(index: usize, source: &FileMaterial, textures: &Textures<'_>) -> Result<Material> {
    let what = label("material", index, &source.name);
    let pbr = &source.pbr_metallic_roughness;
    let specular = &source.extensions.specular;
    let (color, strength) = emission(source);
    let [
        base_color_texture,
        metallic_roughness_texture,
        normal_texture,
        emissive_texture,
    ] = textures.of_material(&what, source)?;
    Ok(Material {
        name: source.name.clone(),
        base_color: Vec4::from_array(pbr.base_color_factor).truncate(),
        base_color_texture,
        metallic: pbr.metallic_factor,
        roughness: pbr.roughness_factor,
        metallic_roughness_texture,
        normal_texture,
        normal_scale: (source.normal_texture.as_ref())
            .map_or(1.0, |info| info.scale.unwrap_or(1.0)),
        specular: specular.specular_factor,
        specular_color: Vec3::from_array(specular.specular_color_factor),
        ior: source.extensions.ior.ior,
        emission: (color * strength).as_vec3(),
        emissive_texture,
        double_sided: source.double_sided,
    })
}

/// The emissive factor, and the strength that multiplies it.
pub fn emission(source: &FileMaterial) -> (DVec3, f64) {
    let strength = &source.extensions.emissive_strength;
    (
        Vec3::from_array(source.emissive_factor).as_dvec3(),
        strength.emissive_strength.into(),
    )
}

/// The kinds of textures that are not followed, each with the number of materials that have it.
fn ignored_textures(materials: &[FileMaterial]) -> Vec<String> {
    let kinds = ["occlusion", "specular", "specular colour"];
    let mut counts = [0; 3];
    for material in materials {
        let specular = &material.extensions.specular;
        let has = [
            material.occlusion_texture.is_some(),
            specular.specular_texture.is_some(),
            specular.specular_color_texture.is_some(),
        ];
        for (count, has) in counts.iter_mut().zip(has) {
            *count += usize::from(has);
        }
    }
    (kinds.iter().zip(counts))
        .filter(|(_, count)| *count > 0)
        .map(|(kind, count)| format!("{kind} ({count})"))
        .collect()
}
