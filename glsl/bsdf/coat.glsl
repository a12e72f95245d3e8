#pragma once
// The clear coat of KHR_materials_clearcoat: GGX with a dielectric's Fresnel term of F0 = 0.04; a perfect mirror below
// MIRROR_ROUGHNESS. It reflects coat · F of all light that meets it, and the lobes below get the rest.
//
// As in the extension, F belongs to the cosine of the outgoing direction with the coat's normal, not to that with the half
// vector: so base and coat never reflect more than they receive, at any angle. The price is that the coated surface is not
// reciprocal. What a rough coat loses, because only single scattering is modelled, is not compensated.
#include "bsdf/microfacets.glsl"

// True if the coat may have another normal than the surface below. Scenes in which it may have SURFACES_NAMED.
const bool HAS_COAT_NORMALS = HAS_COAT && HAS_NORMAL_MAPS && SURFACES_NAMED;

struct CoatLobe {
    float choice;
    // The fraction of light that the coat reflects.
    float reflectance;
    // GGX width; 0 = a perfect mirror.
    float alpha;
    // In the shading frame, which is that of the surface below.
    vec3 normal;
};

void make_lobe(GpuMaterial material, Layers layers, vec3 outgoing, out CoatLobe lobe) {
    lobe.alpha = layers.coat_roughness < MIRROR_ROUGHNESS ? 0.0 : square(layers.coat_roughness);
    lobe.normal = HAS_COAT_NORMALS ? layers.coat_normal : vec3(0.0, 0.0, 1.0);
    float cosine = dot(outgoing, lobe.normal);
    lobe.reflectance = HAS_COAT && cosine > 0.0 ? layers.coat * schlick(vec3(0.04), vec3(1.0), cosine).x : 0.0;
}

bool transmits(CoatLobe lobe) { return false; }

bool reflects(CoatLobe lobe) { return HAS_COAT && lobe.reflectance > 0.0; }

float passes(CoatLobe lobe, float cosine) { return HAS_COAT ? 1.0 - lobe.reflectance : 1.0; }

float expected(CoatLobe lobe, float below, float cosine) { return HAS_COAT ? lobe.reflectance * below : 0.0; }

bool is_wide(CoatLobe lobe) { return HAS_COAT && lobe.alpha > 0.0 && lobe.choice > 0.0; }

// From the shading frame to a frame around the coat's normal, and back.
vec3 to_coat(CoatLobe lobe, vec3 direction) {
    if (!HAS_COAT_NORMALS) return direction;
    vec3 tangent, bitangent;
    tangent_frame(lobe.normal, tangent, bitangent);
    return vec3(dot(direction, tangent), dot(direction, bitangent), dot(direction, lobe.normal));
}

vec3 from_coat(CoatLobe lobe, vec3 direction) {
    if (!HAS_COAT_NORMALS) return direction;
    vec3 tangent, bitangent;
    tangent_frame(lobe.normal, tangent, bitangent);
    return tangent * direction.x + bitangent * direction.y + lobe.normal * direction.z;
}

vec3 evaluate(CoatLobe lobe, float below, float probability, vec3 outgoing, vec3 incoming, vec3 h, inout float pdf_solid_angle) {
    float cosine_out = to_coat(lobe, outgoing).z, cosine_in = to_coat(lobe, incoming).z;
    vec3 normal = to_coat(lobe, h);
    if (cosine_out <= 0.0 || normal.z <= 0.0) return vec3(0.0);
    float lambda_out = smith_lambda(cosine_out, lobe.alpha), lambda_in = smith_lambda(cosine_in, lobe.alpha);
    float common_factor = ggx_distribution(normal, lobe.alpha) / (4.0 * cosine_out);
    // Also below the coat's horizon, where directions are drawn that its normal's lean brings above the surface.
    pdf_solid_angle += probability * common_factor / (1.0 + lambda_out);
    if (cosine_in <= 0.0) return vec3(0.0);
    // Light is multiplied by the cosine of the surface below, which the coat's own one replaces.
    return vec3(lobe.reflectance * below * common_factor / (incoming.z * (1.0 + lambda_out + lambda_in)));
}

vec3 draw(CoatLobe lobe, vec3 outgoing, vec2 u) {
    vec3 from = to_coat(lobe, outgoing);
    return from_coat(lobe, reflect(-from, sample_visible_normal(from, vec2(lobe.alpha), u)));
}

vec3 albedo(CoatLobe lobe, float below, float cosine) { return HAS_COAT ? vec3(lobe.reflectance * below) : vec3(0.0); }

float alpha_of(CoatLobe lobe) { return lobe.alpha; }

bool is_matte(CoatLobe lobe) { return false; }

vec3 reflect_delta(CoatLobe lobe, float below, vec3 outgoing, out vec3 direction) {
    direction = reflect(-outgoing, lobe.normal);
    return direction.z > 0.0 ? vec3(lobe.reflectance * below) : vec3(0.0);
}

void summarise(CoatLobe lobe, float below, float cosine, inout BsdfSummary summary) {
    if (!HAS_COAT) return;
    summary.specular = lobe.alpha > 0.0 ? lobe.reflectance * below : 0.0;
    summary.specular_grazing = lobe.reflectance * below;
    summary.alpha_squared = square(lobe.alpha);
}
