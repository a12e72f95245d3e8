//! Reads materials: the metallic-roughness model, and the extensions of materials that are supported.

use super::accessors::get;
use super::document::{Document, Material as FileMaterial, MaterialExtensions, TextureInfo};
use super::nodes::Placed;
use super::textures::Textures;
use crate::Result;
use crate::scene::layers::{Anisotropy, Coat, Transmission, Volume};
use crate::scene::notices::{Tally, label, quoted};
use crate::scene::{AlphaMode, Layers, Material, Texture};
use glam::{DVec3, Vec3, Vec4};
use std::collections::BTreeSet;

/// The ways in which the scene uses the materials of a file. They decide which images are read: images that only unused
/// materials need are not read.
pub struct Uses {
    /// One entry for each material of the file: true if a mesh of the scene has a primitive with the material. Textures of
    /// other materials are not read.
    pub has_faces: Vec<bool>,
    /// One entry for each material of the file: true if the material emits light at some time. Only then is its emissive
    /// texture read.
    pub emits: Vec<bool>,
}

impl Uses {
    /// Determines which materials of the document are used by the meshes of `placed`, the nodes of the scene, and which
    /// materials emit light. A material emits if its emission in the file is not black, or if `is_animated` returns true for
    /// its index, which means that keyframes change its emission.
    pub fn of(
        document: &Document,
        placed: &[Placed<'_>],
        is_animated: impl Fn(usize) -> bool,
    ) -> Self {
        let mut has_faces = vec![false; document.materials.len()];
        // Each mesh once, in however many places it stands.
        let meshes: BTreeSet<u64> = placed
            .iter()
            .filter(|placed_node| placed_node.is_shown)
            .filter_map(|placed_node| placed_node.node.mesh)
            .collect();
        // What is out of range is named when meshes are read.
        let meshes = (meshes.iter()).filter_map(|index| get(&document.meshes, *index));
        for primitive in meshes.flat_map(|mesh| &mesh.primitives) {
            let used = primitive
                .material
                .and_then(|index| usize::try_from(index).ok());
            if let Some(used) = used.and_then(|index| has_faces.get_mut(index)) {
                *used = true;
            }
        }
        let emits = |(index, material)| {
            let (color, strength) = emission(material);
            is_animated(index) || (color * strength).as_vec3().max_element() > 0.0
        };
        Self {
            has_faces,
            emits: document.materials.iter().enumerate().map(emits).collect(),
        }
    }
}

/// The scene's materials with their textures, one for each of `materials`, in the order of the file. Kinds of textures that
/// are not supported are ignored, and unknown alpha modes count as opaque, each with a notice in `tally`. Fails if a
/// reference to a texture is wrong.
pub fn read(
    materials: &[FileMaterial],
    textures: &Textures<'_>,
    tally: &mut Tally,
) -> Result<Vec<Material>> {
    let has_occlusion = |material: &&FileMaterial| material.occlusion_texture.is_some();
    let occlusion = materials.iter().filter(has_occlusion).count();
    if occlusion > 0 {
        tally.add("textures that are not supported are ignored", || {
            format!("occlusion ({occlusion})")
        });
    }
    (materials.iter().enumerate())
        .map(|(index, source)| convert(index, source, textures, tally))
        .collect()
}

fn convert(
    index: usize,
    source: &FileMaterial,
    textures: &Textures<'_>,
    tally: &mut Tally,
) -> Result<Material> {
    let what = label("material", index, &source.name);
    let pbr = &source.pbr_metallic_roughness;
    let specular = &source.extensions.specular;
    let (mut color, strength) = emission(source);
    if textures.has_lost_emission(index) {
        tally.add(
            "materials without their emissive texture emit nothing",
            || what.clone(),
        );
        color = DVec3::ZERO;
    }
    let [
        base_color_texture,
        metallic_roughness_texture,
        normal_texture,
        specular_texture,
        specular_color_texture,
        layer_textures @ ..,
        emissive_texture,
    ] = textures.of_material(&what, index, tally)?;
    let base_color = Vec4::from_array(pbr.base_color_factor).truncate();
    let seen = Material {
        base_color_texture,
        alpha: pbr.base_color_factor[3],
        alpha_mode: alpha_mode(&what, source, tally),
        double_sided: source.double_sided,
        culled: source.is_culled(),
        ..Material::unlit(&source.name, base_color)
    };
    if source.is_unlit() {
        return Ok(seen);
    }
    Ok(Material {
        unlit: false,
        metallic: pbr.metallic_factor,
        roughness: pbr.roughness_factor,
        metallic_roughness_texture,
        normal_texture,
        normal_scale: scale_of(&source.normal_texture),
        specular: specular.specular_factor,
        specular_color: Vec3::from_array(specular.specular_color_factor),
        specular_texture,
        specular_color_texture,
        ior: source.extensions.ior.ior,
        layers: layers(source, layer_textures),
        emission: (color * strength).as_vec3(),
        emissive_texture,
        ..seen
    })
}

/// The layers of a material. `textures` are those of the coat (strength, roughness, normal), then those of anisotropy
/// and transmission.
fn layers(source: &FileMaterial, textures: [Option<Texture>; 5]) -> Layers {
    let MaterialExtensions {
        coat,
        anisotropy,
        transmission,
        volume,
        dispersion,
        ..
    } = &source.extensions;
    let [
        coat_texture,
        coat_roughness_texture,
        coat_normal_texture,
        anisotropy_texture,
        transmission_texture,
    ] = textures;
    Layers {
        coat: Coat {
            factor: coat.clearcoat_factor,
            texture: coat_texture,
            roughness: coat.clearcoat_roughness_factor,
            roughness_texture: coat_roughness_texture,
            normal_texture: coat_normal_texture,
            normal_scale: scale_of(&coat.clearcoat_normal_texture),
        },
        anisotropy: Anisotropy {
            strength: anisotropy.anisotropy_strength,
            rotation: anisotropy.anisotropy_rotation,
            texture: anisotropy_texture,
        },
        transmission: Transmission {
            factor: transmission.transmission_factor,
            texture: transmission_texture,
        },
        volume: Volume {
            thickness: volume.thickness_factor,
            attenuation_distance: volume.attenuation_distance.unwrap_or(f32::INFINITY),
            attenuation_color: Vec3::from_array(volume.attenuation_color),
        },
        dispersion: dispersion.dispersion,
    }
}

/// The factor on x and y of the vectors in a normal texture; 1 if the file states none.
fn scale_of(normal_texture: &Option<TextureInfo>) -> f32 {
    let scale = normal_texture.as_ref().and_then(|info| info.scale);
    scale.unwrap_or(1.0)
}

fn alpha_mode(what: &str, source: &FileMaterial, tally: &mut Tally) -> AlphaMode {
    match source.alpha_mode.as_deref() {
        None | Some("OPAQUE") => AlphaMode::Opaque,
        Some("MASK") => AlphaMode::Mask {
            cutoff: source.alpha_cutoff.unwrap_or(0.5),
        },
        Some("BLEND") => AlphaMode::Blend,
        Some(mode) => {
            tally.add("alpha modes that are unknown are taken as OPAQUE", || {
                format!("{what} has {}", quoted(mode))
            });
            AlphaMode::Opaque
        }
    }
}

/// The emissive factor of a material, as linear RGB, and the emissive strength (1 if the file states none). Their product is
/// the emitted radiance.
pub fn emission(source: &FileMaterial) -> (DVec3, f64) {
    let strength = &source.extensions.emissive_strength;
    (
        Vec3::from_array(source.emissive_factor).as_dvec3(),
        strength.emissive_strength.into(),
    )
}
