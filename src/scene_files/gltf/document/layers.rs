//! Types for the extensions of materials that add layers to a surface.

use super::TextureInfo;
use serde::Deserialize;

/// The extension `KHR_materials_clearcoat`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct ClearCoat {
    pub clearcoat_factor: f32,
    pub clearcoat_texture: Option<TextureInfo>,
    pub clearcoat_roughness_factor: f32,
    pub clearcoat_roughness_texture: Option<TextureInfo>,
    pub clearcoat_normal_texture: Option<TextureInfo>,
}

/// The extension `KHR_materials_anisotropy`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Anisotropy {
    pub anisotropy_strength: f32,
    pub anisotropy_rotation: f32,
    pub anisotropy_texture: Option<TextureInfo>,
}

/// The extension `KHR_materials_transmission`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Transmission {
    pub transmission_factor: f32,
    pub transmission_texture: Option<TextureInfo>,
}

/// The extension `KHR_materials_volume`. Its texture is left out, because rays find the thickness by themselves.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Volume {
    pub thickness_factor: f32,
    /// `None` counts as infinite.
    pub attenuation_distance: Option<f32>,
    pub attenuation_color: [f32; 3],
}

impl Default for Volume {
    fn default() -> Self {
        Self {
            thickness_factor: 0.0,
            attenuation_distance: None,
            attenuation_color: [1.0; 3],
        }
    }
}

/// The extension `KHR_materials_dispersion`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Dispersion {
    pub dispersion: f32,
}
