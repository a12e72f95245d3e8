//! The surface model of glTF 2.0, appendix B, and the sampling of its lobes.

use super::LUMINANCE;
use super::random::Draws;
use glam::DVec3;
use headwater::scene::Material;
use std::f64::consts::{PI, TAU};

/// The perceptual roughness below which the specular lobe is treated as a perfect mirror.
const MIRROR_ROUGHNESS: f64 = 1e-3;

/// The parameters of the surface model for one material, derived from the material's values.
pub struct Surface {
    base_color: DVec3,
    metallic: f64,
    alpha: f64,
    mirror: bool,
    dielectric_f0: DVec3,
    dielectric_f90: f64,
    pub emission: DVec3,
    double_sided: bool,
    /// Density of light samples on this material's triangles, per area; 0 if the material does not emit.
    pub light_pdf_area: f64,
}

pub struct Sampled {
    pub direction: DVec3,
    /// The BSDF × cosine / density of the sampled direction, by which a path's throughput is multiplied.
    pub weight: DVec3,
    /// Density of the direction per solid angle; `None` for a perfect mirror.
    pub pdf_solid_angle: Option<f64>,
}

impl Surface {
    pub fn has_specular_lobe(&self) -> bool {
        self.metallic > 0.0 || self.dielectric_f90 > 0.0
    }

    pub fn new(material: &Material) -> Self {
        let roughness = f64::from(material.roughness);
        let ior = f64::from(material.ior);
        let specular = f64::from(material.specular);
        let normal_incidence = ((ior - 1.0) / (ior + 1.0)).powi(2);
        let tinted = material.specular_color.as_dvec3() * normal_incidence;
        Self {
            base_color: material.base_color.as_dvec3(),
            metallic: f64::from(material.metallic),
            alpha: roughness * roughness,
            mirror: roughness < MIRROR_ROUGHNESS,
            dielectric_f0: tinted.min(DVec3::ONE) * specular,
            dielectric_f90: specular,
            emission: material.emission.as_dvec3(),
            double_sided: material.double_sided,
            light_pdf_area: 0.0,
        }
    }

    /// True if the surface emits towards a direction whose cosine with the front normal is `facing`.
    pub fn emits(&self, facing: f64) -> bool {
        self.emission != DVec3::ZERO && (facing > 0.0 || (self.double_sided && facing < 0.0))
    }

    /// Fresnel reflectance (RGB) at the cosine between direction and half vector: of the dielectric, and of the whole
    /// specular lobe (Schlick 1994).
    fn fresnel(&self, cosine: f64) -> (DVec3, DVec3) {
        let grazing = (1.0 - cosine).clamp(0.0, 1.0).powi(5);
        let schlick = |f0: DVec3, f90: f64| f0 * (1.0 - grazing) + DVec3::splat(f90 * grazing);
        let dielectric = schlick(self.dielectric_f0, self.dielectric_f90);
        let metal = schlick(self.base_color, 1.0);
        (dielectric, dielectric.lerp(metal, self.metallic))
    }

    /// The value of the BSDF (RGB, per steradian, without the cosine) for two directions in the shading frame. A mirror's
    /// lobe is left out.
    pub fn evaluate(&self, outgoing: DVec3, incoming: DVec3) -> DVec3 {
        if outgoing.z <= 0.0 || incoming.z <= 0.0 {
            return DVec3::ZERO;
        }
        let half = (outgoing + incoming).normalize();
        let (dielectric, specular) = self.fresnel(outgoing.dot(half));
        let under = (1.0 - self.metallic) * (1.0 - dielectric.max_element());
        let mut f = self.base_color * (under / PI);
        if !self.mirror {
            // V of glTF 2.0, appendix B: Smith's masking, correlated by height, over 4 cos cos.
            let v = 0.5
                / (incoming.z * self.stretched(outgoing.z)
                    + outgoing.z * self.stretched(incoming.z));
            f += specular * (self.distribution(half.z) * v);
        }
        f
    }

    /// The term √(cos² (1 − α²) + α²) of Smith's masking function; α is the GGX width.
    fn stretched(&self, cosine: f64) -> f64 {
        let a2 = self.alpha * self.alpha;
        (cosine * cosine * (1.0 - a2) + a2).sqrt()
    }

    /// The density of GGX half vectors, per solid angle, at the cosine between half vector and normal (Trowbridge and Reitz
    /// 1975; Walter et al. 2007).
    fn distribution(&self, cosine: f64) -> f64 {
        let a2 = self.alpha * self.alpha;
        let d = cosine * cosine * (a2 - 1.0) + 1.0;
        a2 / (PI * d * d)
    }

    /// Probability, in [0, 1], with which [`Self::sample`] samples the specular lobe instead of the diffuse one.
    pub fn specular_probability(&self, outgoing: DVec3) -> f64 {
        if !self.has_specular_lobe() {
            return 0.0;
        }
        let (dielectric, specular) = self.fresnel(outgoing.z);
        let below = self.base_color * (1.0 - self.metallic) * (1.0 - dielectric.max_element());
        if self.metallic == 1.0 || self.base_color == DVec3::ZERO {
            return 1.0;
        }
        let (specular, below) = (specular.dot(LUMINANCE), below.dot(LUMINANCE));
        (specular / (specular + below)).clamp(0.15, 0.85)
    }

    /// Density, per solid angle, with which [`Self::sample`] draws `incoming`. A mirror's lobe is left out.
    pub fn pdf_solid_angle(&self, outgoing: DVec3, incoming: DVec3) -> f64 {
        let chance = self.specular_probability(outgoing);
        let mut pdf = (1.0 - chance) * incoming.z / PI;
        if !self.mirror && chance > 0.0 {
            // Visible normals, G1 D (o·h) / o.z, over the reflection's 4 (o·h).
            let half = (outgoing + incoming).normalize();
            let visible = 2.0 * (outgoing.z + self.stretched(outgoing.z));
            pdf += chance * self.distribution(half.z) / visible;
        }
        pdf
    }

    pub fn sample(&self, outgoing: DVec3, random: &mut Draws) -> Option<Sampled> {
        let chance = self.specular_probability(outgoing);
        let (lobe, u, v) = (random.unit(), random.unit(), random.unit());
        let direction = if lobe < chance {
            if self.mirror {
                let (_, specular) = self.fresnel(outgoing.z);
                return Some(Sampled {
                    direction: DVec3::new(-outgoing.x, -outgoing.y, outgoing.z),
                    weight: specular / chance,
                    pdf_solid_angle: None,
                });
            }
            let half = self.visible_normal(outgoing, u, v);
            half * (2.0 * outgoing.dot(half)) - outgoing
        } else {
            // Cosine-weighted (Malley's method).
            let (sin, cos) = (TAU * v).sin_cos();
            DVec3::new(u.sqrt() * cos, u.sqrt() * sin, (1.0 - u).sqrt())
        };
        if direction.z <= 0.0 {
            return None;
        }
        let pdf = self.pdf_solid_angle(outgoing, direction);
        Some(Sampled {
            direction,
            weight: self.evaluate(outgoing, direction) * (direction.z / pdf),
            pdf_solid_angle: Some(pdf),
        })
    }

    /// A random microfacet normal that is visible from `outgoing`, from two uniform numbers (Heitz, "Sampling the GGX
    /// Distribution of Visible Normals", 2018).
    fn visible_normal(&self, outgoing: DVec3, u: f64, v: f64) -> DVec3 {
        let alpha = DVec3::new(self.alpha, self.alpha, 1.0);
        let view = (outgoing * alpha).normalize();
        let flat = view.x * view.x + view.y * view.y;
        let across = if flat > 0.0 {
            DVec3::new(-view.y, view.x, 0.0) / flat.sqrt()
        } else {
            DVec3::X
        };
        let up = view.cross(across);
        let (sin, cos) = (TAU * v).sin_cos();
        let (x, y) = (u.sqrt() * cos, u.sqrt() * sin);
        let s = 0.5 * (1.0 + view.z);
        let y = (1.0 - s) * (1.0 - x * x).sqrt() + s * y;
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let normal = across * x + up * y + view * z;
        (normal * alpha).with_z(normal.z.max(0.0)).normalize()
    }
}
