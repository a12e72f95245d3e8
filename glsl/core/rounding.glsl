#pragma once
// Bounds of the rounding errors of surface points, and ray origins that are clear of them.
#include "core/math.glsl"

// Bound of the rounding error of a point at this distance along a ray, for each axis.
vec3 ray_error(vec3 origin, vec3 direction, float depth) { return 2.4e-7 * (abs(origin) + abs(depth * direction)); }

// The distance along the normal by which a ray origin clears the surface.
float clearance_of(vec3 normal, vec3 error) { return 2.0 * dot(abs(normal), error); }

// The distance along a ray of unit direction to the plane of a surface that faces it. `position` is a point of the surface near
// the ray; its clearance becomes that of the point on the ray.
float depth_along(vec3 origin, vec3 direction, vec3 position, vec3 normal, inout float clearance) {
    vec3 off = position - origin;
    float along = dot(off, direction);
    // The error of the normal acts only on the distance between the ray and the position.
    float depth = along + dot(off - along * direction, normal) / min(dot(direction, normal), -1e-6);
    // The ray's rounding enters twice: in the depth, and in the point that is made of it.
    clearance += 2.0 * clearance_of(normal, ray_error(origin, direction, depth));
    return depth;
}

// Bound of the error of a point that `depth_along` found. Along a ray that grazes the surface it is much larger than along the
// normal, which the error of each axis no longer tells: a clearance made of it would reach past the other wall of a crease.
vec3 depth_along_error(vec3 origin, vec3 direction, float depth, vec3 normal, float clearance) {
    vec3 rounding = ray_error(origin, direction, depth);
    float depth_error = max(0.5 * clearance - dot(abs(normal), rounding), 0.0) / max(abs(dot(direction, normal)), 1e-6);
    return rounding + depth_error * abs(direction);
}

// On a triangle as large as a landscape, the error of a point from barycentrics can exceed the size of objects on it,
// and the point would lie inside them. Then the point where the ray meets the plane is more precise. All three
// coordinates come from one of the two points, since a mixture would lie off the plane.
void refine_by_ray(inout vec3 position, inout vec3 error, inout float clearance, vec3 normal, vec3 origin, vec3 direction) {
    float refined_clearance = clearance;
    float depth = depth_along(origin, direction, position, normal, refined_clearance);
    vec3 refined = depth_along_error(origin, direction, depth, normal, refined_clearance);
    if (component_sum(refined) < component_sum(error)) {
        position = origin + depth * direction;
        error = refined;
        clearance = refined_clearance;
    }
}

// The distance towards the viewer by which rays that leave a hit point begin, so that they begin before the surface and before
// any other surface that the viewer's ray does not graze. In a crease the point may lie behind the other wall, which would then
// occlude everything. At most half the length of the viewer's ray, so that they do not begin behind the viewer. The point
// itself is not moved: an emitter that is a millimetre above the floor of a landscape would light another floor.
float back_off_distance(vec3 error, float ray_length) { return min(component_sum(error), 0.5 * ray_length); }

// Rays begin beside the point that is shaded, so that a BSDF ray finds the lights of another point than light samples do. That
// matters for lights within this distance: those of them that are no larger either are left to light samples alone. A larger one,
// such as a wall that shines beside the point, light samples hardly ever meet where it is near, and it looks the same from beside.
// It is measured from where BSDF rays begin, so that both techniques agree on which lights are near.
float near_distance(float clearance, float back_off) { return 256.0 * (clearance + back_off); }

// The part of an offset by which an end of a ray leaves its surface whose other end is `height` above the plane of that surface.
// Of a height that is not much larger, the two ends keep a third: all of it would carry each of them past the other one, which then
// sees the back of an emitter. A quarter is left in any case, since a light that grazes the surface needs a clear ray as well.
float fraction_of_offset(float rise, float height) { return clamp(height / max(3.0 * rise, TINY), 0.25, 1.0); }

// An end of a ray off the surface on the side of `direction`, moved by the bound of the rounding error. A constant
// offset would leak light in small scenes and detach shadows in large ones. The other end is `height` above the surface's plane.
vec3 offset_origin(vec3 position, vec3 error, vec3 normal, vec3 direction, float height) {
    float distance = clearance_of(normal, error);
    distance *= fraction_of_offset(distance, height);
    return position + (dot(direction, normal) < 0.0 ? -distance : distance) * normal;
}
