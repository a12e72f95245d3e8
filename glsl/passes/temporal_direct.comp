#version 460
// Temporal reuse of direct light: each pixel's reservoir merges with the one that the surface had in
// the last frame.
#include "prelude.glsl"
#include "random.glsl"
#include "counters.glsl"
#include "geometry.glsl"
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

bool is_visible(uint technique, Domain domain, Sample value) {
    return trace_visible(shadow_ray(domain, value));
}

#include "merge.glsl"

// The pixel in which the last frame showed a point, or one outside.
ivec2 reproject(vec3 position) {
    GpuCamera camera = restir.at.previous_camera;
    vec3 offset = position - camera.position;
    float distance = dot(offset, camera.forward);
    if (!(distance > 0.0)) return ivec2(-1);
    vec2 plane = vec2(dot(offset, camera.right) / dot(camera.right, camera.right),
                      -dot(offset, camera.up) / dot(camera.up, camera.up)) / distance;
    return ivec2(floor((plane * 0.5 + 0.5) * vec2(picture_size())));
}

void main() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = sample_data.at[slot];
    if (!has_surface(data)) return;
    Ray ray = primary_ray(pixel);
    ivec2 before = reproject(surface_position(data, ray));
    if (any(lessThan(before, ivec2(0))) || is_outside(uvec2(before))) return;
    uint previous_slot = slot_of(uvec2(before));
    SampleData previous = previous_sample_data.at[previous_slot];
    Ray previous_ray = previous_primary_ray(uvec2(before));
    if (!similar(data, ray, previous, previous_ray)) return;

    PackedReservoir packed;
    LOAD_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
    techniques[0] = unpack_reservoir(packed);
    LOAD_RESERVOIR(history, previous_slot, restir.at.slots, packed);
    techniques[1] = unpack_reservoir(packed);
    techniques[1].confidence = min(techniques[1].confidence, restir.at.temporal_confidence_cap);
    techniques[1].age += 1u;
    domains[0] = unpack_domain(data, ray);
    domains[1] = unpack_domain(previous, previous_ray);
    count(COUNTER_NEIGHBOURS, 1u);
    Random random = pass_random(pixel, PASS_TEMPORAL_DIRECT);
    Reservoir merged = merge_techniques(restir.at.mis, 2u, restir.at.visibility == VISIBILITY_WEIGHTS, random);
    packed = pack_reservoir(merged);
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
