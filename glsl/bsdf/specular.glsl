#pragma once
// The specular lobe of glTF 2.0, appendix B, with KHR_materials_specular, KHR_materials_ior and KHR_materials_anisotropy: GGX
// (α = roughness², height-correlated Smith, Schlick's Fresnel), a mix of a dielectric and a metal; a perfect mirror below
// MIRROR_ROUGHNESS. An anisotropic lobe is wider along the tangent of the shading frame, and never a mirror.
//
// ENERGY_COMPENSATED corrects two errors of energy (Turquin, "Practical multiple scattering compensation for microfacet
// models", 2019): rough metals lose some, because only single scattering is modelled; bright dielectrics gain some at
// grazing angles, because base and lobe are mixed without regard to what the lobe reflects. An anisotropic lobe is compensated
// as an isotropic one of about the same albedo.
#include "bsdf/microfacets.glsl"

// Directional albedo of the specular lobe: ALBEDO_CELLS + 1 nodes a side, roughness-major; x is the part scaled by F0,
// y the part scaled by F90.
layout(scalar) readonly buffer AlbedoBlock { vec2 at[]; } specular_albedo;

struct SpecularLobe {
    float choice;
    vec3 dielectric_f0;
    float dielectric_f90;
    vec3 metal_f0;
    float metallic;
    // GGX width; 0 = a perfect mirror. Of an anisotropic lobe the geometric mean of its widths.
    float alpha;
    // With HAS_ANISOTROPY, the widths along the tangent and the bitangent.
    vec2 widths;
    // Energy compensation of both parts; 1 without.
    vec3 dielectric_scale;
    vec3 metal_scale;
    // At the boundary of a volume, the index of refraction beyond it, relative to that of the viewer's side: the dielectric then
    // has the exact Fresnel term, and no compensation. 0 for other surfaces.
    float index;
    // With compensation, the fraction that the dielectric part leaves to the lobes below; unused without.
    float passes;
};

// The least width across an anisotropic lobe: a roughness of 0.03. Narrower ones leave the precision of f32.
const float MIN_ANISOTROPIC_WIDTH = 0.001;

// True if a surface with these values has a specular lobe; else it is pure Lambert.
bool has_specular_lobe(float metallic, float dielectric_f90) {
    return HAS_SPECULAR && (metallic > 0.0 || dielectric_f90 > 0.0);
}

bool transmits(SpecularLobe lobe) { return false; }

bool reflects(SpecularLobe lobe) { return has_specular_lobe(lobe.metallic, lobe.dielectric_f90); }

// Fresnel reflectance of the dielectric part. At the boundary of a volume the exact term takes the place of Schlick's power of the
// cosine: what is not reflected there is seen on the other side.
vec3 dielectric_fresnel(SpecularLobe lobe, float cosine) {
    if (!HAS_TRANSMISSION || lobe.index == 0.0) return schlick(lobe.dielectric_f0, vec3(lobe.dielectric_f90), cosine);
    float normal = square((lobe.index - 1.0) / (lobe.index + 1.0));
    float part = (dielectric_reflectance(cosine, lobe.index) - normal) / (1.0 - normal);
    return max(lobe.dielectric_f0 + (lobe.dielectric_f90 - lobe.dielectric_f0) * part, vec3(0.0));
}

// Fresnel reflectance of the whole lobe, compensation included.
vec3 fresnel(SpecularLobe lobe, float cosine) {
    if (!HAS_SPECULAR) return vec3(0.0);
    vec3 dielectric = dielectric_fresnel(lobe, cosine);
    vec3 metal = schlick(lobe.metal_f0, vec3(1.0), cosine);
    return mix(dielectric * lobe.dielectric_scale, metal * lobe.metal_scale, lobe.metallic);
}

float passes(SpecularLobe lobe, float cosine) {
    if (!HAS_SPECULAR) return 1.0;
    if (ENERGY_COMPENSATED && !(HAS_TRANSMISSION && lobe.index > 0.0)) return lobe.passes;
    return 1.0 - max_component(dielectric_fresnel(lobe, cosine));
}

vec2 albedo_lookup(float cosine, float roughness) {
    const float cells = float(ALBEDO_CELLS);
    // Node i is at the cosine (i / cells)², because the albedo changes fastest at grazing angles.
    vec2 at = vec2(sqrt(clamp(cosine, 0.0, 1.0)), clamp(roughness, 0.0, 1.0)) * cells;
    uvec2 cell = min(uvec2(at), uvec2(ALBEDO_CELLS - 1u));
    vec2 f = at - vec2(cell);
    uint row = cell.y * (ALBEDO_CELLS + 1u) + cell.x;
    vec2 near = mix(specular_albedo.at[row], specular_albedo.at[row + 1u], f.x);
    row += ALBEDO_CELLS + 1u;
    vec2 far = mix(specular_albedo.at[row], specular_albedo.at[row + 1u], f.x);
    return mix(near, far, f.y);
}

void make_lobe(GpuMaterial material, Layers layers, vec3 outgoing, out SpecularLobe lobe) {
    lobe.dielectric_f0 = material.dielectric_f0;
    lobe.dielectric_f90 = material.dielectric_f90;
    lobe.metal_f0 = material.base_color;
    lobe.metallic = material.metallic;
    bool mirror = material.roughness < MIRROR_ROUGHNESS;
    lobe.alpha = mirror ? 0.0 : square(material.roughness);
    lobe.widths = vec2(lobe.alpha);
    float roughness = material.roughness;
    if (HAS_ANISOTROPY && layers.anisotropy > 0.0) {
        lobe.widths.y = max(square(material.roughness), MIN_ANISOTROPIC_WIDTH);
        lobe.widths.x = mix(lobe.widths.y, 1.0, square(layers.anisotropy));
        lobe.alpha = sqrt(lobe.widths.x * lobe.widths.y);
        // The isotropic lobe of about the same albedo: towards the horizon, the width that lies across the viewer counts more.
        float across = 0.25 * (outgoing.y * outgoing.y - outgoing.x * outgoing.x);
        roughness = sqrt(sqrt(dot(lobe.widths * lobe.widths, vec2(0.5 + across, 0.5 - across))));
        mirror = false;
    }
    lobe.dielectric_scale = vec3(1.0);
    lobe.metal_scale = vec3(1.0);
    lobe.index = interface_index(layers);
    lobe.passes = 1.0;
    if (HAS_SPECULAR && ENERGY_COMPENSATED && !(HAS_TRANSMISSION && lobe.index > 0.0)) {
        float cosine_out = max(outgoing.z, 0.0);
        vec2 parts;
        if (mirror) {
            parts.y = schlick(vec3(0.0), vec3(1.0), cosine_out).x;
            parts.x = 1.0 - parts.y;
        } else {
            parts = albedo_lookup(cosine_out, roughness);
        }
        float missing = 1.0 / (parts.x + parts.y) - 1.0;
        lobe.dielectric_scale = 1.0 + lobe.dielectric_f0 * missing;
        lobe.metal_scale = 1.0 + lobe.metal_f0 * missing;
        vec3 reflected = (lobe.dielectric_f0 * parts.x + lobe.dielectric_f90 * parts.y) * lobe.dielectric_scale;
        lobe.passes = max(0.0, 1.0 - max_component(reflected));
    }
}

float expected(SpecularLobe lobe, float below, float cosine) { return luminance(fresnel(lobe, cosine)) * below; }

bool is_wide(SpecularLobe lobe) { return HAS_SPECULAR && lobe.alpha > 0.0 && lobe.choice > 0.0; }

vec3 evaluate(SpecularLobe lobe, float below, float probability, vec3 outgoing, vec3 incoming, vec3 h, inout float pdf_solid_angle) {
    float d = HAS_ANISOTROPY ? ggx_distribution(h, lobe.widths) : ggx_distribution(h, lobe.alpha);
    float lambda_out = HAS_ANISOTROPY ? smith_lambda(outgoing, lobe.widths) : smith_lambda(outgoing.z, lobe.alpha);
    float lambda_in = HAS_ANISOTROPY ? smith_lambda(incoming, lobe.widths) : smith_lambda(incoming.z, lobe.alpha);
    float common_factor = d / (4.0 * outgoing.z);
    pdf_solid_angle += probability * common_factor / (1.0 + lambda_out);
    return fresnel(lobe, dot(outgoing, h)) * (below * common_factor / (incoming.z * (1.0 + lambda_out + lambda_in)));
}

vec3 draw(SpecularLobe lobe, vec3 outgoing, vec2 u) {
    return reflect(-outgoing, sample_visible_normal(outgoing, HAS_ANISOTROPY ? lobe.widths : vec2(lobe.alpha), u));
}

vec3 albedo(SpecularLobe lobe, float below, float cosine) { return fresnel(lobe, cosine) * below; }

float alpha_of(SpecularLobe lobe) { return lobe.alpha; }

bool is_matte(SpecularLobe lobe) { return lobe.alpha == 1.0; }

vec3 reflect_delta(SpecularLobe lobe, float below, vec3 outgoing, out vec3 direction) {
    direction = vec3(-outgoing.xy, outgoing.z);
    return fresnel(lobe, outgoing.z) * below;
}

void summarise(SpecularLobe lobe, float below, float cosine, inout BsdfSummary summary) {
    // Then the peak is that of the coat.
    if (HAS_COAT && !reflects(lobe)) return;
    summary.specular = lobe.alpha > 0.0 ? luminance(fresnel(lobe, 1.0)) * below : 0.0;
    summary.specular_grazing = luminance(fresnel(lobe, 0.0)) * below;
    summary.alpha_squared = square(lobe.alpha);
}
