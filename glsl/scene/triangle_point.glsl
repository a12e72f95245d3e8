#pragma once
// Points of triangles: position with its rounding error, and normals.
#include "core/rounding.glsl"
#include "scene/geometry.glsl"

// A corner's normal in the world. It is normalised before it is interpolated: only then does a mesh under a non-uniform
// transform look the same as the mesh with its vertices transformed.
vec3 corner_normal(GpuInstance instance, uint packed) {
    return normalize(transform_normal(instance.world_to_object, unpack_octahedral(packed)));
}

// A point of a triangle, independent of the viewer.
struct TrianglePoint {
    vec3 position;
    // Bound of the position's rounding error, for each axis.
    vec3 error;
    // Unit, on the triangle's front.
    vec3 normal;
    // Unit; interpolated if the corners have normals, and turned by a normal map if there is one.
    vec3 shading_normal;
    // Whether it differs from the other.
    bool interpolated;
};

TrianglePoint triangle_point(GpuInstance instance, uint primitive, vec2 weight) {
    TrianglePoint point;
    vec3 a, b, c;
    triangle_corners(instance.first_triangle + primitive, a, b, c);
    vec3 edge1 = b - a, edge2 = c - a;
    vec3 p = a + weight.x * edge1 + weight.y * edge2;
    point.position = transform_point(instance.object_to_world, p);
    // Seven roundings, each with half of 2^-23 of the largest term.
    vec3 reach = max(abs(a), max(abs(b), abs(c)));
    point.error = 8.3446503e-7 * (abs(instance.object_to_world[0]) * reach.x
        + abs(instance.object_to_world[1]) * reach.y
        + abs(instance.object_to_world[2]) * reach.z + abs(instance.object_to_world[3]));
    point.normal = normalize(transform_normal(instance.world_to_object, unit_cross(edge1, edge2)));
    point.shading_normal = point.normal;
    point.interpolated = HAS_SMOOTH_NORMALS && instance.first_normal != NONE;
    if (point.interpolated) {
        uvec3 corners = corner_directions.at[instance.first_normal + primitive];
        vec3 shading = (1.0 - weight.x - weight.y) * corner_normal(instance, corners.x)
            + weight.x * corner_normal(instance, corners.y) + weight.y * corner_normal(instance, corners.z);
        float size = dot(shading, shading);
        // Opposite corner normals can cancel out.
        if (size > TINY) point.shading_normal = shading * inversesqrt(size);
    }
    return point;
}

// The barycentric weights of a point of a triangle, given relative to its first corner.
vec2 barycentrics_of(GpuInstance instance, uint primitive, vec3 offset) {
    vec3 a, b, c;
    triangle_corners(instance.first_triangle + primitive, a, b, c);
    vec3 edge1 = transform_vector(instance.object_to_world, b - a);
    vec3 edge2 = transform_vector(instance.object_to_world, c - a);
    // Scaled to their own size, because products of four lengths leave the range of f32.
    float size = max(max_component(abs(edge1)), max_component(abs(edge2)));
    edge1 /= size;
    edge2 /= size;
    offset /= size;
    float first = dot(edge1, edge1), second = dot(edge2, edge2), both = dot(edge1, edge2);
    float along1 = dot(offset, edge1), along2 = dot(offset, edge2);
    float divisor = first * second - both * both;
    // Of a triangle as thin as a hair it is 0 by rounding.
    if (!(divisor > 0.0)) return vec2(0.0);
    return clamp(vec2(along1 * second - along2 * both, along2 * first - along1 * both) / divisor, 0.0, 1.0);
}
