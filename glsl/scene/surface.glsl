#pragma once
// The surface at a ray's hit, or at a given point on a triangle: position with its rounding error, normals, material,
// instance and light.
#include "core/rounding.glsl"
#include "bsdf/bsdf.glsl"
#include "scene/normal_map.glsl"
#include "scene/surface_layers.glsl"
#include "scene/textures.glsl"
#include "scene/trace.glsl"
#include "scene/triangle_owner.glsl"
#include "scene/triangle_point.glsl"

struct Surface {
    vec3 position;
    // Bound of the position's rounding error, for each axis. Within the triangle's plane the error may be larger,
    // since barycentrics are not exact.
    vec3 error;
    // The distances along the normal and towards the viewer by which rays begin that leave it.
    float clearance;
    float back_off;
    // Unit normals on the side the ray came from.
    vec3 geometric_normal;
    vec3 shading_normal;
    uint material_index;
    // With its textures and vertex colours.
    GpuMaterial material;
    Layers layers;
    // Index of the instance in the scene.
    uint instance;
    // NONE unless the triangle is a light.
    uint light;
};

// A shading normal that is bent towards the geometric one until the mirror direction of a viewer along `direction` leaves the
// surface. Where it does not, a mirror would be black: in rings on smooth spheres of few triangles, and where a normal map tilts
// far. In the plane of both normals, with all angles from the geometric one, the viewer at φ with the projected length m and the
// shading normal at α, the mirror direction's cosine is m · cos(2α − φ).
vec3 reflecting_outwards(vec3 shading_normal, vec3 geometric_normal, vec3 direction) {
    float along = dot(shading_normal, geometric_normal), facing = -dot(shading_normal, direction);
    float viewed = -dot(geometric_normal, direction);
    float least = min(MIN_FACING, viewed);
    vec3 aside = shading_normal - along * geometric_normal;
    float size = dot(aside, aside);
    if (2.0 * facing * along - viewed >= least || size <= TINY) return shading_normal;
    aside *= inversesqrt(size);
    vec2 viewer = vec2(-dot(aside, direction), viewed);
    float cosine = least / length(viewer), sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    viewer = normalize(viewer);
    float twice = clamp(viewer.y * cosine - viewer.x * sine, -1.0, 1.0);
    return sqrt(0.5 * (1.0 - twice)) * aside + sqrt(0.5 * (1.0 + twice)) * geometric_normal;
}

// A shading normal on the side of a viewer that looks along `direction`, bent for this viewer. `has_mirror` is true if the
// surface has a lobe around the mirror direction.
vec3 facing_viewer(vec3 shading_normal, vec3 geometric_normal, bool has_mirror, vec3 direction) {
    shading_normal = dot(shading_normal, geometric_normal) < 0.0 ? -shading_normal : shading_normal;
    // At a silhouette the interpolated normal may point away from the viewer, which would leave black specks. It is
    // bent until it just faces the viewer.
    float facing = -dot(shading_normal, direction);
    if (facing < MIN_FACING) shading_normal = normalize(shading_normal - (MIN_FACING - facing) * direction);
    // A matte surface has no mirror direction to lose.
    if (has_mirror) shading_normal = reflecting_outwards(shading_normal, geometric_normal, direction);
    return shading_normal;
}

// The normals of a material's surface, and of its coat, on the side of a viewer that looks along `direction`.
void face_viewer(TrianglePoint point, GpuMaterial material, inout Layers layers, vec3 direction, out vec3 geometric_normal,
                 out vec3 shading_normal) {
    geometric_normal = dot(point.normal, direction) < 0.0 ? point.normal : -point.normal;
    if (HAS_COAT_NORMALS) layers.coat_normal = facing_viewer(layers.coat_normal, geometric_normal, true, direction);
    shading_normal = geometric_normal;
    if (!point.interpolated) return;
    bool has_mirror = has_specular_lobe(material.metallic, material.dielectric_f90) || (HAS_COAT && layers.coat > 0.0);
    shading_normal = facing_viewer(point.shading_normal, geometric_normal, has_mirror, direction);
}

// What the camera sees of an unlit surface; 0 for all others.
vec3 unlit_radiance(Hit hit) {
    if (!HAS_UNLIT) return vec3(0.0);
    GpuInstance instance = load_instances(hit.instance);
    GpuMaterial material = load_materials(triangle_owner(instance, hit.primitive).material);
    if ((material.flags & MATERIAL_UNLIT) == 0u) return vec3(0.0);
    return with_textures(material, instance, hit.primitive, hit.barycentrics).base_color;
}

// From a surface to a ray origin off it on the side of `direction`; `viewed` is the direction of the ray that hit the surface.
vec3 ray_offset(Surface surface, vec3 viewed, vec3 direction) {
    float side = dot(direction, surface.geometric_normal) < 0.0 ? -1.0 : 1.0;
    // Through the surface: towards the viewer, the ray would begin before it.
    if (HAS_TRANSMISSION && side < 0.0) return -surface.clearance * surface.geometric_normal;
    return (side * surface.clearance) * surface.geometric_normal - surface.back_off * viewed;
}

vec3 ray_origin(Surface surface, vec3 viewed, vec3 direction) { return surface.position + ray_offset(surface, viewed, direction); }

// A ray origin for a ray that ends `height` above the surface's plane.
vec3 ray_origin(Surface surface, vec3 viewed, vec3 direction, float height) {
    vec3 off = ray_offset(surface, viewed, direction);
    return surface.position + fraction_of_offset(abs(dot(off, surface.geometric_normal)), height) * off;
}

// The surface at the hit of a ray of unit direction.
Surface surface_at(Hit hit, Ray ray) {
    GpuInstance instance = load_instances(hit.instance);
    TrianglePoint point = triangle_point(instance, hit.primitive, hit.barycentrics);
    TriangleOwner owner = triangle_owner(instance, hit.primitive);
    Surface surface;
    surface.position = point.position;
    surface.error = point.error;
    surface.material = material_at(owner.material, instance, hit.primitive, hit.barycentrics);
    surface.layers = layers_at(owner.material, instance, hit.primitive, hit.barycentrics, point);
    surface.layers.inside = HAS_TRANSMISSION && dot(point.normal, ray.direction) > 0.0;
    map_normal(point, surface.material, instance, hit.primitive, hit.barycentrics);
    face_viewer(point, surface.material, surface.layers, ray.direction, surface.geometric_normal, surface.shading_normal);
    surface.clearance = clearance_of(surface.geometric_normal, surface.error);
    refine_by_ray(surface.position, surface.error, surface.clearance, surface.geometric_normal, ray.origin, ray.direction);
    // Rounding may move a very close hit behind the ray's origin.
    surface.back_off = back_off_distance(surface.error, max(dot(surface.position - ray.origin, ray.direction), 0.0));
    surface.material_index = owner.material;
    surface.instance = owner.instance;
    surface.light = owner.light;
    return surface;
}
