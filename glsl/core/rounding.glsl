#pragma once
// Bounds of the rounding errors of surface points, and ray origins that are clear of them.
#include "core/math.glsl"

// Bound of the rounding error of a point at this distance along a ray, for each axis.
vec3 ray_error(vec3 origin, vec3 direction, float depth) { return 2.4e-7 * (abs(origin) + abs(depth * direction)); }

// The distance along a ray of unit direction to the plane of a surface that faces it, and the error bound of the
// point there. `position` and `position_error` describe a point of the surface near the ray.
float depth_along(vec3 origin, vec3 direction, vec3 position, vec3 position_error, vec3 normal, out vec3 error) {
    vec3 off = position - origin;
    float along = dot(off, direction);
    float cosine = min(dot(direction, normal), -1e-6);
    // The error of the normal acts only on the distance between the ray and the position.
    float depth = along + dot(off - along * direction, normal) / cosine;
    vec3 rounding = ray_error(origin, direction, depth);
    float depth_error = dot(abs(normal), position_error + rounding) / -cosine;
    error = rounding + depth_error * abs(direction);
    return depth;
}

// On a triangle as large as a landscape, the error of a point from barycentrics can exceed the size of objects on it,
// and the point would lie inside them. Then the point where the ray meets the plane is more precise. All three
// coordinates come from one of the two points, since a mixture would lie off the plane.
void refine_by_ray(inout vec3 position, inout vec3 position_error, vec3 normal, vec3 origin, vec3 direction) {
    vec3 error;
    float depth = depth_along(origin, direction, position, position_error, normal, error);
    if (component_sum(error) < component_sum(position_error)) {
        position = origin + depth * direction;
        position_error = error;
    }
}

// The distance along the normal by which a ray origin clears the surface.
float clearance_of(vec3 normal, vec3 error) { return 2.0 * dot(abs(normal), error); }

// The distance by which to move a hit point back along its ray, so that it lies before the surface and before any
// other surface that the ray does not graze. In a crease the point may lie behind the other wall, which would then
// occlude everything. At most half the ray's length, so that it does not pass the ray's own origin.
float back_off_distance(vec3 error, float ray_length) { return min(component_sum(error), 0.5 * ray_length); }

// A ray origin off the surface on the side of `direction`, moved by the bound of the rounding error. A constant
// offset would leak light in small scenes and detach shadows in large ones.
vec3 offset_origin(vec3 position, vec3 error, vec3 normal, vec3 direction) {
    float distance = clearance_of(normal, error);
    return position + (dot(direction, normal) < 0.0 ? -distance : distance) * normal;
}
