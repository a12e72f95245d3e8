//! Materials of most things in procedural scenes.

use crate::scene::Material;
use glam::Vec3;

/// A dielectric.
pub fn dielectric(name: &str, color: Vec3, roughness: f32) -> Material {
    Material {
        name: name.into(),
        base_color: color,
        metallic: 0.0,
        roughness,
        ..Material::default()
    }
}

/// A metal.
pub fn metal(name: &str, color: Vec3, roughness: f32) -> Material {
    Material {
        name: name.into(),
        base_color: color,
        roughness,
        ..Material::default()
    }
}

/// An emitter that also reflects, as a grey Lambertian surface.
pub fn emitter(name: &str, radiance: Vec3) -> Material {
    Material {
        emission: radiance,
        ..Material::lambert(name, Vec3::splat(0.5))
    }
}
