#pragma once
// Punctual lights (KHR_lights_punctual): points, spots and directions. They have no surface, so that only light samples
// find them, and their measure is discrete: a sample's density is the probability of its light.
#include "core/math.glsl"
#include "scene/geometry.glsl"

// The fraction of its intensity that a spot sends in a unit direction. Distances of unit vectors tell angles of 1e-5 radians
// apart, where all cosines are 1.
float spot_fraction(GpuPunctualLight light, vec3 direction) {
    vec3 off = direction - light.direction;
    return square(clamp(light.angle_offset - light.angle_scale * dot(off, off), 0.0, 1.0));
}

// The irradiance, of a surface that faces it, at a point whose unit direction to the light and distance are given.
vec3 punctual_irradiance(GpuPunctualLight light, vec3 direction, float distance) {
    if (light.kind == LIGHT_DIRECTIONAL) return light.intensity;
    vec3 arriving = light.intensity / max(square(distance), TINY);
    if (light.range > 0.0) {
        float fraction = square(distance / light.range);
        arriving *= clamp(1.0 - square(fraction), 0.0, 1.0);
    }
    return light.kind == LIGHT_SPOT ? arriving * spot_fraction(light, -direction) : arriving;
}
