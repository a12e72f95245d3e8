// Temporal reuse: each pixel's reservoir merges with the one that the surface had in the last frame. Where
// things move, that one is judged among the last frame's instances and lights, and its sample is carried
// on by those that it names.
#define LAST_FRAME
#include "restir.glsl"
#include "similar.glsl"
#ifdef INDIRECT
#include "limits.glsl"
#endif

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) readonly buffer PreviousSampleDataBlock { SampleData at[]; } previous_sample_data;
layout(scalar) readonly buffer HistoryBlock { uint at[]; } history;
layout(scalar) buffer ReservoirsBlock { uint at[]; } reservoirs;

const uint MOST_TECHNIQUES = 2u;
Domain domains[MOST_TECHNIQUES];

Domain domain_of(uint technique) { return domains[technique]; }

// Whether the last frame saw just what this one sees: then all that a ray could tell is known.
bool stands_still;

#ifdef INDIRECT

bool is_visible(uint technique, Domain domain, Sample value) {
    if (stands_still) return true;
    bool before = technique == 1u;
    // Where things move, they may have come behind the second vertex too.
    uint rays = MOVES && value.kind == PATH_TO_LIGHT ? 2u : 1u;
    bool seen = true;
    for (uint turn = 0u; seen && turn < rays; turn += 1u) {
        Ray ray = shadow_ray(domain, value);
        if (turn == 1u) {
            LightSample end = sample_at(value.light + (before ? restir.at.lights : 0u), value.light_barycentrics);
            ray = shadow_ray(vertex_domain(value, normalize(ray.direction)), end);
        }
        seen = trace_visible(ray, before);
    }
    return seen;
}

// The area of the second vertex' triangle times the solid angle that the light at the path's end covers from
// there; 0 if either has no size, or what lies beyond the vertex may have changed unseen. The biased shift takes
// that not to change.
float measure_of(Sample value, bool before) {
    if (value.kind == PATH_ONWARD) return 0.0;
    GpuInstance instance = instances.at[value.instance + (before ? restir.at.instance_count : 0u)];
    vec3 a, b, c;
    triangle_corners(instance.first_triangle + value.primitive, a, b, c);
    vec3 edge1 = transform_vector(instance.object_to_world, b - a);
    vec3 edge2 = transform_vector(instance.object_to_world, c - a);
    // By units of their own: squares of areas leave the range of f32.
    float size1 = max_component(abs(edge1)), size2 = max_component(abs(edge2));
    float area = size1 * size2 * length(cross(edge1 / max(size1, TINY), edge2 / max(size2, TINY)));
    if (!(area > 0.0)) return 0.0;
    if (value.kind == PATH_OUTGOING) return area;
    uint number = value.light + (before ? restir.at.lights : 0u);
    LightSample light = sample_at(number, value.light_barycentrics);
    vec3 point = triangle_point(instance, value.primitive, value.barycentrics).position;
    vec3 direction;
    float cosine;
    return area * (light_at(number).area * spread_of(point, light.position, light.normal, direction, cosine));
}

// The same sample in this frame or in the one before, if it was one there.
Sample at_time(Sample value, bool before) {
    place_vertex(value, value.instance + (before ? restir.at.instance_count : 0u));
    if (value.kind == PATH_TO_LIGHT) aim_at_light(value, value.light + (before ? restir.at.lights : 0u));
    return value;
}

#else

bool is_visible(uint technique, Domain domain, Sample value) {
    // Each sample is visible where it lives, and both live here.
    if (stands_still) return true;
    return trace_visible(shadow_ray(domain, value), technique == 1u);
}

// The area of the sample's light.
float measure_of(Sample value, bool before) {
    return light_at(value.light + (before ? restir.at.lights : 0u)).area;
}

// The same point of the same light in this frame or in the one before.
Sample at_time(Sample value, bool before) {
    return sample_at(value.light + (before ? restir.at.lights : 0u), value.barycentrics);
}

#endif

// The canonical's sample as the last frame had it, where technique 1 is asked.
Sample known_to(uint technique, Sample value, out float jacobian) {
    jacobian = 1.0;
    if (technique == 0u) return value;
    Sample there = value;
    if (MOVES) {
        float now = measure_of(value, false), before = measure_of(value, true);
        jacobian = now > 0.0 ? before / now : 0.0;
        if (jacobian > 0.0) there = at_time(value, true);
    }
#ifdef INDIRECT
    View now = View(domains[0].position, restir.at.camera.position);
    View before = View(domains[1].position, restir.at.previous_camera.position);
    if (!is_within_limits(now, value, before, there)) jacobian = 0.0;
#endif
    return there;
}

// History's sample in this frame: where its light is now, and worth what that has grown by.
void carry_on(inout Reservoir reservoir) {
    if (!MOVES || reservoir.contribution_weight <= 0.0) return;
    float now = measure_of(reservoir.value, false), before = measure_of(reservoir.value, true);
    reservoir.contribution_weight *= now > 0.0 && before > 0.0 ? now / before : 0.0;
    if (reservoir.contribution_weight > 0.0) reservoir.value = at_time(reservoir.value, false);
}

#include "merge.glsl"

// Merges the pixel of this invocation.
void merge_history() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = sample_data.at[slot];
    if (!has_surface(data)) return;
    Ray ray = primary_ray(pixel);
    // The surface as it was, and the pixel that showed it.
    vec3 position = carried_point(data.instance, surface_position(data, ray));
    vec3 eye = restir.at.previous_camera.position;
    vec2 at;
    if (!camera_sees(restir.at.previous_camera, position - eye, vec2(picture_size()), at)) return;
    ivec2 before = ivec2(floor(at));
    if (is_outside(before)) return;
    uint previous_slot = slot_of(uvec2(before));
    SampleData previous = previous_sample_data.at[previous_slot];
    Ray previous_ray = previous_primary_ray(uvec2(before));
    if (MOVES) {
        vec3 normal = carried_normal(data.instance, unpack_octahedral(data.shading_normal, 16u));
        if (!similar(data.material, normal, distance(position, eye), eye, previous, previous_ray)) return;
    } else if (!similar(data, ray, previous, previous_ray)) {
        return;
    }

    PackedReservoir packed;
    LOAD_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
    techniques[0] = unpack_reservoir(packed);
    LOAD_RESERVOIR(history, previous_slot, restir.at.slots, packed);
    techniques[1] = unpack_reservoir(packed);
    techniques[1].confidence = min(techniques[1].confidence, restir.at.temporal_confidence_cap);
    techniques[1].age += 1u;
    carry_on(techniques[1]);
    stands_still = !MOVES && before == ivec2(pixel) && previous == data && previous_ray == ray;
    domains[0] = unpack_domain(data, ray);
    domains[1] = unpack_domain(previous, previous_ray);
    count(COUNTER_NEIGHBOURS, 1u);
    Random random = kind_random(pixel, PASS_TEMPORAL);
    weigh_techniques(MIS, 2u, VISIBILITY == VISIBILITY_WEIGHTS, random);
    packed = pack_reservoir(choose_technique(2u, random));
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
