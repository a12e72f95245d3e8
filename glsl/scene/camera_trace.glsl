#pragma once
// The camera's rays go through the backs of surfaces that are culled, as glTF asks for materials that are not double-sided: files
// of rooms have walls without an outer side, through which a camera outside looks in. All other rays meet both sides, because a
// wall blocks light from both.
#include "scene/surface.glsl"

// The largest number of surfaces that a ray of the camera goes through. It ends loops; the next surface is shown from behind.
const uint MOST_CULLED = 256u;

// True if a ray of the camera goes on behind the hit.
bool is_culled(Hit hit, vec3 direction, out TrianglePoint point) {
    GpuInstance instance = load_instances(hit.instance);
    if ((load_materials(triangle_owner(instance, hit.primitive).material).flags & MATERIAL_CULLED) == 0u) return false;
    point = triangle_point(instance, hit.primitive, hit.barycentrics);
    return dot(point.normal, direction) > 0.0;
}

// The origin of a ray that goes on behind a culled surface: off the surface by the rounding error of the point.
vec3 origin_behind(TrianglePoint point) { return point.position + clearance_of(point.normal, point.error) * point.normal; }

// The first surface that the camera sees along a ray, and its distance from the ray's origin.
Hit trace_camera(Ray ray, uint alpha_random) {
    Ray rest = ray;
    Hit hit = trace_closest(rest, alpha_random);
    if (!HAS_CULLED) return hit;
    TrianglePoint point;
    for (uint passed = 0u; passed < MOST_CULLED && hit.instance != NONE && is_culled(hit, ray.direction, point); passed++) {
        rest.origin = origin_behind(point);
        hit = trace_closest(rest, alpha_random);
    }
    hit.t += distance(rest.origin, ray.origin);
    return hit;
}
