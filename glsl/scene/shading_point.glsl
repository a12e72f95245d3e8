#pragma once
// ShadingPoint: a shading point with its BSDF and the direction to its viewer, which is all that a target function needs to
// evaluate a sample there. Also ray origins, reflected light, and solid angles.
#include "bsdf/bsdf.glsl"
#include "scene/medium.glsl"
#include "scene/surface.glsl"

// A shading point with its outgoing direction.
struct ShadingPoint {
    vec3 position;
    // Distance along the normal by which a ray origin clears rounding errors.
    float clearance;
    // From the position to where rays begin, before they clear the surface: towards the viewer.
    vec3 back_off;
    // Unit, on the viewer's side.
    vec3 geometric_normal;
    vec3 shading_normal;
    vec3 tangent;
    vec3 bitangent;
    // Unit, towards the viewer, in the shading frame.
    vec3 outgoing;
    Bsdf bsdf;
    // True if the viewer is on the back of the surface, where its volume is.
    bool inside;
    // The medium there, or NO_MEDIUM.
    vec3 behind;
    // The fraction of light that arrives at the viewer, if the surface alone knows the medium between them.
    vec3 passed_to_viewer;
};

// A viewer: a surface point, and the camera that sees it.
struct View {
    vec3 position;
    vec3 eye;
};

vec3 to_shading(ShadingPoint shading_point, vec3 direction) {
    return vec3(dot(direction, shading_point.tangent), dot(direction, shading_point.bitangent), dot(direction, shading_point.shading_normal));
}

vec3 to_world(ShadingPoint shading_point, vec3 direction) {
    return shading_point.tangent * direction.x + shading_point.bitangent * direction.y + shading_point.shading_normal * direction.z;
}

// shading point for a viewer along the unit vector `direction`, with normals on the viewer's side.
ShadingPoint make_shading_point(vec3 position, float clearance, float back_off, vec3 geometric_normal, vec3 shading_normal,
                   GpuMaterial material, Layers layers, vec3 direction) {
    ShadingPoint shading_point;
    shading_point.position = position;
    shading_point.clearance = clearance;
    shading_point.back_off = -back_off * direction;
    shading_point.geometric_normal = geometric_normal;
    shading_point.shading_normal = shading_normal;
    shading_frame(shading_normal, layers, shading_point.tangent, shading_point.bitangent);
    layers = in_frame(layers, shading_point.tangent, shading_point.bitangent, shading_normal);
    shading_point.outgoing = to_shading(shading_point, -direction);
    shading_point.bsdf = make_bsdf(material, layers, shading_point.outgoing);
    shading_point.inside = layers.inside;
    shading_point.behind = medium_behind(layers);
    shading_point.passed_to_viewer = vec3(1.0);
    return shading_point;
}

// From the position to a ray origin off the surface on the side of `direction`.
vec3 ray_offset(ShadingPoint shading_point, vec3 direction) {
    float side = dot(direction, shading_point.geometric_normal) < 0.0 ? -1.0 : 1.0;
    // Through the surface: towards the viewer, the ray would begin before it.
    vec3 back_off = HAS_TRANSMISSION && side < 0.0 ? vec3(0.0) : shading_point.back_off;
    return back_off + (side * shading_point.clearance) * shading_point.geometric_normal;
}

// The point towards the viewer from which rays begin, before they clear the surface.
vec3 ray_start(ShadingPoint shading_point) { return shading_point.position + shading_point.back_off; }

// The same for rays to a point that may be seen through the surface.
vec3 ray_start(ShadingPoint shading_point, vec3 to) {
    bool through = HAS_TRANSMISSION && dot(to - shading_point.position, shading_point.geometric_normal) < 0.0;
    return through ? shading_point.position : ray_start(shading_point);
}

vec3 ray_origin(ShadingPoint shading_point, vec3 direction) { return shading_point.position + ray_offset(shading_point, direction); }

// A ray origin for a ray that ends `height` above the surface's plane.
vec3 ray_origin(ShadingPoint shading_point, vec3 direction, float height) {
    vec3 off = ray_offset(shading_point, direction);
    return shading_point.position + fraction_of_offset(abs(dot(off, shading_point.geometric_normal)), height) * off;
}

float near_distance(ShadingPoint shading_point) { return near_distance(shading_point.clearance, length(shading_point.back_off)); }

bool is_near(ShadingPoint shading_point, vec3 point) {
    vec3 side = HAS_TRANSMISSION ? point - shading_point.position : shading_point.geometric_normal;
    vec3 toward = point - ray_origin(shading_point, side);
    return dot(toward, toward) < square(near_distance(shading_point));
}

// Reflected radiance towards the viewer of light from a direction: f · cosine · radiance. `pdf_solid_angle` is the
// density with which BSDF sampling takes that direction.
vec3 reflected_light(ShadingPoint shading_point, vec3 direction, vec3 radiance, out float pdf_solid_angle) {
    pdf_solid_angle = 0.0;
    float geometric_cosine = dot(direction, shading_point.geometric_normal);
    if (!HAS_TRANSMISSION && geometric_cosine <= 0.0) return vec3(0.0);
    vec3 incoming = to_shading(shading_point, direction);
    if (HAS_TRANSMISSION && !is_seen(geometric_cosine, incoming.z)) return vec3(0.0);
    vec3 f = evaluate_bsdf(shading_point.bsdf, shading_point.outgoing, incoming, pdf_solid_angle);
    if (HAS_TRANSMISSION) f *= shading_point.passed_to_viewer;
    return f * radiance * spread_cosine(incoming.z);
}

// The medium of a ray that leaves the surface.
vec3 medium_left(ShadingPoint shading_point, vec3 direction) {
    return medium_left(shading_point.behind, shading_point.inside, shading_point.geometric_normal, direction);
}

// The solid angle per unit area at `point` seen from `from`: |cosine| / distance². Also returns the unit direction
// there and the cosine, which is positive on the side of `normal`. `back_off` leads from `from` to where its rays begin.
float solid_angle_per_area(vec3 from, vec3 back_off, vec3 point, vec3 normal, out vec3 direction, out float cosine) {
    vec3 toward = point - from;
    float distance_squared = max(dot(toward, toward), TINY), inverse = inversesqrt(distance_squared);
    direction = toward * inverse;
    cosine = -dot(normal, direction);
    // In a crease with an emitter `from` lies in the emitter's plane, up to rounding, and would have no light from it: its distance
    // from the plane is known no better than to a part of that of the rays' start. An emitter close above it is no crease.
    float least = min(0.25 * inverse * abs(dot(normal, back_off)), 0.01);
    if (abs(cosine) < least) cosine = least;
    return abs(cosine) / distance_squared;
}

// The same from a point that is exact.
float solid_angle_per_area(vec3 from, vec3 point, vec3 normal, out vec3 direction, out float cosine) {
    return solid_angle_per_area(from, vec3(0.0), point, normal, direction, cosine);
}
