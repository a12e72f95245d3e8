//! Materials of procedural scenes, made by functions of a few parameters, so that a scene need not state every property of a
//! material.

use crate::scene::layers::{Anisotropy, Coat};
use crate::scene::{Layers, Material};
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

/// The material `base` under a clear coat of the perceptual roughness `roughness` in [0, 1].
pub fn coated(base: Material, roughness: f32) -> Material {
    let coat = Coat {
        factor: 1.0,
        roughness,
        ..Coat::default()
    };
    let layers = Layers {
        coat,
        ..base.layers
    };
    Material { layers, ..base }
}

/// The material `base` with a specular lobe that is wider along the tangent, by a strength in [0, 1].
pub fn brushed(base: Material, strength: f32) -> Material {
    let anisotropy = Anisotropy {
        strength,
        ..Anisotropy::default()
    };
    let layers = Layers {
        anisotropy,
        ..base.layers
    };
    Material { layers, ..base }
}

/// A material that emits `radiance` (linear RGB, in W/(m²·sr)), and also reflects half of the incident light as a grey
/// Lambertian surface.
pub fn emitter(name: &str, radiance: Vec3) -> Material {
    Material {
        emission: radiance,
        ..Material::lambert(name, Vec3::splat(0.5))
    }
}
