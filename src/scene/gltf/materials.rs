//! Materials: the factors of metallic-roughness and of the extensions that Headwater follows.

use crate::scene::Material;
use crate::scene::notices::{Tally, label};
use glam::{DVec3, Vec3, Vec4};
use gltf::json::Material as FileMaterial;
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;

/// The file's materials, one for one.
pub fn read(materials: &[FileMaterial], tally: &mut Tally) -> Vec<Material> {
    for (index, source) in materials.iter().enumerate() {
        let mode = match source.alpha_mode {
            Checked::Valid(AlphaMode::Opaque) => continue,
            Checked::Valid(AlphaMode::Mask) => "alphaMode \"MASK\"",
            Checked::Valid(AlphaMode::Blend) => "alphaMode \"BLEND\"",
            Checked::Invalid => "an unknown alphaMode",
        };
        tally.add("alpha is not supported, surfaces are opaque", || {
            let name = source.name.as_deref().unwrap_or_default();
            format!("{} has {mode}", label("material", index, name))
        });
    }
    let textures = textures(materials);
    if !textures.is_empty() {
        tally.add(
            "textures are not supported yet, the plain factors are used",
            || textures.join(", "),
        );
    }
    materials.iter().map(convert).collect()
}

fn convert(source: &FileMaterial) -> Material {
    let pbr = &source.pbr_metallic_roughness;
    let extensions = source.extensions.clone().unwrap_or_default();
    let specular = extensions.specular.unwrap_or_default();
    let (color, strength) = emission(source);
    Material {
        name: source.name.clone().unwrap_or_default(),
        base_color: Vec4::from_array(pbr.base_color_factor.0).truncate(),
        metallic: pbr.metallic_factor.0,
        roughness: pbr.roughness_factor.0,
        specular: specular.specular_factor.0,
        specular_color: Vec3::from_array(specular.specular_color_factor.0),
        ior: extensions.ior.unwrap_or_default().ior.0,
        emission: (color * strength).as_vec3(),
        double_sided: source.double_sided,
    }
}

/// The emissive factor, and the strength that multiplies it.
pub fn emission(source: &FileMaterial) -> (DVec3, f64) {
    let extensions = source.extensions.as_ref();
    let strength = extensions.and_then(|extensions| extensions.emissive_strength.clone());
    (
        Vec3::from_array(source.emissive_factor.0).as_dvec3(),
        strength.unwrap_or_default().emissive_strength.0.into(),
    )
}

/// The kinds of textures that materials have, each with the number of these materials.
fn textures(materials: &[FileMaterial]) -> Vec<String> {
    let kinds = [
        "base colour",
        "metallic-roughness",
        "normal",
        "occlusion",
        "emissive",
        "specular",
        "specular colour",
    ];
    let mut counts = [0; 7];
    for material in materials {
        let pbr = &material.pbr_metallic_roughness;
        let specular = (material.extensions.as_ref()).and_then(|e| e.specular.as_ref());
        let has = [
            pbr.base_color_texture.is_some(),
            pbr.metallic_roughness_texture.is_some(),
            material.normal_texture.is_some(),
            material.occlusion_texture.is_some(),
            material.emissive_texture.is_some(),
            specular.is_some_and(|s| s.specular_texture.is_some()),
            specular.is_some_and(|s| s.specular_color_texture.is_some()),
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
