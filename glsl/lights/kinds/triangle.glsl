#pragma once
// Emissive triangles: what their points emit, and uniform points on them.
#include "core/random.glsl"
#include "core/math.glsl"
#include "scene/geometry.glsl"
#include "scene/alpha.glsl"

bool is_double_sided(GpuLight light) { return HAS_DOUBLE_SIDED_LIGHTS && light.double_sided != 0u; }

// True if light passes through a part of a light (alphaMode BLEND). Rays of BSDF candidates pass all of it, because a candidate would
// have to be all lights along its ray, not only the first. So it has light samples alone, except from the camera, along delta lobes
// and in path tracing.
bool is_blended(GpuLight light) { return HAS_BLENDED_LIGHTS && light.blended != 0u; }

// The radiance that a point of a light emits on its front, by the part that it covers: none where the light has a hole.
vec3 light_radiance(GpuLight light, uint index, vec2 barycentrics) {
    vec3 radiance = light.emission;
    if (HAS_EMISSIVE_TEXTURES && scene.at.textured_lights != 0u) {
        GpuLightTexture laid = load_light_textures(index);
        vec2 uv = laid.uv + barycentrics.x * laid.edge1 + barycentrics.y * laid.edge2;
        if (laid.texture != NONE) radiance *= texture_at(load_textures(laid.texture), uv, true).rgb;
    }
    if (HAS_ALPHA && light.primitive != NONE) {
        radiance *= coverage_at(load_instances(light.instance), light.primitive, barycentrics);
    }
    return radiance;
}

// The radiance that it emits in a direction with this cosine to its normal: 0 from the back of a one-sided light.
vec3 light_emission(GpuLight light, uint index, vec2 barycentrics, float cosine) {
    return cosine > 0.0 || is_double_sided(light) ? light_radiance(light, index, barycentrics) : vec3(0.0);
}

// The same for a ray that a random number let end there: its probability was the coverage, which must not count twice.
vec3 hit_emission(GpuLight light, uint index, vec2 barycentrics, float cosine) {
    if (is_blended(light)) light.primitive = NONE;
    return light_emission(light, index, barycentrics, cosine);
}

// Converts an area density to solid angle at a point with this squared distance, under this cosine at the light.
float area_to_solid_angle(float pdf_area, float distance_squared, float cosine) {
    return pdf_area * distance_squared / max(abs(cosine), TINY);
}

// Barycentric weights of the second and third corner for a uniform point on a triangle.
vec2 uniform_barycentrics(uvec2 bits) {
    float root = sqrt(to_unit(bits.x));
    float across = to_unit(bits.y) * root;
    return vec2(root - across, across);
}

vec3 light_position(GpuLight light, vec2 barycentrics) {
    return light.corner + barycentrics.x * light.edge1 + barycentrics.y * light.edge2;
}

// Bound of the rounding error of such a position, for each axis.
vec3 light_position_error(GpuLight light) {
    return 4.7683716e-7 * (abs(light.corner) + abs(light.edge1) + abs(light.edge2));
}
