#pragma once
// Body of the trace seam in compute: two levels of eight-wide compressed nodes. Included by trace.glsl.
// Traversal after Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through
// Compressed Wide BVHs", HPG 2017; triangles after Woop, Benthin and Wald, "Watertight Ray/Triangle
// Intersection", JCGT 2013.
//
// The stack holds groups (x, y). A group of nodes has y > LEAF_BITS: x is the first child's index,
// the high byte of y the children still to visit in order, the low byte the parent's mask of inner
// children. A group of leaves has y <= LEAF_BITS: x is the first primitive, y one bit for each.
#include "core/math.glsl"
#include "scene/geometry.glsl"

const uint LEAF_BITS = 0x00FFFFFFu;
// Bound of the relative error of a plane's distance: four operations, each with half of 2^-23.
const float PLANE_ERROR = 4.76837158e-7;

// A ray in the space of one level of the tree.
struct LevelRay {
    vec3 origin;
    vec3 inverse;
    // Flips child slots so that the nearest comes first, in each byte.
    uint octant;
    // Axis of the largest direction component, and the shear that makes it the ray's axis.
    uint axis;
    vec3 shear;
};

vec3 permute(vec3 v, uint axis) { return axis == 0u ? v.yzx : axis == 1u ? v.zxy : v.xyz; }

LevelRay level_ray(vec3 origin, vec3 direction) {
    vec3 size = abs(direction);
    // A zero component would give 0 × ∞ in the slab test. Relative, so that the result is the same at every scale.
    float smallest = max_component(size) * 1e-18;
    vec3 safe = mix(direction, vec3(smallest), lessThan(size, vec3(smallest)));
    uint octant = (safe.x < 0.0 ? 0u : 4u) | (safe.y < 0.0 ? 0u : 2u) | (safe.z < 0.0 ? 0u : 1u);
    uint axis = size.x > size.y ? (size.x > size.z ? 0u : 2u) : (size.y > size.z ? 1u : 2u);
    vec3 d = permute(direction, axis);
    return LevelRay(origin, 1.0 / safe, octant * 0x01010101u, axis, vec3(d.xy / d.z, 1.0 / d.z));
}

vec4 unpack_bytes(uint word) {
    return vec4(word & 0xFFu, (word >> 8u) & 0xFFu, (word >> 16u) & 0xFFu, word >> 24u);
}

// The distances of a node's planes along the ray: byte × scale + start for planes where it enters, byte × far_scale +
// end for planes where it leaves.
struct Slabs {
    vec3 scale;
    vec3 start;
    vec3 far_scale;
    vec3 end;
};

// The index of the highest bit set in 0 < bits < 2^24. The exponent of the number takes llvmpipe a tenth of the
// time of its findMSB.
uint highest_bit(uint bits) { return (floatBitsToUint(float(int(bits))) >> 23u) - 127u; }

// Distances of four planes, as bits.
ivec4 plane(uint bytes, float scale, float start) {
    return floatBitsToInt(fma(unpack_bytes(bytes), vec4(scale), vec4(start)));
}

// Bits of the four children whose boxes the ray meets before t_max. Distances are compared as integers, which takes
// one operation where floats that may be NaN take three. The order is the same among non-negative numbers, and a
// negative end is a miss in both.
uint child_hits(uint meta, uvec3 near, uvec3 far, Slabs slabs, uint octant, float t_max) {
    ivec4 enter = max(plane(near.x, slabs.scale.x, slabs.start.x), plane(near.y, slabs.scale.y, slabs.start.y));
    enter = max(max(enter, plane(near.z, slabs.scale.z, slabs.start.z)), 0);
    ivec4 leave = min(plane(far.x, slabs.far_scale.x, slabs.end.x), plane(far.y, slabs.far_scale.y, slabs.end.y));
    leave = min(min(leave, plane(far.z, slabs.far_scale.z, slabs.end.z)), floatBitsToInt(t_max));
    bvec4 met = lessThanEqual(enter, leave);
    // Inner children (bits 3 and 4 of their byte are set) are ordered by the octant, leaves are not.
    uint inner = ((meta & (meta << 1u)) & 0x10101010u) >> 4u;
    uint index = (meta ^ (octant & (inner * 0xFFu))) & 0x1F1F1F1Fu;
    uint bits = (meta >> 5u) & 0x07070707u;
    uint hits = 0u;
    if (met.x) hits |= (bits & 0xFFu) << (index & 0xFFu);
    if (met.y) hits |= ((bits >> 8u) & 0xFFu) << ((index >> 8u) & 0xFFu);
    if (met.z) hits |= ((bits >> 16u) & 0xFFu) << ((index >> 16u) & 0xFFu);
    if (met.w) hits |= (bits >> 24u) << (index >> 24u);
    return hits;
}

// Visits a node: replaces both groups by the node's children that the ray meets.
void visit_node(uint node, LevelRay ray, float t_max, out uvec2 group, out uvec2 leaves) {
    uvec4 head = nodes_words(5u * node);
    uvec4 base = nodes_words(5u * node + 1u);
    uvec4 x = nodes_words(5u * node + 2u);
    uvec4 y = nodes_words(5u * node + 3u);
    uvec4 z = nodes_words(5u * node + 4u);
    uvec3 exponent = uvec3(head.w, head.w >> 8u, head.w >> 16u) & 0xFFu;
    vec3 scale = uintBitsToFloat(exponent << 23u) * ray.inverse;
    vec3 start = (uintBitsToFloat(head.xyz) - ray.origin) * ray.inverse;
    // Boxes grow by the rounding error, or grazing rays would slip between adjacent boxes.
    vec3 slack = abs(start) * PLANE_ERROR;
    Slabs slabs = Slabs(scale, start - slack, scale * (1.0 + PLANE_ERROR), (start + slack) * (1.0 + PLANE_ERROR));
    bvec3 flip = lessThan(ray.inverse, vec3(0.0));
    uvec2 near_x = flip.x ? x.zw : x.xy, far_x = flip.x ? x.xy : x.zw;
    uvec2 near_y = flip.y ? y.zw : y.xy, far_y = flip.y ? y.xy : y.zw;
    uvec2 near_z = flip.z ? z.zw : z.xy, far_z = flip.z ? z.xy : z.zw;
    float limit = t_max * (1.0 + PLANE_ERROR);
    uint hits = child_hits(base.z, uvec3(near_x.x, near_y.x, near_z.x), uvec3(far_x.x, far_y.x, far_z.x),
                           slabs, ray.octant, limit)
              | child_hits(base.w, uvec3(near_x.y, near_y.y, near_z.y), uvec3(far_x.y, far_y.y, far_z.y),
                           slabs, ray.octant, limit);
    group = uvec2(base.x, (hits & ~LEAF_BITS) | (head.w >> 24u));
    leaves = uvec2(base.y, hits & LEAF_BITS);
}

// Edge functions are antisymmetric to the last bit, so that a ray never misses both triangles of a shared edge.
// `precise` forbids fused operations, which would break this. `front` tells the sides of triangles apart; which is
// which depends on the ray.
bool meets_triangle(uint triangle, LevelRay ray, inout float t, out bool front, out vec3 weights) {
    vec3 a, b, c;
    triangle_corners(triangle, a, b, c);
    a = permute(a - ray.origin, ray.axis);
    b = permute(b - ray.origin, ray.axis);
    c = permute(c - ray.origin, ray.axis);
    precise vec2 a2 = a.xy - ray.shear.xy * a.z;
    precise vec2 b2 = b.xy - ray.shear.xy * b.z;
    precise vec2 c2 = c.xy - ray.shear.xy * c.z;
    precise float u = c2.x * b2.y - c2.y * b2.x;
    precise float v = a2.x * c2.y - a2.y * c2.x;
    precise float w = b2.x * a2.y - b2.y * a2.x;
    bool inside = min(u, min(v, w)) >= 0.0 || max(u, max(v, w)) <= 0.0;
    precise float area = u + v + w;
    front = area > 0.0;
    // Divided first, because products of three coordinates overflow where products of two do not.
    precise vec3 weight = vec3(u, v, w) / area;
    weights = weight;
    precise float distance = (weight.x * a.z + weight.y * b.z + weight.z * c.z) * ray.shear.z;
    if (inside && area != 0.0 && distance > 0.0 && distance < t) {
        t = distance;
        return true;
    }
    return false;
}

// Whether a hit of a triangle, given by its index among all, ends a ray.
bool ends_ray_here(uint alpha_random, uint instance_index, uint triangle, bool front, vec3 weights, inout float passed) {
    if (!HAS_ALPHA) return true;
    GpuInstance instance = load_instances(instance_index);
    return ends_ray(alpha_random, instance_index, instance, triangle - instance.first_triangle, front, weights, passed);
}

// Traces in the tree over the instances with this root node.
Hit trace_tree(Ray ray, bool any_hit, uint alpha_random, uint root) {
    Hit hit = no_hit(ray.t_max);
    LevelRay level = level_ray(ray.origin, ray.direction);
    uvec2 stack[STACK_SIZE];
    uint depth = 0u;
    // The instance being traversed, and the stack depth at which it was entered.
    uint instance = NONE;
    uint entered = 0u;
    // The root is the only child of its group.
    uvec2 group = uvec2(root, 0x80000000u);
    uvec2 leaves = uvec2(0u);
    while (true) {
        if (group.y > LEAF_BITS) {
            uint bit = 24u + highest_bit(group.y >> 24u);
            uint mask = group.y;
            group.y &= ~(1u << bit);
            if (group.y > LEAF_BITS) stack[depth++] = group;
            uint slot = (bit - 24u) ^ (level.octant & 0xFFu);
            uint child = group.x + uint(bitCount(mask & ~(0xFFFFFFFFu << slot) & 0xFFu));
            visit_node(child, level, hit.t, group, leaves);
        } else {
            leaves = group;
            group = uvec2(0u);
        }
        while (leaves.y != 0u) {
            uint bit = highest_bit(leaves.y);
            leaves.y &= ~(1u << bit);
            uint primitive = leaves.x + bit;
            if (instance == NONE) {
                if (group.y > LEAF_BITS) stack[depth++] = group;
                if (leaves.y != 0u) stack[depth++] = leaves;
                instance = top_instances.at[primitive];
                entered = depth;
                // Translated before it is rotated: the difference is exact where the ray starts near the
                // instance, while a sum of large terms would cancel.
                GpuInstance entered_instance = load_instances(instance);
                vec3 moved = ray.origin - entered_instance.object_to_world[3];
                level = level_ray(transform_vector(entered_instance.world_to_object, moved),
                                  transform_vector(entered_instance.world_to_object, ray.direction));
                group = uvec2(entered_instance.root_node, 0x80000000u);
                leaves.y = 0u;
            } else {
                bool front;
                vec3 weights;
                float t = hit.t;
                if (meets_triangle(primitive, level, t, front, weights)
                    && ends_ray_here(alpha_random, instance, primitive, front, weights, hit.transmittance)) {
                    hit.t = t;
                    hit.instance = instance;
                    hit.primitive = primitive;
                    hit.barycentrics = weights.yz;
                    if (any_hit) {
                        leaves.y = 0u;
                        group.y = 0u;
                        depth = 0u;
                        entered = 0u;
                    }
                }
            }
        }
        if (group.y <= LEAF_BITS) {
            if (instance != NONE && depth == entered) {
                instance = NONE;
                level = level_ray(ray.origin, ray.direction);
            }
            if (depth == 0u) break;
            group = stack[--depth];
        }
    }
    if (hit.instance != NONE) hit.primitive -= load_instances(hit.instance).first_triangle;
    return hit;
}

Hit trace_body(Ray ray, bool any_hit, uint alpha_random) { return trace_tree(ray, any_hit, alpha_random, 0u); }
