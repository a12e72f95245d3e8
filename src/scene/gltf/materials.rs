//! Materials: the factors of metallic-roughness and of the extensions that Headwater follows.

use super::document::{Document, Material as FileMaterial};
use crate::scene::Material;
use crate::scene::notices::{Tally, label, quoted};
use glam::{DVec3, Vec3};

/// The file's materials, one for one.
pub fn read(document: &Document, tally: &mut Tally) -> Vec<Material> {
    let mut textures = Textures::default();
    let materials = document
        .materials
        .iter()
        .enumerate()
        .map(|(index, source)| {
            textures.add(source);
            if let Some(mode) = source.alpha_mode.as_deref()
                && mode != "OPAQUE"
            {
                tally.add("alpha is not supported, surfaces are opaque", || {
                    let name = label("material", index, &source.name);
                    format!("{name} has alphaMode {}", quoted(mode))
                });
            }
            convert(source)
        })
        .collect();
    if let Some(line) = textures.notice() {
        tally.add(
            "textures are not supported yet, the plain factors are used",
            || line,
        );
    }
    materials
}

fn convert(source: &FileMaterial) -> Material {
    let pbr = &source.pbr_metallic_roughness;
    let [r, g, b, _] = pbr.base_color_factor;
    let extensions = &source.extensions;
    let strength = extensions.emissive_strength.emissive_strength;
    Material {
        name: source.name.clone(),
        base_color: DVec3::new(r, g, b).as_vec3(),
        metallic: pbr.metallic_factor as f32,
        roughness: pbr.roughness_factor as f32,
        specular: extensions.specular.specular_factor as f32,
        specular_color: vec3(extensions.specular.specular_color_factor),
        ior: extensions.ior.ior as f32,
        emission: (DVec3::from_array(source.emissive_factor) * strength).as_vec3(),
        double_sided: source.double_sided,
    }
}

fn vec3(color: [f64; 3]) -> Vec3 {
    DVec3::from_array(color).as_vec3()
}

/// Counts the textures that are ignored, by what they would colour.
#[derive(Default)]
struct Textures {
    counts: [(&'static str, usize); 7],
}

impl Textures {
    fn add(&mut self, material: &FileMaterial) {
        let pbr = &material.pbr_metallic_roughness;
        let specular = &material.extensions.specular;
        let found = [
            ("base colour", &pbr.base_color_texture),
            ("metallic-roughness", &pbr.metallic_roughness_texture),
            ("normal", &material.normal_texture),
            ("occlusion", &material.occlusion_texture),
            ("emissive", &material.emissive_texture),
            ("specular", &specular.specular_texture),
            ("specular colour", &specular.specular_color_texture),
        ];
        for (count, (name, texture)) in self.counts.iter_mut().zip(found) {
            *count = (name, count.1 + usize::from(texture.is_some()));
        }
    }

    fn notice(&self) -> Option<String> {
        let parts: Vec<String> = self
            .counts
            .iter()
            .filter(|(_, count)| *count > 0)
            .map(|(name, count)| format!("{name} ({count})"))
            .collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}
