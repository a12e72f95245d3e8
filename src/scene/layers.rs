//! Properties of a material beyond the metallic-roughness model, from the glTF extensions `KHR_materials_clearcoat`,
//! `KHR_materials_anisotropy`, `KHR_materials_transmission`, `KHR_materials_volume` and `KHR_materials_dispersion`. Most
//! materials have none of them.

use super::Texture;
use crate::shader_interface::MIRROR_ROUGHNESS;
use glam::Vec3;

/// The properties of a material beyond the metallic-roughness model. With the default, the material has none of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// A transparent layer of varnish on top of the surface.
    pub coat: Coat,
    /// A specular lobe that is wider in one direction, as that of brushed metal.
    pub anisotropy: Anisotropy,
    /// Light that passes through the surface of a dielectric.
    pub transmission: Transmission,
    /// The substance behind the surface.
    pub volume: Volume,
    /// The strength of dispersion, at least 0: 20 divided by the Abbe number of the substance. 0: all colours have the same
    /// index of refraction. It has an effect only with transmission and a volume.
    pub dispersion: f32,
}

/// A clear coat (`KHR_materials_clearcoat`): a dielectric layer on top of the surface, which reflects by Fresnel's law with
/// the index 1.5 and weakens what lies below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Coat {
    /// Fraction of the surface that is coated, in [0, 1]; 0: there is no coat. The red channel of `texture` multiplies it.
    pub factor: f32,
    /// Linear texture whose red channel multiplies `factor`; `None` leaves it unchanged.
    pub texture: Option<Texture>,
    /// Perceptual roughness of the coat, in [0, 1]. The green channel of `roughness_texture` multiplies it.
    pub roughness: f32,
    /// Linear texture whose green channel multiplies `roughness`; `None` leaves it unchanged.
    pub roughness_texture: Option<Texture>,
    /// Normal map of the coat. `None`: the coat has the normal of the mesh, also if the surface below has a normal map.
    pub normal_texture: Option<Texture>,
    /// Factor on the tangent and bitangent components of the coat's normal map, finite.
    pub normal_scale: f32,
}

impl Default for Coat {
    /// No coat.
    fn default() -> Self {
        Self {
            factor: 0.0,
            texture: None,
            roughness: 0.0,
            roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
        }
    }
}

/// Anisotropy of the specular lobe (`KHR_materials_anisotropy`): along one direction in the surface, the lobe is wider.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Anisotropy {
    /// Strength in [0, 1]: along the direction, the width α of the GGX lobe is mixed with 1 by the square of the strength. 0:
    /// the lobe has the same width in all directions. The blue channel of `texture` multiplies it.
    pub strength: f32,
    /// Angle in radians from the tangent to the direction, counter-clockwise seen from the front (towards the bitangent). It
    /// is finite.
    pub rotation: f32,
    /// Linear texture: red and green, mapped from [0, 1] to [−1, 1], are the direction in the tangent frame, to which
    /// `rotation` is added; blue multiplies `strength`. `None`: the direction is the tangent, before the rotation.
    pub texture: Option<Texture>,
}

/// Transmission (`KHR_materials_transmission`): light of the dielectric that is not reflected passes through the surface
/// instead of the diffuse lobe.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transmission {
    /// Fraction in [0, 1] of the unreflected light that is transmitted; the diffuse lobe gets the rest. The red channel of
    /// `texture` multiplies it.
    pub factor: f32,
    /// Linear texture whose red channel multiplies `factor`; `None` leaves it unchanged.
    pub texture: Option<Texture>,
}

/// The substance behind a transmitting surface (`KHR_materials_volume`).
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Thickness in the mesh's unit of length, at least 0. 0: the surface is a thin sheet without a volume. Rays find the
    /// thickness of a volume by themselves, so that all values above 0 mean the same, and textures of the thickness are not
    /// read.
    pub thickness: f32,
    /// Distance in scene units, above 0, at which white light has the colour `attenuation_color`; infinite: the substance
    /// absorbs nothing.
    pub attenuation_distance: f32,
    /// Linear RGB colour in [0, 1] that white light has after `attenuation_distance`.
    pub attenuation_color: Vec3,
}

impl Default for Volume {
    /// A thin sheet.
    fn default() -> Self {
        Self {
            thickness: 0.0,
            attenuation_distance: f32::INFINITY,
            attenuation_color: Vec3::ONE,
        }
    }
}

impl Coat {
    /// True if there is a coat that may be treated as a perfect mirror: its roughness is below [`MIRROR_ROUGHNESS`], or it has
    /// a roughness texture, which may lower the roughness.
    pub fn is_smooth(&self) -> bool {
        self.factor > 0.0 && (self.roughness < MIRROR_ROUGHNESS || self.roughness_texture.is_some())
    }
}

impl Layers {
    /// The textures of all layers, each with the name of its slot, for messages; `None` where there is no texture.
    pub fn textures(&self) -> [(&'static str, &Option<Texture>); 5] {
        [
            ("clear coat texture", &self.coat.texture),
            ("clear coat roughness texture", &self.coat.roughness_texture),
            ("clear coat normal texture", &self.coat.normal_texture),
            ("anisotropy texture", &self.anisotropy.texture),
            ("transmission texture", &self.transmission.texture),
        ]
    }

    /// True if a texture changes a value of a layer from point to point. Normal maps do not count.
    pub fn has_textures(&self) -> bool {
        self.coat.texture.is_some()
            || self.coat.roughness_texture.is_some()
            || self.anisotropy.texture.is_some()
            || self.transmission.texture.is_some()
    }

    /// True if the surface is the boundary of a volume that light enters.
    pub fn bounds_a_volume(&self) -> bool {
        self.transmission.factor > 0.0 && self.volume.thickness > 0.0
    }

    /// True if the picture can differ from that of the same material without layers. Volume and dispersion have an effect
    /// only with transmission.
    pub fn are_seen(&self) -> bool {
        self.coat.factor > 0.0 || self.anisotropy.strength > 0.0 || self.transmission.factor > 0.0
    }
}
