//! Materials and textures in the form in which shaders read them: radiances in the device's unit, alpha modes as numbers,
//! and textures as indices.

use super::units::Units;
use crate::scene::lights::EmitterTriangle;
use crate::scene::texture::{self, Image, Wrap};
use crate::scene::{AlphaMode, Layers, Material, Scene, Texture};
use crate::shader_interface::{
    ALPHA_BLEND, ALPHA_MASK, ALPHA_OPAQUE, GpuLightTexture, GpuMaterial, GpuMaterialLayers,
    GpuTexture, MATERIAL_CULLED, MATERIAL_SPECULAR_COLOR_TEXTURE, MATERIAL_SPECULAR_SHIFT,
    MATERIAL_SPECULAR_TEXTURE, MATERIAL_UNLIT, NONE, TEXTURE_DEEP, TEXTURE_NEAREST, Textures,
    WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT,
};
use glam::Vec3;
use std::f64::consts::TAU;

/// The materials and textures of a scene, in the form in which they are uploaded into the device's buffers.
pub struct Materials {
    /// One entry per material of the scene, in the same order. Its textures are indices into `textures`, or NONE.
    /// If some material has a layer that is seen, as many entries follow, which are [`GpuMaterialLayers`].
    pub materials: Vec<GpuMaterial>,
    /// One entry for each use of an image by a material: the index of the image or of its first texel, its
    /// size, the transform of texture coordinates, and the wrap modes. With it, shaders find and read texels.
    pub textures: Vec<GpuTexture>,
    /// For each material, the index of its emissive texture in `textures`; NONE for a material without one.
    /// [`Materials::of_lights`] copies it to each emissive triangle.
    emissive: Vec<u32>,
    /// The words of the buffer `texels`: first the table of sRGB, then the texels of all images. The table has
    /// [`table_length`] words: the linear value of each sRGB byte and then, if needed, of each 16-bit sRGB value, as the bits
    /// of an f32. The texels are left out if shaders sample images instead of reading this buffer.
    pub texels: Vec<u32>,
}

impl Materials {
    /// Converts the materials of a scene. `units` are the device's units of length and radiance.
    /// `read` states whether shaders read textures from images or from a buffer. Accordingly, [`GpuTexture::index`]
    /// is the index of an image, or that of the image's first texel in the buffer.
    pub fn of(scene: &Scene, units: &Units, read: Textures) -> Self {
        let table = linear_of_srgb().take(table_length(scene));
        let mut texels: Vec<u32> = table.map(f32::to_bits).collect();
        let mut indices = Vec::with_capacity(scene.images.len());
        for (index, image) in scene.images.iter().enumerate() {
            if read == Textures::Images {
                indices.push(index as u32);
                continue;
            }
            indices.push(texels.len() as u32);
            texels.extend(image.texels.iter().map(|texel| u32::from_le_bytes(*texel)));
        }
        let mut textures = Vec::new();
        let mut texture = |used: &Option<Texture>| {
            let Some(used) = used else { return NONE };
            let image = &scene.images[used.image as usize];
            textures.push(GpuTexture {
                column_u: used.transform.matrix2.x_axis,
                column_v: used.transform.matrix2.y_axis,
                offset: used.transform.translation,
                index: indices[used.image as usize],
                width: image.width,
                height: image.height,
                set: used.set,
                wrap: wrap(used.wrap[0]) | wrap(used.wrap[1]) << 2,
                flags: if used.nearest { TEXTURE_NEAREST } else { 0 }
                    | if image.is_deep() { TEXTURE_DEEP } else { 0 },
            });
            textures.len() as u32 - 1
        };
        let materials = scene.materials.iter().map(|material| {
            let plain = gpu_material(material, units.radiance);
            GpuMaterial {
                base_color_texture: texture(&material.base_color_texture),
                metallic_roughness_texture: texture(&material.metallic_roughness_texture),
                normal_texture: texture(&material.normal_texture),
                flags: plain.flags
                    | specular_flags(
                        texture(&material.specular_texture),
                        texture(&material.specular_color_texture),
                    ),
                ..plain
            }
        });
        let mut materials: Vec<GpuMaterial> = materials.collect();
        let emissive = scene.materials.iter();
        let emissive = emissive.map(|material| texture(&material.emissive_texture));
        let emissive = emissive.collect();
        if scene.has_layers() {
            let layers = scene.materials.iter();
            let layers = layers.map(|material| gpu_layers(material, units.length, &mut texture));
            materials.extend(layers.map(bytemuck::cast::<GpuMaterialLayers, GpuMaterial>));
        }
        Self {
            materials,
            textures,
            emissive,
            texels,
        }
    }

    /// One entry per emissive triangle, in the order of `emitters`: the texture coordinates of its corners, and the index of
    /// its emissive texture in `textures`, or NONE if it has none. From this, shaders compute the emission at a point of the
    /// light.
    pub fn of_lights(&self, emitters: &[EmitterTriangle]) -> Vec<GpuLightTexture> {
        let laid = emitters.iter().map(|emitter| {
            let [a, b, c] = emitter.uvs;
            GpuLightTexture {
                uv: a,
                edge1: b - a,
                edge2: c - a,
                texture: self.emissive[emitter.material as usize],
                padding: 0,
            }
        });
        laid.collect()
    }
}

/// The linear value in [0, 1] of each of the 256 sRGB bytes, in ascending order of the bytes, then of each 16-bit sRGB value.
/// Shaders look up the channels of texels in this table.
fn linear_of_srgb() -> impl Iterator<Item = f32> {
    let bytes = (0..=u8::MAX).map(|byte| 257 * u16::from(byte));
    (bytes.chain(0..=u16::MAX)).map(|value| texture::srgb([value; 4]).x)
}

/// The number of words of the table of sRGB that shaders need for the textures of `scene`: 0 without textures, 256 for images
/// of 8 bits per channel, and 65,536 more if some image has 16 bits.
pub fn table_length(scene: &Scene) -> usize {
    let has_textures = scene.materials.iter().any(|m| m.textures().count() > 0);
    match (has_textures, scene.images.iter().any(Image::is_deep)) {
        (false, _) => 0,
        (true, false) => 1 << 8,
        (true, true) => (1 << 8) + (1 << 16),
    }
}

/// The part of [`GpuMaterial::flags`] that names the specular textures of a material. The arguments are the indices of both
/// textures, the second after the first; NONE for one that the material lacks.
const fn specular_flags(strength: u32, color: u32) -> u32 {
    match (strength, color) {
        (NONE, NONE) => 0,
        (NONE, color) => MATERIAL_SPECULAR_COLOR_TEXTURE | color << MATERIAL_SPECULAR_SHIFT,
        (first, NONE) => MATERIAL_SPECULAR_TEXTURE | first << MATERIAL_SPECULAR_SHIFT,
        (first, _) => specular_flags(first, NONE) | MATERIAL_SPECULAR_COLOR_TEXTURE,
    }
}

const fn wrap(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => WRAP_REPEAT,
        Wrap::Mirror => WRAP_MIRROR,
        Wrap::Clamp => WRAP_CLAMP,
    }
}

/// The smallest product of texture alpha and vertex alpha at which a surface of `material` is present. The
/// material has the alpha mode mask with the given `cutoff`; at a smaller product, shaders see a hole. The
/// result is the smallest number whose product with the material's own alpha is at least `cutoff`, and
/// infinite if that alpha is 0. With a base colour texture, it is lowered by the fraction 4 · 2⁻²³, because
/// devices round texel values.
fn least_coverage(material: &Material, cutoff: f32) -> f32 {
    // From two steps below the rounded quotient: no smaller product reaches the cutoff.
    let mut least = (cutoff / material.alpha).next_down().next_down();
    while least < f32::INFINITY && material.alpha * least < cutoff {
        least = least.next_up();
    }
    // Devices round a texel's value, and 255 steps are far apart.
    let rounding = if material.base_color_texture.is_some() {
        4.0 * f32::EPSILON
    } else {
        0.0
    };
    least * (1.0 - rounding)
}

/// Converts a material to the form that shaders read. `radiance` is the radiance, in the scene's unit, that is stored as 1
/// on the device; the base colour of an unlit material is a radiance, and is therefore divided by it. The result has NONE
/// for each texture, because the function does not know the places of textures on the device; [`Materials::of`] sets them.
pub fn gpu_material(material: &Material, radiance: f64) -> GpuMaterial {
    // KHR_materials_ior: an index of 0 stands for a reflectance of 1 at every angle.
    let normal_reflectance = if material.ior == 0.0 {
        1.0
    } else {
        ((material.ior - 1.0) / (material.ior + 1.0)).powi(2)
    };
    let tinted = normal_reflectance * material.specular_color;
    // Textures multiply it before the limit.
    let f0 = match material.has_specular_textures() {
        true => tinted,
        false => tinted.min(Vec3::ONE) * material.specular,
    };
    // The base colour of an unlit surface is a radiance, not a reflectance.
    let (base_color, flags) = if material.unlit {
        let seen = material.base_color.as_dvec3() / radiance;
        (seen.as_vec3(), MATERIAL_UNLIT)
    } else {
        (material.base_color, 0)
    };
    let culled = if material.hides_its_back() {
        MATERIAL_CULLED
    } else {
        0
    };
    let (alpha_mode, alpha) = match material.alpha_mode {
        AlphaMode::Opaque => (ALPHA_OPAQUE, 1.0),
        AlphaMode::Mask { cutoff } => (ALPHA_MASK, least_coverage(material, cutoff)),
        AlphaMode::Blend => (ALPHA_BLEND, material.alpha),
    };
    GpuMaterial {
        base_color,
        metallic: material.metallic,
        dielectric_f0: f0,
        dielectric_f90: material.specular,
        roughness: material.roughness,
        base_color_texture: NONE,
        metallic_roughness_texture: NONE,
        flags: flags | culled,
        normal_texture: NONE,
        normal_scale: material.normal_scale,
        alpha_mode,
        alpha,
    }
}

/// Converts the layers of a material to the form that shaders read. `length` is the length, in the scene's unit, that is
/// stored as 1 on the device. `texture` stores a texture and returns its index on the device, or NONE.
pub fn gpu_layers(
    material: &Material,
    length: f64,
    mut texture: impl FnMut(&Option<Texture>) -> u32,
) -> GpuMaterialLayers {
    let Layers {
        coat,
        anisotropy,
        transmission,
        volume,
        dispersion,
    } = &material.layers;
    let has_volume = volume.thickness > 0.0;
    let absorption = |color: f32| {
        if !has_volume {
            return -1.0;
        }
        // A colour of 0 would need an infinite coefficient.
        let density = -f64::from(color.max(f32::MIN_POSITIVE)).ln();
        let absorbed = density * length / f64::from(volume.attenuation_distance);
        absorbed.min(f32::MAX.into()) as f32
    };
    let color = volume.attenuation_color;
    let turns = f64::from(anisotropy.rotation) / TAU;
    GpuMaterialLayers {
        coat: coat.factor,
        coat_roughness: coat.roughness,
        anisotropy: anisotropy.strength,
        transmission: transmission.factor,
        anisotropy_turns: turns.rem_euclid(1.0) as f32,
        ior: material.ior,
        absorption: Vec3::new(
            absorption(color.x),
            absorption(color.y),
            absorption(color.z),
        ),
        dispersion: *dispersion,
        coat_texture: texture(&coat.texture),
        coat_roughness_texture: texture(&coat.roughness_texture),
        coat_normal_texture: texture(&coat.normal_texture),
        coat_normal_scale: coat.normal_scale,
        anisotropy_texture: texture(&anisotropy.texture),
        transmission_texture: texture(&transmission.texture),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::layers::Volume;

    #[test]
    fn masks_cover_at_their_cutoff_and_not_below() {
        for step in 1..1000_u16 {
            let cutoff = f32::from(step) / 1000.0;
            for alpha in [
                1.0,
                cutoff,
                cutoff.next_up(),
                cutoff.next_down(),
                0.3,
                1e-30,
            ] {
                let material = Material {
                    alpha,
                    ..Material::default()
                };
                let least = least_coverage(&material, cutoff);
                assert!(alpha * least >= cutoff, "{alpha} {cutoff}: {least}");
                assert!(
                    alpha * least.next_down() < cutoff,
                    "{alpha} {cutoff}: {least}"
                );
            }
        }
        let clear = Material {
            alpha: 0.0,
            ..Material::default()
        };
        assert_eq!(least_coverage(&clear, 0.5), f32::INFINITY);
    }

    #[test]
    fn volumes_absorb_by_their_distance_and_sheets_do_not() {
        let mut material = Material::default();
        material.layers.volume = Volume {
            thickness: 1.0,
            attenuation_distance: 2.0,
            attenuation_color: Vec3::new(0.5, 1.0, 0.0),
        };
        // A unit of 4: two scene units are half of it.
        let absorption = gpu_layers(&material, 4.0, |_| NONE).absorption;
        assert!((absorption.x - 2.0 * 2.0_f32.ln()).abs() < 1e-6);
        assert_eq!(absorption.y, 0.0);
        assert!(absorption.z > 100.0 && absorption.z.is_finite());
        material.layers.volume.attenuation_distance = f32::INFINITY;
        assert_eq!(gpu_layers(&material, 4.0, |_| NONE).absorption, Vec3::ZERO);
        material.layers.volume.thickness = 0.0;
        assert!(gpu_layers(&material, 4.0, |_| NONE).absorption.x < 0.0);
    }
}
