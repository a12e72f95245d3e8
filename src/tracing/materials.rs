//! Materials as shaders read them.

use crate::layouts::GpuMaterial;
use crate::scene::Material;
use glam::{UVec3, Vec3};

/// A material as shaders read it.
pub fn gpu_material(material: &Material) -> GpuMaterial {
    // KHR_materials_ior: an index of 0 stands for a reflectance of 1 at every angle.
    let normal_reflectance = if material.ior == 0.0 {
        1.0
    } else {
        ((material.ior - 1.0) / (material.ior + 1.0)).powi(2)
    };
    let f0 = (normal_reflectance * material.specular_color).min(Vec3::ONE) * material.specular;
    GpuMaterial {
        base_color: material.base_color,
        metallic: material.metallic,
        dielectric_f0: f0,
        dielectric_f90: material.specular,
        roughness: material.roughness,
        padding: UVec3::ZERO,
    }
}
