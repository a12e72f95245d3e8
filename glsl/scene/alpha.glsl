#pragma once
// Alpha: the hits at which a ray ends, and the fraction of light that passes the others.
//
// A surface with alphaMode MASK is there or not. One with BLEND covers a part. Visibility rays pass it and are weakened:
// what they find depends on their ends alone. So do rays of BSDF candidates, because a candidate's density must not depend
// on what covers it. Where a path goes on, and at the camera, a random number decides: its probability is the coverage, so that it
// cancels out.
#include "core/random.glsl"
#include "scene/textures.glsl"
#include "scene/triangle_owner.glsl"

// Of a ray that passes surfaces with BLEND unless they cover all.
const uint NO_ALPHA_RANDOM = 0u;

// The random number that decides for the next ray of a path at surfaces that cover a part. It is no draw of the stream: a scene
// without such surfaces has the same random numbers.
uint draw_alpha_random(Random random) { return pcg4d(random.counter ^ 0x68E31DA4u).x | 1u; }

// The fraction of a triangle's point that its surface covers.
float coverage_at(GpuInstance instance, uint primitive, vec2 weights) {
    GpuMaterial material = material_at(triangle_owner(instance, primitive).material);
    if (material.alpha_mode == ALPHA_OPAQUE) return 1.0;
    bool mask = material.alpha_mode == ALPHA_MASK;
    float alpha = mask ? 1.0 : material.alpha;
    if (HAS_VERTEX_COLORS && instance.first_color != NONE) {
        uint first = 3u * (instance.first_color + primitive);
        float a = corner_alpha(first);
        alpha *= a + weights.x * (corner_alpha(first + 1u) - a) + weights.y * (corner_alpha(first + 2u) - a);
    }
    if (HAS_TEXTURES && material.base_color_texture != NONE) {
        GpuTexture used = load_textures(material.base_color_texture);
        alpha *= texture_at(used, uv_at(instance, primitive, weights, used.set), false).a;
    }
    if (mask) return alpha >= material.alpha ? 1.0 : 0.0;
    return clamp(alpha, 0.0, 1.0);
}

bool comes_before(vec3 a, vec3 b) { return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z; }

// Whether a hit belongs to a triangle. A ray through a shared edge hits both triangles, but what covers a part must cover it
// once. The edge belongs to the triangle around which, as the ray sees it, its corners come in order; around the other one
// they come reversed. `front` tells the sides apart: files have neighbours with opposite windings.
bool owns_hit(GpuInstance instance, uint primitive, bool front, vec3 weights) {
    vec3 a, b, c;
    triangle_corners(instance.first_triangle + primitive, a, b, c);
    bool owns = true;
    if (weights.x <= 0.0) owns = owns && comes_before(b, c) == front;
    if (weights.y <= 0.0) owns = owns && comes_before(c, a) == front;
    if (weights.z <= 0.0) owns = owns && comes_before(a, b) == front;
    return owns;
}

// Whether a ray ends at a hit of one side of a triangle; if not, and it has no alpha_random, `passed` is weakened.
// Tracers must give a weight of exactly 0 on an edge, and another beside it: else both of its triangles weaken the ray, or
// neither.
bool ends_ray(uint alpha_random, uint instance_index, GpuInstance instance, uint primitive, bool front, vec3 weights,
              inout float passed) {
    float coverage = coverage_at(instance, primitive, weights.yz);
    if (coverage >= 1.0 || coverage <= 0.0) return coverage >= 1.0;
    if (!owns_hit(instance, primitive, front, weights)) return false;
    if (alpha_random != NO_ALPHA_RANDOM) return to_unit(pcg4d(uvec4(alpha_random, instance_index, primitive, 0u)).x) < coverage;
    passed *= 1.0 - coverage;
    return false;
}
