#pragma once
// Primary surfaces: packed by the first pass, unpacked into domains by later passes and by the next frame.
#include "scene/domain.glsl"

// Geometric normal (12 + 12 bits) and the exponent of the clearance, rounded up, in one word.
uint pack_geometry(vec3 geometric_normal, float clearance) {
    uint exponent = min((floatBitsToUint(clearance) >> 23u) + 1u, 254u);
    return pack_octahedral(geometric_normal, 12u) | (exponent << 24u);
}

SampleData pack_sample_data(Surface surface, Ray ray) {
    // The depth along the ray: camera, pixel and depth then give a position from which rays can start.
    vec3 error;
    vec3 normal = surface.geometric_normal;
    float depth = depth_along(ray.origin, ray.direction, surface.position, surface.error, normal, error);
    depth -= back_off_distance(error, depth);
    return SampleData(depth, pack_geometry(normal, clearance_of(normal, error)),
                      pack_octahedral(surface.shading_normal, 16u), surface.material, surface.instance);
}

bool has_surface(SampleData data) { return data.instance != NONE; }

vec3 surface_position(SampleData data, Ray ray) { return ray.origin + data.depth * ray.direction; }

Domain unpack_domain(SampleData data, Ray ray) {
    float clearance = uintBitsToFloat((data.geometry >> 24u) << 23u);
    return make_domain(surface_position(data, ray), clearance, unpack_octahedral(data.geometry, 12u),
                       unpack_octahedral(data.shading_normal, 16u), data.material, ray.direction);
}
