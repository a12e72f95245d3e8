//! Writes materials as glTF JSON, with the textures, samplers and images that they use.

use super::{Binary, color_and_strength};
use crate::scene::layers::{Anisotropy, Coat, Transmission, Volume};
use crate::scene::texture::Wrap;
use crate::scene::{AlphaMode, Image, Layers, Material, Texture};
use crate::scene_files::gltf::SEEN_FROM_BEHIND;
use crate::{Error, Result};
use glam::{Affine2, Vec2, Vec3};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Map, Value, json};

/// The name of the glTF extension for textures whose coordinates are scaled, rotated or moved. A file that uses it must list
/// it among its extensions.
pub const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

/// The glTF JSON of one material, which becomes an element of the list `materials` of the file. The textures
/// and samplers that the material uses are added to `textures`.
pub fn material(material: &Material, textures: &mut Textures) -> Value {
    let mut surface = json!({
        "baseColorFactor": material.base_color.extend(material.alpha).to_array(),
        "metallicFactor": material.metallic,
        "roughnessFactor": material.roughness,
    });
    textures.add(
        &mut surface,
        "baseColorTexture",
        &material.base_color_texture,
    );
    textures.add(
        &mut surface,
        "metallicRoughnessTexture",
        &material.metallic_roughness_texture,
    );
    let mut value = json!({ "name": material.name, "pbrMetallicRoughness": surface });
    textures.add(&mut value, "normalTexture", &material.normal_texture);
    if material.normal_texture.is_some() && material.normal_scale != 1.0 {
        value["normalTexture"]["scale"] = json!(material.normal_scale);
    }
    textures.add(&mut value, "emissiveTexture", &material.emissive_texture);
    match material.alpha_mode {
        AlphaMode::Opaque => {}
        AlphaMode::Mask { cutoff } => {
            value["alphaMode"] = json!("MASK");
            value["alphaCutoff"] = json!(cutoff);
        }
        AlphaMode::Blend => value["alphaMode"] = json!("BLEND"),
    }
    if material.double_sided {
        value["doubleSided"] = json!(true);
    } else if !material.culled {
        value["extras"] = json!({ SEEN_FROM_BEHIND: true });
    }
    let mut extensions = Map::new();
    if material.is_emissive() {
        let (color, strength) = color_and_strength(material.emission);
        value["emissiveFactor"] = json!(color.to_array());
        if strength > 1.0 {
            extensions.insert(
                "KHR_materials_emissive_strength".into(),
                json!({ "emissiveStrength": strength }),
            );
        }
    }
    if material.unlit {
        extensions.insert("KHR_materials_unlit".into(), json!({}));
    } else if material.specular != 1.0
        || material.specular_color != Vec3::ONE
        || material.has_specular_textures()
    {
        let mut specular = json!({
            "specularFactor": material.specular,
            "specularColorFactor": material.specular_color.to_array(),
        });
        textures.add(&mut specular, "specularTexture", &material.specular_texture);
        textures.add(
            &mut specular,
            "specularColorTexture",
            &material.specular_color_texture,
        );
        extensions.insert("KHR_materials_specular".into(), specular);
    }
    if material.ior != 1.5 {
        extensions.insert("KHR_materials_ior".into(), json!({ "ior": material.ior }));
    }
    add_layers(&material.layers, &mut extensions, textures);
    if !extensions.is_empty() {
        value["extensions"] = Value::Object(extensions);
    }
    value
}

/// Adds the extensions of the layers that a material has to `extensions`, those of the material.
fn add_layers(layers: &Layers, extensions: &mut Map<String, Value>, textures: &mut Textures) {
    let Layers {
        coat,
        anisotropy,
        transmission,
        volume,
        dispersion,
    } = layers;
    if *coat != Coat::default() {
        let mut value = json!({
            "clearcoatFactor": coat.factor, "clearcoatRoughnessFactor": coat.roughness,
        });
        textures.add(&mut value, "clearcoatTexture", &coat.texture);
        textures.add(
            &mut value,
            "clearcoatRoughnessTexture",
            &coat.roughness_texture,
        );
        textures.add(&mut value, "clearcoatNormalTexture", &coat.normal_texture);
        if coat.normal_texture.is_some() && coat.normal_scale != 1.0 {
            value["clearcoatNormalTexture"]["scale"] = json!(coat.normal_scale);
        }
        extensions.insert("KHR_materials_clearcoat".into(), value);
    }
    if *anisotropy != Anisotropy::default() {
        let mut value = json!({
            "anisotropyStrength": anisotropy.strength, "anisotropyRotation": anisotropy.rotation,
        });
        textures.add(&mut value, "anisotropyTexture", &anisotropy.texture);
        extensions.insert("KHR_materials_anisotropy".into(), value);
    }
    if *transmission != Transmission::default() {
        let mut value = json!({ "transmissionFactor": transmission.factor });
        textures.add(&mut value, "transmissionTexture", &transmission.texture);
        extensions.insert("KHR_materials_transmission".into(), value);
    }
    if *volume != Volume::default() {
        let mut value = json!({
            "thicknessFactor": volume.thickness,
            "attenuationColor": volume.attenuation_color.to_array(),
        });
        // JSON has no infinity, which is the default.
        if volume.attenuation_distance.is_finite() {
            value["attenuationDistance"] = json!(volume.attenuation_distance);
        }
        extensions.insert("KHR_materials_volume".into(), value);
    }
    if *dispersion != 0.0 {
        let value = json!({ "dispersion": dispersion });
        extensions.insert("KHR_materials_dispersion".into(), value);
    }
}

/// The JSON of all textures of the file, and of their samplers (filters and wrap modes). Both lists are
/// filled while materials are written, and an equal texture or sampler is stored only once. Materials refer
/// to textures by their indices.
#[derive(Default)]
pub struct Textures {
    pub textures: Vec<Value>,
    pub samplers: Vec<Value>,
    /// True if the coordinates of some texture are transformed, so that the file must list [`TEXTURE_TRANSFORM`] among its
    /// extensions.
    pub has_transform: bool,
}

impl Textures {
    /// Adds a texture, with its sampler, to the JSON of the file. `user` is the JSON of a material or of an object in a
    /// material; its member `slot`, such as `normalTexture`, becomes a reference to the texture. If `texture` is `None`,
    /// nothing changes.
    fn add(&mut self, user: &mut Value, slot: &str, texture: &Option<Texture>) {
        let Some(texture) = texture else { return };
        let filter = if texture.nearest { 9728 } else { 9729 };
        let [wrap_s, wrap_t] = texture.wrap.map(|wrap| match wrap {
            Wrap::Repeat => 10497,
            Wrap::Mirror => 33648,
            Wrap::Clamp => 33071,
        });
        let sampler = json!({
            "magFilter": filter, "minFilter": filter, "wrapS": wrap_s, "wrapT": wrap_t,
        });
        let sampler = index_of(&mut self.samplers, sampler);
        let source = json!({ "source": texture.image, "sampler": sampler });
        let mut info = json!({ "index": index_of(&mut self.textures, source) });
        if texture.set != 0 {
            info["texCoord"] = json!(texture.set);
        }
        if texture.transform != Affine2::IDENTITY {
            self.has_transform = true;
            info["extensions"][TEXTURE_TRANSFORM] = transform(&texture.transform);
        }
        user[slot] = info;
    }
}

/// The index of `value` in `list`, by which other JSON refers to it. If the list does not contain the value, it is appended
/// first, so that equal values are stored once.
fn index_of(list: &mut Vec<Value>, value: Value) -> usize {
    let found = list.iter().position(|other| *other == value);
    found.unwrap_or_else(|| {
        list.push(value);
        list.len() - 1
    })
}

/// The value of the extension [`TEXTURE_TRANSFORM`] for a transform of texture coordinates: offset, rotation in radians
/// (positive turns +u towards −v) and scale. The coordinates are scaled first, then rotated, then moved. This form cannot
/// express shear, which is lost.
fn transform(placed: &Affine2) -> Value {
    let [u, v] = [placed.matrix2.x_axis, placed.matrix2.y_axis];
    let mirrored = placed.matrix2.determinant() < 0.0;
    let scale = Vec2::new(u.length(), v.length() * if mirrored { -1.0 } else { 1.0 });
    json!({
        "offset": placed.translation.to_array(),
        "rotation": (-u.y).atan2(u.x),
        "scale": scale.to_array(),
    })
}

/// Writes the images as PNG files into `binary`, the binary chunk, and returns the JSON of each image, in the order of
/// `images`. Fails if the number of texels of an image is not width × height, or if the image cannot be encoded.
pub fn images(images: &[Image], binary: &mut Binary) -> Result<Vec<Value>> {
    let write = |image: &Image| {
        let mut png = Vec::new();
        let encoder = PngEncoder::new(&mut png);
        let count = image.width as usize * image.height as usize;
        let (deep, texels, color);
        if image.is_deep() {
            deep = (0..count).map(|i| image.texel(i)).collect::<Vec<_>>();
            (texels, color) = (bytemuck::cast_slice(&deep), ExtendedColorType::Rgba16);
        } else {
            (texels, color) = (image.texels.as_flattened(), ExtendedColorType::Rgba8);
        }
        (texels.len() == count * usize::from(color.bits_per_pixel()) / 8)
            .then(|| encoder.write_image(texels, image.width, image.height, color))
            .ok_or_else(|| {
                Error::input(format!("image {}: its texels do not fill it", image.name))
            })?
            .map_err(|e| Error::failed(format!("image {}: cannot be encoded: {e}", image.name)))?;
        let view = binary.push_bytes(&png);
        Ok(json!({ "name": image.name, "mimeType": "image/png", "bufferView": view }))
    };
    images.iter().map(write).collect()
}
