#pragma once
// The BSDF, its evaluation and sampling: glTF 2.0, appendix B, with KHR_materials_specular and KHR_materials_ior. A
// Lambert base lies below a GGX lobe (α = roughness², height-correlated Smith, Schlick's Fresnel).
// Directions are in the shading frame, normal +Z, and point away from the surface.
//
// ENERGY_COMPENSATED corrects two errors of energy (Turquin, "Practical multiple scattering compensation for microfacet
// models", 2019): rough metals lose some, because only single scattering is modelled; bright dielectrics gain some at
// grazing angles, because base and lobe are mixed without regard to what the lobe reflects.
#include "core/math.glsl"
#include "scene/geometry.glsl"

// Directional albedo of the specular lobe: ALBEDO_CELLS + 1 nodes a side, roughness-major; x is the part scaled by F0,
// y the part scaled by F90.
layout(scalar) readonly buffer AlbedoBlock { vec2 at[]; } specular_albedo;

struct Bsdf {
    // Lambert reflectance, before the Fresnel factor.
    vec3 diffuse;
    vec3 dielectric_f0;
    float dielectric_f90;
    vec3 metal_f0;
    float metallic;
    // GGX width; 0 = a perfect mirror.
    float alpha;
    // Energy compensation of each specular lobe; 1 without.
    vec3 dielectric_scale;
    vec3 metal_scale;
    // With compensation, the share that the dielectric lobe leaves to the diffuse lobe; unused without.
    float diffuse_scale;
    // Probability of sampling the specular lobe.
    float specular_probability;
};

struct BsdfSample {
    vec3 direction;
    // f · |cos| / pdf.
    vec3 weight;
    // 0 for a mirror.
    float pdf_solid_angle;
    bool mirror;
    bool valid;
};

vec3 schlick(vec3 f0, vec3 f90, float cosine) {
    float m = clamp(1.0 - cosine, 0.0, 1.0);
    float m2 = m * m;
    return f0 + (f90 - f0) * (m2 * m2 * m);
}

// True if a surface has a specular lobe; else it is pure Lambert.
bool has_specular_lobe(float metallic, float dielectric_f90) {
    return HAS_SPECULAR && (metallic > 0.0 || dielectric_f90 > 0.0);
}

// Fresnel reflectance of the whole specular lobe, compensation included.
vec3 specular_fresnel(Bsdf bsdf, float cosine) {
    if (!HAS_SPECULAR) return vec3(0.0);
    vec3 dielectric = schlick(bsdf.dielectric_f0, vec3(bsdf.dielectric_f90), cosine);
    vec3 metal = schlick(bsdf.metal_f0, vec3(1.0), cosine);
    return mix(dielectric * bsdf.dielectric_scale, metal * bsdf.metal_scale, bsdf.metallic);
}

// The share of light that the Fresnel factor leaves to the diffuse lobe.
float diffuse_share(Bsdf bsdf, float cosine) {
    if (!HAS_SPECULAR) return 1.0;
    if (ENERGY_COMPENSATED) return bsdf.diffuse_scale;
    return 1.0 - max_component(schlick(bsdf.dielectric_f0, vec3(bsdf.dielectric_f90), cosine));
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

// The BSDF for an outgoing direction with this cosine to the shading normal.
Bsdf make_bsdf(GpuMaterial material, float cosine_out) {
    Bsdf bsdf;
    bsdf.diffuse = material.base_color * (1.0 - material.metallic);
    bsdf.dielectric_f0 = material.dielectric_f0;
    bsdf.dielectric_f90 = material.dielectric_f90;
    bsdf.metal_f0 = material.base_color;
    bsdf.metallic = material.metallic;
    bool mirror = material.roughness < MIRROR_ROUGHNESS;
    bsdf.alpha = mirror ? 0.0 : square(material.roughness);
    bsdf.dielectric_scale = vec3(1.0);
    bsdf.metal_scale = vec3(1.0);
    bsdf.diffuse_scale = 1.0;
    bsdf.specular_probability = 0.0;
    if (!HAS_SPECULAR) return bsdf;
    if (ENERGY_COMPENSATED) {
        vec2 parts;
        if (mirror) {
            parts.y = schlick(vec3(0.0), vec3(1.0), cosine_out).x;
            parts.x = 1.0 - parts.y;
        } else {
            parts = albedo_lookup(cosine_out, material.roughness);
        }
        float missing = 1.0 / (parts.x + parts.y) - 1.0;
        bsdf.dielectric_scale = 1.0 + bsdf.dielectric_f0 * missing;
        bsdf.metal_scale = 1.0 + bsdf.metal_f0 * missing;
        vec3 reflected = (bsdf.dielectric_f0 * parts.x + bsdf.dielectric_f90 * parts.y) * bsdf.dielectric_scale;
        bsdf.diffuse_scale = max(0.0, 1.0 - max_component(reflected));
    }
    float specular = luminance(specular_fresnel(bsdf, cosine_out));
    float diffuse = luminance(bsdf.diffuse) * diffuse_share(bsdf, cosine_out);
    // Both lobes keep a minimum share, because the estimate above holds at the mirror direction only.
    float p = specular / max(specular + diffuse, TINY);
    bool has_specular = has_specular_lobe(bsdf.metallic, bsdf.dielectric_f90);
    bool has_diffuse = max_component(bsdf.diffuse) > 0.0;
    bsdf.specular_probability = !has_specular ? 0.0 : !has_diffuse ? 1.0 : clamp(p, 0.1, 0.9);
    return bsdf;
}

// GGX distribution of a half vector. Computed from x and y, because 1 − z² cancels for narrow lobes.
float ggx_distribution(vec3 h, float alpha) {
    float a2 = alpha * alpha;
    float d = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
    return a2 / (PI * d * d);
}

// Smith's λ, as (−1 + sqrt(1 + α² tan²)) / 2.
float smith_lambda(float cosine, float alpha) {
    float c2 = cosine * cosine;
    return 0.5 * (sqrt(1.0 + alpha * alpha * max(1.0 - c2, 0.0) / max(c2, TINY)) - 1.0);
}

// f and the density of sampling it; both are 0 below the horizon. Perfect mirrors are not included.
vec3 evaluate_bsdf(Bsdf bsdf, vec3 outgoing, vec3 incoming, out float pdf_solid_angle) {
    pdf_solid_angle = 0.0;
    if (outgoing.z <= 0.0 || incoming.z <= 0.0) return vec3(0.0);
    vec3 h = normalize(outgoing + incoming);
    float cosine = dot(outgoing, h);
    vec3 f = bsdf.diffuse * (diffuse_share(bsdf, cosine) / PI);
    pdf_solid_angle = (1.0 - bsdf.specular_probability) * incoming.z / PI;
    if (HAS_SPECULAR && bsdf.alpha > 0.0 && bsdf.specular_probability > 0.0) {
        float d = ggx_distribution(h, bsdf.alpha);
        float lambda_out = smith_lambda(outgoing.z, bsdf.alpha);
        float lambda_in = smith_lambda(incoming.z, bsdf.alpha);
        float shared_factor = d / (4.0 * outgoing.z);
        f += specular_fresnel(bsdf, cosine) * (shared_factor / (incoming.z * (1.0 + lambda_out + lambda_in)));
        pdf_solid_angle += bsdf.specular_probability * shared_factor / (1.0 + lambda_out);
    }
    return f;
}

// Samples a microfacet normal visible from `outgoing` (Dupuy and Benyoub, "Sampling Visible
// GGX Normals with Spherical Caps", 2023).
vec3 sample_visible_normal(vec3 outgoing, float alpha, vec2 u) {
    vec3 w = normalize(vec3(alpha * outgoing.xy, outgoing.z));
    float z = (1.0 - u.y) * (1.0 + w.z) - w.z;
    float s = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    vec3 h = vec3(s * on_circle(u.x), z) + w;
    return normalize(vec3(alpha * h.xy, max(h.z, 0.0)));
}

BsdfSample sample_bsdf(Bsdf bsdf, vec3 outgoing, vec4 u) {
    BsdfSample result = BsdfSample(vec3(0.0), vec3(0.0), 0.0, false, false);
    if (outgoing.z <= 0.0) return result;
    if (HAS_SPECULAR && u.x < bsdf.specular_probability) {
        if (bsdf.alpha == 0.0) {
            result.direction = vec3(-outgoing.xy, outgoing.z);
            result.weight = specular_fresnel(bsdf, outgoing.z) / bsdf.specular_probability;
            result.mirror = true;
            result.valid = true;
            return result;
        }
        vec3 h = sample_visible_normal(outgoing, bsdf.alpha, u.yz);
        result.direction = reflect(-outgoing, h);
    } else {
        float r = sqrt(u.y);
        result.direction = vec3(r * on_circle(u.z), sqrt(max(1.0 - u.y, 0.0)));
    }
    vec3 f = evaluate_bsdf(bsdf, outgoing, result.direction, result.pdf_solid_angle);
    result.valid = result.pdf_solid_angle > 0.0;
    if (result.valid) result.weight = f * (result.direction.z / result.pdf_solid_angle);
    return result;
}
