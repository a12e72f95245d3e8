//! Materials of procedural scenes, made by functions of a few parameters, so that a scene need not state every property of a
//! material.

use crate::scene::Material;
use glam::Vec3;

/// A dielectric material, such as stone, wood or paint, with the diffuse colour `color` (linear RGB) and a
/// specular lobe of the perceptual roughness `roughness` in [0, 1].
pub fn dielectric(name: &str, color: Vec3, roughness: f32) -> Material {
    Material {
        name: name.into(),
        base_color: color,
        metallic: 0.0,
        roughness,
        ..Material::default()
    }
}

/// A metal, such as gold or steel, with the reflectance `color` (linear RGB) at normal incidence and the
/// perceptual roughness `roughness` in [0, 1].
pub fn metal(name: &str, color: Vec3, roughness: f32) -> Material {
    Material {
        name: name.into(),
        base_color: color,
        roughness,
        ..Material::default()
    }
}

/// A material that emits `radiance` (linear RGB, in W/(m²·sr)), and also reflects half of the incident light as a grey
/// Lambertian surface.
pub fn emitter(name: &str, radiance: Vec3) -> Material {
    Material {
        emission: radiance,
        ..Material::lambert(name, Vec3::splat(0.5))
    }
}
