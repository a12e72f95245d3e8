#pragma once
// The previous frame: where surface points were, and what was visible.
#include "scene/geometry.glsl"
#include "scene/trace.glsl"

// Where a point of an instance was. The instance is given by its index in the scene.
vec3 previous_point(uint instance, vec3 point) {
    return MOVES ? transform_point(load_previous_transforms(instance).current_to_previous, point) : point;
}

// The previous direction of a unit normal of an instance, or 0 if the instance was flat then.
vec3 previous_normal(uint instance, vec3 normal) {
    if (!MOVES) return normal;
    vec3 columns[4] = load_previous_transforms(instance).current_to_previous;
    // By the matrix of cofactors, because a flattening transform has no inverse.
    vec3 x = cross(columns[1], columns[2]), y = cross(columns[2], columns[0]), z = cross(columns[0], columns[1]);
    vec3 transformed = x * normal.x + y * normal.y + z * normal.z;
    if (dot(columns[0], x) < 0.0) transformed = -transformed;
    float size = max_component(abs(transformed));
    return size > 0.0 ? normalize(transformed / size) : vec3(0.0);
}

#if TRACE_RAY_QUERY

uniform accelerationStructureEXT previous_top_level;

float transmittance_body(Ray ray, uint epoch) {
    uint flags = ray_flags(true);
    rayQueryEXT query;
    if (MOVES && epoch == PREVIOUS) {
        rayQueryInitializeEXT(query, previous_top_level, flags, 0xFFu, ray.origin, 0.0, ray.direction, ray.t_max);
    } else {
        rayQueryInitializeEXT(query, top_level, flags, 0xFFu, ray.origin, 0.0, ray.direction, ray.t_max);
    }
    float passed = 1.0;
    FINISH_QUERY(query, NO_ALPHA_RANDOM, passed)
    return rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT ? passed : 0.0;
}

#else

float transmittance_body(Ray ray, uint epoch) {
    Hit hit = trace_tree(ray, true, NO_ALPHA_RANDOM, MOVES && epoch == PREVIOUS ? PREVIOUS_ROOT : 0u);
    return hit.instance == NONE ? hit.transmittance : 0.0;
}

#endif

// The fraction of light that passes, or in the previous frame passed, between the ray's ends.
float trace_transmittance(Ray ray, uint epoch) {
    count_ray();
    float passed = transmittance_body(ray, epoch);
    if (passed == 0.0) count(COUNTER_HITS, 1u);
    return passed;
}
