#version 460
// Temporal reuse of direct light: each pixel's reservoir merges with the one that the surface had in
// the last frame. Where things move, that one is judged among the last frame's instances and lights, and
// its sample is carried on by its light.
#define LAST_FRAME
#include "prelude.glsl"
#include "random.glsl"
#include "counters.glsl"
#include "geometry.glsl"
#include "last_frame.glsl"
#include "trace.glsl"
#include "surface.glsl"
#include "materials.glsl"
#include "lights.glsl"
#include "camera.glsl"
#include "values.glsl"
#include "workgroups.glsl"
#include "sample_data.glsl"
#include "direct_light.glsl"
#include "reservoirs.glsl"
#include "resampling.glsl"
#include "restir.glsl"
#include "similar.glsl"

layout(local_size_x = TILE * TILE) in;

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) readonly buffer PreviousSampleDataBlock { SampleData at[]; } previous_sample_data;
layout(scalar) readonly buffer HistoryBlock { uint at[]; } history;
layout(scalar) buffer ReservoirsBlock { uint at[]; } reservoirs;

const uint MOST_TECHNIQUES = 2u;
Domain domains[MOST_TECHNIQUES];

Domain domain_of(uint technique) { return domains[technique]; }

// Whether the last frame saw just what this one sees: then all that a ray could tell is known.
bool stands_still;

bool is_visible(uint technique, Domain domain, Sample value) {
    // Each sample is visible where it lives, and both live here.
    if (stands_still) return true;
    return trace_visible(shadow_ray(domain, value), technique == 1u);
}

// The same point of the same light as the last frame had it. Its area is measured by that frame's.
Sample carried(uint technique, Sample value, out float jacobian) {
    jacobian = 1.0;
    if (!MOVES || technique == 0u) return value;
    uint before = value.light + restir.at.lights;
    jacobian = light_at(before).area / max(light_at(value.light).area, TINY);
    return sample_at(before, value.barycentrics);
}

// History's sample in this frame: where its light is now, and worth what that has grown by.
void carry_on(inout Reservoir reservoir) {
    uint light = reservoir.value.light;
    if (!MOVES || light == NONE) return;
    float before = light_at(light + restir.at.lights).area;
    reservoir.value = sample_at(light, reservoir.value.barycentrics);
    reservoir.contribution_weight *= light_at(light).area / max(before, TINY);
}

#define CARRIES_SAMPLES
#include "merge.glsl"

void main() {
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
    Random random = pass_random(pixel, PASS_TEMPORAL_DIRECT);
    Reservoir merged = merge_techniques(restir.at.mis, 2u, restir.at.visibility == VISIBILITY_WEIGHTS, random);
    packed = pack_reservoir(merged);
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
