#pragma once
// Punctual lights (KHR_lights_punctual): points, spots and directions. They have no surface, so that only light samples
// find them, and their measure is discrete: a sample's density is the probability of its light.
#include "core/math.glsl"
#include "scene/geometry.glsl"

// The share of its intensity that a spot sends in a direction with this cosine to its axis.
float spot_share(GpuPunctualLight light, float cosine) {
    return square(clamp(cosine * light.angle_scale + light.angle_offset, 0.0, 1.0));
}

// The irradiance, of a surface that faces it, at a point whose unit direction to the light and distance are given.
vec3 punctual_irradiance(GpuPunctualLight light, vec3 direction, float distance) {
    if (light.kind == LIGHT_DIRECTIONAL) return light.intensity;
    vec3 arriving = light.intensity / max(square(distance), TINY);
    if (light.range > 0.0) {
        float share = square(distance / light.range);
        arriving *= clamp(1.0 - square(share), 0.0, 1.0);
    }
    return light.kind == LIGHT_SPOT ? arriving * spot_share(light, -dot(direction, light.direction)) : arriving;
}
