#pragma once
// Pilots: the first BSDF ray of each pixel. It is a candidate of direct light and the first segment of the path of
// indirect light, and it tells nearby pixels how many more BSDF candidates to draw.
#include "core/counters.glsl"
#include "core/random.glsl"
#include "lights/light_point.glsl"
#include "restir/frame.glsl"
#include "scene/shading_point.glsl"

// What a pilot found.
struct Pilot {
    // NONE: no surface. Then `primitive` is the texel of the environment, or NONE, and `uv` the point in it.
    uint instance;
    uint primitive;
    // The barycentrics of the hit.
    vec2 uv;
    // If it is a light: the luminance that it would add to the pixel as the only candidate, in units of the lights' mean
    // luminance.
    float brightness;
};

// With indirect light, pilots are stored in its reservoirs until those are written, each pixel's pilot in its own
// reservoir. Rust enforces the order of passes: integrators/restir/pilots.rs.
uint pilot_word(uint slot, uint word) { return RESERVOIR_SOA ? word * restir.at.slots + slot : slot * PILOT_STRIDE + word; }

const uint BRIGHTNESS_WORD = 4u;

Pilot counted(Pilot pilot) {
    count_read(PILOT_WORDS);
    return pilot;
}

// Macros, because GLSL cannot pass buffers to functions.
#define LOAD_PILOT(BUFFER, SLOT) \
    counted(Pilot(BUFFER.at[pilot_word(SLOT, 0u)], BUFFER.at[pilot_word(SLOT, 1u)], \
                  uintBitsToFloat(uvec2(BUFFER.at[pilot_word(SLOT, 2u)], BUFFER.at[pilot_word(SLOT, 3u)])), \
                  uintBitsToFloat(BUFFER.at[pilot_word(SLOT, BRIGHTNESS_WORD)])))

#define LOAD_PILOT_BRIGHTNESS(BUFFER, SLOT) uintBitsToFloat(BUFFER.at[pilot_word(SLOT, BRIGHTNESS_WORD)])

#define STORE_PILOT(BUFFER, SLOT, PILOT) \
    { \
        BUFFER.at[pilot_word(SLOT, 0u)] = PILOT.instance; \
        BUFFER.at[pilot_word(SLOT, 1u)] = PILOT.primitive; \
        BUFFER.at[pilot_word(SLOT, 2u)] = floatBitsToUint(PILOT.uv.x); \
        BUFFER.at[pilot_word(SLOT, 3u)] = floatBitsToUint(PILOT.uv.y); \
        BUFFER.at[pilot_word(SLOT, BRIGHTNESS_WORD)] = floatBitsToUint(PILOT.brightness); \
        count_written(PILOT_WORDS); \
    }

// The hit of a pilot; its distance is not stored.
Hit pilot_hit(Pilot pilot) { return Hit(0.0, pilot.instance, pilot.primitive, pilot.uv, 0.0); }

// Samples a ray from the BSDF; false if it carries no light or leaves to the back of the surface.
bool sample_bsdf_ray(ShadingPoint shading_point, vec4 numbers, out BsdfSample chosen, out Ray ray) {
    chosen = sample_bsdf(shading_point.bsdf, shading_point.outgoing, numbers);
    vec3 direction = to_world(shading_point, chosen.direction);
    ray = Ray(ray_origin(shading_point, direction), LARGEST, direction);
    if (HAS_TRANSMISSION) chosen.weight *= shading_point.passed_to_viewer;
    return chosen.valid && max_component(chosen.weight) > 0.0
        && is_seen(dot(direction, shading_point.geometric_normal), chosen.direction.z);
}

// The ray of a delta lobe and its reflectance; false if there are fewer lobes, or if it leaves to the back of the surface.
bool delta_ray(ShadingPoint shading_point, uint index, out Ray ray, out vec3 reflectance) {
    vec3 local;
    bool found = delta_lobe(shading_point.bsdf, index, shading_point.outgoing, local, reflectance);
    vec3 direction = to_world(shading_point, local);
    ray = Ray(ray_origin(shading_point, direction), LARGEST, direction);
    if (HAS_TRANSMISSION) {
        reflectance *= shading_point.passed_to_viewer;
        // Where the reflection is total.
        found = found && max_component(reflectance) > 0.0;
    }
    return found && is_seen(dot(direction, shading_point.geometric_normal), local.z);
}

// The pixel's pilot ray.
bool pilot_ray(ShadingPoint shading_point, uvec2 pixel, out BsdfSample chosen, out Ray ray) {
    Random random = pass_random(pixel, STREAM_PILOTS);
    return sample_bsdf_ray(shading_point, to_unit(random_bits(random)), chosen, ray);
}

// The point of a light that a ray hit, or of kind LIGHT_NONE.
LightPoint light_of(Hit hit) {
    LightPoint point = LightPoint(LIGHT_NONE, NONE, hit.barycentrics);
    if (hit.instance != NONE) point.index = triangle_owner(load_instances(hit.instance), hit.primitive).light;
    if (point.index != NONE) point.kind = LIGHT_TRIANGLE;
    return point;
}

// The point of a light, or of the environment, that a ray found.
LightPoint light_found(Hit hit, vec3 direction) {
    if (hit.instance == NONE && sees_environment()) return environment_point(direction);
    return light_of(hit);
}

// The point of a light that a pilot found.
LightPoint light_found(Pilot pilot) {
    if (pilot.instance == NONE && sees_environment()) {
        return LightPoint(pilot.primitive == NONE ? LIGHT_NONE : LIGHT_ENVIRONMENT, pilot.primitive, pilot.uv);
    }
    return light_of(pilot_hit(pilot));
}
