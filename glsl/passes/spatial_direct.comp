#version 460
// Spatial reuse of direct light: each pixel's reservoir merges with those of neighbours in a disc.
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

layout(push_constant, scalar) uniform SpatialStepBlock { SpatialStep step; };
layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) readonly buffer NeighboursBlock { uint at[]; } neighbours;
layout(scalar) writeonly buffer ReservoirsBlock { uint at[]; } reservoirs;

const uint MOST_TECHNIQUES = MOST_NEIGHBOURS + 1u;

#include "neighbours.glsl"

Domain domain_of(uint technique) {
    uvec2 pixel = pixels[technique];
    return unpack_domain(sample_data.at[slot_of(pixel)], primary_ray(pixel));
}

bool is_visible(uint technique, Domain domain, Sample value) {
    return trace_visible(shadow_ray(domain, value));
}

#include "merge.glsl"

void main() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    PackedReservoir packed;
    LOAD_RESERVOIR(neighbours, slot, restir.at.slots, packed);
    SampleData data = sample_data.at[slot];
    if (has_surface(data)) {
        Random random = pass_random(pixel, PASS_SPATIAL_DIRECT + step.number);
        // Before any reservoir is looked at.
        uint found = find_neighbours(pixel, data, random);
        techniques[0] = unpack_reservoir(packed);
        count(COUNTER_NEIGHBOURS, found - 1u);
        for (uint i = 1u; i < found; i += 1u) {
            LOAD_RESERVOIR(neighbours, slot_of(pixels[i]), restir.at.slots, packed);
            techniques[i] = unpack_reservoir(packed);
            techniques[i].confidence = min(techniques[i].confidence, restir.at.spatial_confidence_cap);
        }
        Reservoir merged = merge_techniques(restir.at.mis, found, restir.at.visibility == VISIBILITY_WEIGHTS, random);
        packed = pack_reservoir(merged);
    }
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
