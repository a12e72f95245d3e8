#pragma once
// Which surfaces are similar enough for reuse. Decided from sample data alone, never from a reservoir, because a choice
// that depends on a sample would bias the merge.
#include "restir/frame.glsl"
#include "restir/sample_data.glsl"

// The normal by which surfaces are compared: the shading normal, or, where a normal map turns that from pixel to pixel, the
// geometric one.
vec3 compared_normal(SampleData data) {
    bool mapped = HAS_NORMAL_MAPS && material_at(material_index(data)).normal_texture != NONE;
    return mapped ? geometric_normal(data) : shading_normal(data);
}

// Whether surface b, seen along `ray_b`, is similar to one with this material, normal and distance to `eye`.
bool is_similar(uint material, vec3 normal, float depth, vec3 eye, SampleData b, Ray ray_b) {
    if (!has_surface(b) || (restir.at.reuse.same_material != 0u && material != b.material)) return false;
    if (dot(normal, compared_normal(b)) < restir.at.reuse.min_normal_cosine) return false;
    return abs(distance(surface_position(b, ray_b), eye) - depth) <= restir.at.reuse.depth_tolerance * depth;
}

// Both distances are measured from where surface a is seen.
bool is_similar(SampleData a, Ray ray_a, SampleData b, Ray ray_b) {
    float depth = a.depth;
    vec3 eye = ray_a.origin;
    if (CAMERA_MODEL == CAMERA_MODEL_ORTHOGRAPHIC) {
        vec3 position = surface_position(a, ray_a);
        eye = eye_of(restir.at.view.camera, position);
        depth = distance(position, eye);
    }
    return is_similar(a.material, compared_normal(a), depth, eye, b, ray_b);
}
