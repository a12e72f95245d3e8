#pragma once
// The previous frame: where surface points were, and what was visible.
#include "scene/geometry.glsl"
#include "scene/trace.glsl"
#include "scene/triangle_point.glsl"

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

// Where a point of a triangle was, also if the corners moved on their own. The triangle is given by the device's instance, the
// point by its position and its barycentric weights. By the difference, because a point that rests then stays to the bit.
vec3 previous_point(uint instance, uint primitive, vec2 weights, vec3 point) {
    if (!MOVES) return point;
    vec3 now = triangle_point(instance_at(instance, CURRENT), primitive, weights).position;
    return point + (triangle_point(instance_at(instance, PREVIOUS), primitive, weights).position - now);
}

// A triangle's axes in the world: along its first edge, its normal, and across both. False if the triangle is a line or a point.
bool triangle_axes(uint instance, uint primitive, uint epoch, out mat3 axes) {
    GpuInstance of = instance_at(instance, epoch);
    vec3 a, b, c;
    triangle_corners(of.first_triangle + primitive, a, b, c);
    vec3 edge1 = transform_vector(of.object_to_world, b - a), edge2 = transform_vector(of.object_to_world, c - a);
    // Scaled to their own size, because squares of areas leave the range of f32.
    edge1 /= max(max_component(abs(edge1)), TINY);
    edge2 /= max(max_component(abs(edge2)), TINY);
    vec3 normal = cross(edge1, edge2);
    if (!(dot(normal, normal) > 0.0)) return false;
    axes[0] = normalize(edge1);
    axes[1] = normalize(normal);
    axes[2] = cross(axes[0], axes[1]);
    return true;
}

// A normal that turned with its triangle, or 0 if the triangle was flat in one of the frames.
vec3 previous_normal(uint instance, uint primitive, vec3 normal) {
    if (!MOVES) return normal;
    mat3 now, before;
    if (!triangle_axes(instance, primitive, CURRENT, now) || !triangle_axes(instance, primitive, PREVIOUS, before)) return vec3(0.0);
    return before * (normal * now);
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
