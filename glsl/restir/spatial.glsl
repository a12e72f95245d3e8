#pragma once
// Spatial reuse: each pixel's reservoir merges with those of neighbours within a disc. A pass first includes
// direct.glsl or indirect.glsl.
#include "core/values.glsl"
#include "restir/neighbours.glsl"
#include "restir/reservoir.glsl"

layout(push_constant, scalar) uniform SpatialStepBlock { SpatialStep step; };
layout(scalar) readonly buffer NeighboursBlock { uint at[]; } neighbours;
layout(scalar) writeonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

Domain domain_of(uint technique) {
    uvec2 pixel = pixels[technique];
    return unpack_domain(sample_data.at[slot_of(pixel)], primary_ray(pixel));
}

bool is_visible(uint technique, Domain domain, Sample value) {
    return trace_visible(shadow_ray(domain, value, CURRENT));
}

View view_of(uint technique) {
    uvec2 pixel = pixels[technique];
    return View(surface_position(sample_data.at[slot_of(pixel)], primary_ray(pixel)), restir.at.view.camera.position);
}

Sample shift_to(uint technique, Sample value, out float jacobian) {
    jacobian = 1.0;
    if (technique != 0u && !is_within_limits(view_of(0u), value, view_of(technique), value, restir.at.jacobian_limit,
                                             restir.at.min_distance)) jacobian = 0.0;
    return value;
}

#include "restir/merge.glsl"

// The light of all samples of the merge. The selected sample alone would have the same expected brightness, but more
// colour noise.
vec3 merged_light(uint count) {
    Domain domain = domain_of(0u);
    vec3 light = vec3(0.0);
    for (uint i = 0u; i < count; i += 1u) {
        if (!(technique_weights[i] > 0.0)) continue;
        light += contribution(domain, techniques[i].value) * (technique_weights[i] / technique_targets[i]);
    }
    return light;
}

// Merges the pixel of this invocation.
void merge_neighbours() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    PackedReservoir packed;
    LOAD_RESERVOIR(neighbours, slot, restir.at.slots, packed);
    SampleData data = sample_data.at[slot];
    if (has_surface(data)) {
        Random random = pass_random(pixel, FIRST_STREAM + STREAM_SPATIAL + step.index);
        // Before any reservoir is read.
        uint found = find_neighbours(pixel, data, random);
        techniques[0] = unpack_reservoir(packed);
        count(COUNTER_NEIGHBOURS, found - 1u);
        for (uint i = 1u; i < found; i += 1u) {
            LOAD_RESERVOIR(neighbours, slot_of(pixels[i]), restir.at.slots, packed);
            techniques[i] = unpack_reservoir(packed);
            techniques[i].confidence = min(techniques[i].confidence, restir.at.reuse.spatial_confidence_cap);
        }
        weigh_techniques(MIS, found, VISIBILITY == VISIBILITY_WEIGHTS, random);
        if (step.shades != 0u) color.at[pixel_index(pixel)] += accept_radiance(merged_light(found));
        packed = pack_reservoir(choose_technique(found, random));
    }
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
