#pragma once
// The transmission lobe (KHR_materials_transmission, KHR_materials_volume): the light that the dielectric part of a surface lets
// through, below the specular lobe and tinted by the base colour. GLASS.md has the model.
//
// A thin sheet (no volume) bends no direction: its lobe is the GGX lobe of a reflection, mirrored at the surface. A volume
// refracts at microfacets of the same distribution (Walter et al., "Microfacet Models for Refraction through Rough Surfaces",
// 2007). Below MIRROR_ROUGHNESS both are delta lobes.
#include "bsdf/dielectric.glsl"
#include "bsdf/microfacets.glsl"

struct TransmissionLobe {
    float choice;
    // Transmittance, before what the lobes above leave.
    vec3 color;
    // Index of refraction beyond the surface, relative to that of the viewer's side; 1 = directions are not bent.
    float index;
    // GGX width; 0 = a delta lobe.
    float alpha;
};

// The least difference from 1 of the index of a volume that bends directions. With a smaller one, roughness would spread its light
// by less than the rounding of half vectors.
const float LEAST_BENDING = 0.01;

void make_lobe(GpuMaterial material, Layers layers, vec3 outgoing, out TransmissionLobe lobe) {
    lobe.color = material.base_color * ((1.0 - material.metallic) * layers.transmission);
    float index = interface_index(layers);
    bool bends = index > 0.0 && abs(layers.ior - 1.0) >= LEAST_BENDING;
    lobe.index = bends ? index : 1.0;
    lobe.alpha = material.roughness < MIRROR_ROUGHNESS || (index > 0.0 && !bends) ? 0.0 : square(material.roughness);
}

bool transmits(TransmissionLobe lobe) { return HAS_TRANSMISSION; }

bool reflects(TransmissionLobe lobe) { return HAS_TRANSMISSION && max_component(lobe.color) > 0.0; }

float passes(TransmissionLobe lobe, float cosine) { return 1.0; }

float expected(TransmissionLobe lobe, float below, float cosine) { return luminance(lobe.color) * below; }

bool is_wide(TransmissionLobe lobe) { return HAS_TRANSMISSION && lobe.alpha > 0.0 && lobe.choice > 0.0; }

// The normal of the microfacets that send light from `incoming`, below the surface, to `outgoing`.
vec3 half_through(TransmissionLobe lobe, vec3 outgoing, vec3 incoming) {
    if (lobe.index == 1.0) return normalize(outgoing + vec3(incoming.xy, -incoming.z));
    vec3 h = outgoing + lobe.index * incoming;
    return normalize(h.z < 0.0 ? -h : h);
}

vec3 evaluate(TransmissionLobe lobe, float below, float probability, vec3 outgoing, vec3 incoming, vec3 h, inout float pdf_solid_angle) {
    float cosine_out = dot(outgoing, h), cosine_in = dot(incoming, h);
    // The density of half vectors that are visible, and of directions per half vector.
    float density = ggx_distribution(h, lobe.alpha) / outgoing.z, squared_index = 1.0;
    if (lobe.index == 1.0) {
        density *= 0.25;
    } else {
        // Such a microfacet would have both directions on one side.
        if (cosine_out <= 0.0 || cosine_in >= 0.0) return vec3(0.0);
        vec3 sum = outgoing + lobe.index * incoming;
        density *= cosine_out * -cosine_in * square(lobe.index) / dot(sum, sum);
        // Radiance grows with the squared index of its medium.
        squared_index = square(lobe.index);
    }
    float lambda_out = smith_lambda(outgoing.z, lobe.alpha), lambda_in = smith_lambda(incoming.z, lobe.alpha);
    pdf_solid_angle += probability * density / (1.0 + lambda_out);
    return lobe.color * (below * density / (-incoming.z * (1.0 + lambda_out + lambda_in) * squared_index));
}

vec3 draw(TransmissionLobe lobe, vec3 outgoing, vec2 u) {
    vec3 h = sample_visible_normal(outgoing, vec2(lobe.alpha), u);
    if (lobe.index != 1.0) return refracted(outgoing, h, lobe.index);
    return reflect(-outgoing, h) * vec3(1.0, 1.0, -1.0);
}

vec3 albedo(TransmissionLobe lobe, float below, float cosine) { return HAS_TRANSMISSION ? lobe.color * below : vec3(0.0); }

float alpha_of(TransmissionLobe lobe) { return lobe.alpha; }

bool is_matte(TransmissionLobe lobe) { return false; }

vec3 reflect_delta(TransmissionLobe lobe, float below, vec3 outgoing, out vec3 direction) {
    direction = lobe.index == 1.0 ? -outgoing : refracted(outgoing, vec3(0.0, 0.0, 1.0), lobe.index);
    return direction.z < 0.0 ? lobe.color * (below / square(lobe.index)) : vec3(0.0);
}

void summarise(TransmissionLobe lobe, float below, float cosine, inout BsdfSummary summary) {
    if (!HAS_TRANSMISSION || lobe.alpha == 0.0 || max_component(lobe.color) <= 0.0) return;
    summary.diffuse += luminance(lobe.color) * (below / PI);
    summary.two_sided = true;
}
