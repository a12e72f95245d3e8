#pragma once
// Samples of direct light: a point on an emissive triangle, in area measure. Type, target, shadow ray, shift and
// packing.
#include "lights/triangle.glsl"
#include "restir/packed_reservoir.glsl"
#include "scene/domain.glsl"

struct LightSample {
    // Index of the light.
    uint light;
    // Weights of its second and third corner.
    vec2 barycentrics;
    // Follows from these. It is kept so that the full format can store it instead of reading the light again.
    vec3 position;
    vec3 normal;
    vec3 emission;
    bool double_sided;
};

LightSample empty_light_sample() { return LightSample(NONE, vec2(0.0), vec3(0.0), vec3(0.0), vec3(0.0), false); }

// The sample at a point of a light. The point is rounded to what reservoirs store: if it were rounded after its weight is
// known, it could cross the edge of a texel, where the target may be 0, and its light would be lost.
LightSample light_sample_at(uint index, vec2 barycentrics, uint epoch) {
    GpuLight light = light_at(index, epoch);
    barycentrics = stored_barycentrics(barycentrics);
    return LightSample(index, barycentrics, light_position(light, barycentrics), light.normal,
                       light_radiance(light, index, barycentrics), is_double_sided(light));
}

// ---- Target and shadow ray

// The integrand in area measure: f · emission · cosine · cosine / distance², without visibility.
// `pdf_area` is the density with which BSDF sampling would find the point.
vec3 contribution(Domain domain, LightSample value, out float pdf_area) {
    pdf_area = 0.0;
    vec3 direction;
    float cosine;
    float solid_angle = solid_angle_per_area(domain.position, value.position, value.normal, direction, cosine);
    if (cosine <= 0.0 && !value.double_sided) return vec3(0.0);
    vec3 light = reflected_light(domain, direction, value.emission, pdf_area) * solid_angle;
    pdf_area *= solid_angle;
    return light;
}

vec3 contribution(Domain domain, LightSample value) {
    float pdf_area;
    return contribution(domain, value, pdf_area);
}

// The ray that decides whether a point on a light is visible.
Ray shadow_ray(Domain domain, LightSample value, uint epoch) {
    vec3 direction = value.position - domain.position;
    vec3 error = light_position_error(light_at(value.light, epoch));
    vec3 from = ray_origin(domain, direction);
    vec3 to = offset_origin(value.position, error, value.normal, -direction);
    // Ends short of the light by the rounding error along the whole ray.
    return Ray(from, 1.0 - 1e-6, to - from);
}

vec3 sample_position(LightSample value) { return value.position; }

vec3 sample_normal(LightSample value) { return value.normal; }

// ---- Shift between frames: the sample keeps its light and its place on it. The Jacobian is the ratio of areas.

// Moves the sample from one epoch to another, and returns the ratio of its new measure to the old one; 0 if it has none in
// either.
float move_sample(inout LightSample value, uint from, uint to) {
    float old_area = light_at(value.light, from).area;
    value = light_sample_at(value.light, value.barycentrics, to);
    return ratio(light_at(value.light, to).area, old_area);
}

// The segments of a sample whose visibility can change when something moves.
uint segment_count(LightSample value) { return 1u; }

Ray segment_ray(Domain domain, LightSample value, uint segment, uint epoch) { return shadow_ray(domain, value, epoch); }

// ---- Shift between pixels: always possible, with a Jacobian of 1 in area measure.

bool is_within_limits(View a, LightSample in_a, View b, LightSample in_b, float jacobian_limit, float min_distance) {
    return true;
}

// ---- Packing

void pack_sample(LightSample value, inout PackedReservoir p) {
    p.words[2] = (KIND_TRIANGLE << KIND_SHIFT) | value.light;
    pack_barycentrics(value.barycentrics, 3u, p);
    if (RESERVOIR_FORMAT != FORMAT_FULL) return;
    if (value.double_sided) p.words[2] |= KIND_DOUBLE_SIDED;
    uvec3 position = floatBitsToUint(value.position), emission = floatBitsToUint(value.emission);
    p.words[4] = position.x;
    p.words[5] = position.y;
    p.words[6] = position.z;
    p.words[7] = pack_octahedral(value.normal);
    p.words[8] = emission.x;
    p.words[9] = emission.y;
    p.words[10] = emission.z;
}

void unpack_sample(PackedReservoir p, out LightSample value) {
    uint light = p.words[2] & LIGHT_MASK;
    vec2 barycentrics = unpack_barycentrics(p, 3u);
    if (RESERVOIR_FORMAT != FORMAT_FULL) {
        value = light_sample_at(light, barycentrics, CURRENT);
        return;
    }
    value = LightSample(light, barycentrics, uintBitsToFloat(uvec3(p.words[4], p.words[5], p.words[6])),
                        unpack_octahedral(p.words[7]), uintBitsToFloat(uvec3(p.words[8], p.words[9], p.words[10])),
                        HAS_DOUBLE_SIDED_LIGHTS && (p.words[2] & KIND_DOUBLE_SIDED) != 0u);
}

// A new sample as it will be unpacked.
LightSample as_stored(LightSample value) {
    PackedReservoir packed = empty_packed();
    pack_sample(value, packed);
    LightSample found;
    unpack_sample(packed, found);
    return found;
}
