#pragma once
// The light BVH (src/device_scene/light_bvh). A walk finds the nodes whose lights matter at a point, always in the same order, so
// that nothing has to be remembered between one walk and the next.
#include "core/random.glsl"
#include "core/math.glsl"
#include "light_bvh_buffer.glsl"
#include "restir/frame.glsl"
#include "scene/shading_point.glsl"

// A point that receives light, as light samplers see it.
struct LightSampleContext {
    vec3 position;
    vec3 normal;
    // Unit, towards the viewer.
    vec3 outgoing;
    BsdfSummary bsdf;
    // The sum of what the nodes that are found are expected to contribute.
    float expected;
    // A second walk, which draws lights: where it goes on, the sum over the nodes found so far, and the last of these that may
    // be drawn, with what it is expected to contribute.
    uint next;
    float passed;
    uint found;
    float own;
};

// The least squared GGX width of a lobe for the choice among lights: so the draw and its density, which different shaders
// compute, agree to rounding.
const float MIN_LOBE = 1e-6;

// A context that draws from no node.
LightSampleContext distant_context() {
    LightSampleContext context;
    context.expected = 0.0;
    return context;
}

GpuLightEntry light_entry(uint index) { return load_light_entry(NODE_ENTRIES * restir.at.light_node_count + index); }

bool is_leaf(uint index, GpuLightNode node) { return node.next == index + 1u; }

bool holds(GpuLightNode node, vec3 point) {
    return all(greaterThanEqual(point, node.low)) && all(lessThanEqual(point, node.high));
}

// Whether a walk that looks at a node finds it.
bool finds(uint index, GpuLightNode node, bool inside) {
    return restir.at.light_bvh_joins != 0u ? !inside || is_leaf(index, node) : inside && is_leaf(index, node);
}

// What the lights of a node are expected to contribute to a context, without visibility, in arbitrary units; where lights are
// drawn uniformly, their number. Cosines and lobes are widened by the angle under which the point sees the node, since parts
// of it may be where its centre is not.
float expected_contribution(GpuLightNode node, LightSampleContext context) {
    if (restir.at.light_bvh_uniform != 0u) return node.weight;
    vec3 offset = node.center - context.position;
    float near = max(max(dot(offset, offset), square(node.size)), TINY);
    float inverse = inversesqrt(near);
    vec3 direction = offset * inverse;
    float size = node.size * inverse;
    float cosine = dot(context.normal, direction);
    if (HAS_TRANSMISSION && context.bsdf.two_sided) cosine = abs(cosine);
    float arriving = min(cosine + size, 1.0);
    if (arriving <= 0.0) return 0.0;
    // Of lights that face into all directions, a quarter of the area is seen.
    float leaving = clamp(size * node.facing - dot(node.normal, direction), 0.0, 1.0) + 0.25 * (1.0 - node.facing);
    float reflected = context.bsdf.diffuse;
    if (HAS_SPECULAR && context.bsdf.specular > 0.0) {
        // The squared cosine of the half vector to either direction, and its squared sine to the normal. The latter from a cross
        // product: 1 - cosine² would be 0 where a narrow lobe has its slope.
        float between = max(0.5 + 0.5 * dot(context.outgoing, direction), TINY);
        vec3 aside = cross(context.normal, context.outgoing + direction);
        float sine2 = min(dot(aside, aside) / (4.0 * between), 1.0);
        float a2 = clamp(context.bsdf.alpha_squared + 0.25 * square(size), MIN_LOBE, 1.0);
        float m = 1.0 - sqrt(between), m2 = m * m;
        float fresnel = mix(context.bsdf.specular, context.bsdf.specular_grazing, m2 * m2 * m);
        // GGX with the visibility term of Kelemen and Szirmay-Kalos.
        reflected += fresnel * a2 / (4.0 * PI * between * square(sine2 + (1.0 - sine2) * a2));
    }
    return node.weight * reflected * arriving * leaving * square(inverse);
}

// The next node that a walk finds, or NONE.
uint find_next(inout uint next, vec3 point) {
    while (next < restir.at.light_node_count) {
        uint index = next;
        GpuLightNode node = load_light_node(index);
        bool inside = holds(node, point);
        next = inside ? index + 1u : node.next;
        if (finds(index, node, inside)) return index;
    }
    return NONE;
}

// The first walk: what all nodes that are found are expected to contribute.
float expected_of_all(LightSampleContext context) {
    float sum = 0.0;
    uint next = 0u;
    while (true) {
        uint found = find_next(next, context.position);
        if (found == NONE) return sum;
        sum += expected_contribution(load_light_node(found), context);
    }
}

// The context at a shading point.
LightSampleContext light_sample_context(ShadingPoint shading_point) {
    LightSampleContext context = distant_context();
    if (!LIGHT_BVH) return context;
    context.position = shading_point.position;
    context.normal = shading_point.shading_normal;
    context.outgoing = to_world(shading_point, shading_point.outgoing);
    context.bsdf = summary_of(shading_point.bsdf, shading_point.outgoing.z);
    context.next = 0u;
    context.passed = 0.0;
    context.found = NONE;
    context.expected = expected_of_all(context);
    return context;
}

// The number of integers that select a light of a node.
uint integers_of(GpuLightNode node, out uint first) {
    first = light_entry(node.first).before;
    return light_entry(node.first + node.count).before - first;
}

// Draws a light from the nodes that are found from the context, of which there are some, by what they are expected to
// contribute: draw `index` of `count`. Indices must ascend from call to call, since the walk only goes on. Also returns the
// probability, in the mean over the draws.
uint draw_near_light(inout LightSampleContext context, uint index, uint count, uvec2 bits, out float probability) {
    float wanted = (float(index) + to_unit(bits.x)) / float(count) * context.expected;
    while (context.passed <= wanted) {
        uint found = find_next(context.next, context.position);
        // After all of them, if the sum was rounded up.
        if (found == NONE) break;
        float own = expected_contribution(load_light_node(found), context);
        if (own > 0.0) {
            context.found = found;
            context.own = own;
        }
        context.passed += own;
    }
    GpuLightNode node = load_light_node(context.found);
    uint first, high, unused;
    uint integers = integers_of(node, first);
    umulExtended(bits.y, integers, high, unused);
    uint wanted_integer = first + high;
    // The last light that begins at or before it.
    uint low = node.first, end = node.first + node.count;
    while (end - low > 1u) {
        uint middle = (low + end) >> 1u;
        if (light_entry(middle).before <= wanted_integer) low = middle;
        else end = middle;
    }
    GpuLightEntry light = light_entry(low);
    uint light_integers = light_entry(low + 1u).before - light.before;
    probability = context.own / context.expected * (float(light_integers) / float(integers));
    return light.light;
}

// The probability with which a draw selects a light, in the mean over the numbers of draws.
float near_light_probability(LightSampleContext context, uint light) {
    GpuLightEntry entry = light_entry(light);
    if (entry.leaf == NONE) return 0.0;
    // Down from the root to the node that is found, of which the light's leaf is a descendant.
    uint index = restir.at.light_bvh_joins != 0u ? 0u : entry.leaf;
    bool inside, found;
    while (true) {
        GpuLightNode here = load_light_node(index);
        inside = holds(here, context.position);
        found = finds(index, here, inside);
        if (!inside || index == entry.leaf) break;
        uint sibling = load_light_node(index + 1u).next;
        index = entry.leaf >= sibling ? sibling : index + 1u;
    }
    if (!found) return 0.0;
    // Loaded here, so that the loop does not load what only this needs.
    GpuLightNode node = load_light_node(index);
    uint first;
    float integers = float(integers_of(node, first));
    uint light_integers = light_entry(entry.index + 1u).before - light_entry(entry.index).before;
    return expected_contribution(node, context) / context.expected * (float(light_integers) / integers);
}
