//! Checks of materials, of their uses of textures, and of images. A scene that fails one of them is refused before it is
//! rendered.

use super::layers::check_layers;
use super::{BRIGHTEST, is_within};
use crate::scene::notices::{Tally, label};
use crate::scene::{AlphaMode, Image, Material};
use crate::{Error, Result};
use glam::Vec3;

/// The largest index of refraction; larger ones are clamped to it. It is beyond any substance, and reflects 99.96 % of the
/// light. With far larger ones, the reflectance is 1 in f32, and the share of Fresnel's term above it becomes 0/0.
const LARGEST_INDEX: f32 = 1e4;

/// Checks that a material's numbers are in range, and fails at the first that is not. A base colour outside [0, 1] and an index
/// of refraction outside its range are clamped instead, with a notice in `tally`. A mask with the cutoff 0, which has no holes, becomes opaque. `index` is the
/// material's index in the scene, for messages.
pub(super) fn check_material(
    index: usize,
    material: &mut Material,
    tally: &mut Tally,
) -> Result<()> {
    let what = label("material", index, &material.name);
    let Material {
        name: _,
        base_color,
        base_color_texture: _,
        alpha,
        alpha_mode,
        metallic,
        roughness,
        metallic_roughness_texture: _,
        normal_texture: _,
        normal_scale,
        specular,
        specular_color,
        specular_texture: _,
        specular_color_texture: _,
        ior,
        layers,
        unlit: _,
        emission,
        emissive_texture: _,
        double_sided: _,
        culled: _,
    } = material;
    let wrong = |factor: &str, value: &dyn std::fmt::Display, range: &str| {
        Err(Error::input(format!(
            "{what}: {factor} is {value}; it must be {range}"
        )))
    };
    if !base_color.is_finite() {
        return wrong("base colour", base_color, "finite");
    }
    if let AlphaMode::Mask { cutoff } = alpha_mode {
        if !(0.0..=f32::MAX).contains(cutoff) {
            return wrong("alpha cutoff", cutoff, "at least 0");
        }
        // Then nothing is cut out.
        if *cutoff == 0.0 {
            *alpha_mode = AlphaMode::Opaque;
        }
    }
    for (factor, value) in [
        ("alpha", *alpha),
        ("metallic", *metallic),
        ("roughness", *roughness),
        ("specular", *specular),
    ] {
        if !(0.0..=1.0).contains(&value) {
            return wrong(factor, &value, "within 0 and 1");
        }
    }
    if !normal_scale.is_finite() {
        return wrong("the scale of the normal texture", normal_scale, "finite");
    }
    if !specular_color.is_finite() || specular_color.min_element() < 0.0 {
        return wrong("specular colour", specular_color, "finite and not negative");
    }
    if !is_within(*emission, BRIGHTEST) {
        return wrong("emission", emission, "within 0 and 1e12");
    }
    if !ior.is_finite() || *ior < 0.0 {
        return wrong("index of refraction", ior, "finite and at least 1 (or 0)");
    }
    if *ior != 0.0 && *ior < 1.0 {
        *ior = 1.0;
        tally.add("indices of refraction below 1 become 1", || what.clone());
    }
    if *ior > LARGEST_INDEX {
        *ior = LARGEST_INDEX;
        tally.add("indices of refraction above 10000 become 10000", || {
            what.clone()
        });
    }
    check_layers(&what, layers, tally)?;
    let clamped = base_color.clamp(Vec3::ZERO, Vec3::ONE);
    if clamped != *base_color {
        *base_color = clamped;
        tally.add("base colours outside [0, 1] are clamped", || what);
    }
    Ok(())
}

/// Checks each texture of a material: its image exists in `images`, the scene's images; its set of texture coordinates is 0
/// or 1; its transform is finite. Fails at the first fault. `index` is the material's index in the scene, for messages.
pub(super) fn check_textures(index: usize, material: &Material, images: &[Image]) -> Result<()> {
    for (name, texture) in material.textures() {
        let wrong = |fault: String| {
            let what = label("material", index, &material.name);
            Err(Error::input(format!("{what}: its {name} {fault}")))
        };
        if texture.image as usize >= images.len() {
            return wrong(format!(
                "has image {}, but there are {}",
                texture.image,
                images.len()
            ));
        }
        if texture.set > 1 {
            return wrong(format!(
                "uses texture coordinates {}; only 0 and 1 exist",
                texture.set
            ));
        }
        if !texture.transform.is_finite() {
            return wrong(
                "has a transform that is not finite; correct it in the modelling tool".into(),
            );
        }
    }
    Ok(())
}

/// Checks that the width and the height of an image are not 0, and that it has width × height texels, of one entry each or
/// of two in an image with 16 bits per channel; otherwise fails.
/// `index` is the image's index in the scene, for messages.
pub(super) fn check_image(index: usize, image: &Image) -> Result<()> {
    let texels = u64::from(image.width) * u64::from(image.height);
    if texels == 0 || ![texels, 2 * texels].contains(&(image.texels.len() as u64)) {
        return Err(Error::input(format!(
            "{}: has {} texels for {} × {}",
            label("image", index, &image.name),
            image.texels.len(),
            image.width,
            image.height
        )));
    }
    Ok(())
}
