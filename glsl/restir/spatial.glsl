#pragma once
// Spatial reuse: each pixel's reservoir merges with those of neighbours within a disc. A pass first includes
// direct.glsl or indirect.glsl.
#include "core/values.glsl"
#include "restir/neighbours.glsl"
#include "restir/reservoir.glsl"
#include "restir/shift.glsl"

layout(push_constant, scalar) uniform SpatialStepBlock { SpatialStep step; };
layout(scalar) readonly buffer NeighboursBlock { uint at[]; } neighbours;
layout(scalar) writeonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

ShadingPoint shading_point_of(uint technique) {
    uvec2 pixel = pixels[technique];
    return unpack_shading_point(LOAD_SAMPLE_DATA(sample_data, slot_of(pixel)), primary_ray(pixel));
}

float transmittance(uint technique, ShadingPoint shading_point, Sample value) {
    return trace_segments(shading_point, value, CURRENT);
}

View view_of(uint technique) {
    uvec2 pixel = pixels[technique];
    vec3 position = surface_position(LOAD_SAMPLE_DATA(sample_data, slot_of(pixel)), primary_ray(pixel));
    return View(position, eye_of(restir.at.view.camera, position));
}

// A sample keeps its value: its measure does not depend on the viewer.
bool shift(uint from, uint to, ShadingPoint there, inout Sample value, out Shifted shifted) {
    shifted = Shifted(vec3(0.0), 1.0);
    if (from != to && !is_within_limits(view_of(0u), value, view_of(from != 0u ? from : to), value, restir.at.jacobian_limit,
                                        restir.at.min_distance)) return false;
    shifted.contribution = contribution(there, value);
    return true;
}

float limited(uint technique, float confidence) {
    return technique == 0u ? confidence : min(confidence, restir.at.reuse.spatial_confidence_cap);
}

float stored_confidence(uint slot) { return unpack_confidence(neighbours.at[word_of(slot, HISTORY_WORD, restir.at.slots)]); }

float confidence_of(uint technique) {
    return limited(technique, stored_confidence(slot_of(pixels[technique])));
}

Reservoir technique_at(uint technique) {
    PackedReservoir packed;
    LOAD_RESERVOIR(neighbours, slot_of(pixels[technique]), restir.at.slots, packed);
    Reservoir reservoir = unpack_reservoir(packed, CURRENT);
    reservoir.confidence = limited(technique, reservoir.confidence);
    return reservoir;
}

#define MergeSample Sample
#define MergeReservoir Reservoir
#define MERGE_EMPTY empty_reservoir(0.0)
#include "restir/merge.glsl"

// Merges the pixel of this invocation.
void merge_neighbours() {
    uvec2 pixel = invocation_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    PackedReservoir packed;
    SampleData data = LOAD_SAMPLE_DATA(sample_data, slot);
    if (has_surface(data)) {
        Random random = pass_random(pixel, FIRST_STREAM + STREAM_SPATIAL + step.index);
        // A reservoir without history has the confidence of an initial one. Confidence depends on no sample, so the number of
        // neighbours may depend on it. They are chosen before any sample is read.
        bool has_history = stored_confidence(slot) > 1.0;
        uint wanted = has_history ? restir.at.reuse.neighbours : NEIGHBOURS;
        uint techniques = find_neighbours(pixel, data, wanted, random);
        uint found = techniques - 1u;
        count(COUNTER_NEIGHBOURS, found);
        Merged merged = merge(MIS, techniques, VISIBILITY == VISIBILITY_WEIGHTS, step.shades != 0u, random);
        if (step.shades != 0u) ADD_LIGHT(pixel, merged.light)
        if (!has_history) {
            float most = restir.at.reuse.confidence_without_history;
            merged.reservoir.confidence = min(merged.reservoir.confidence, most);
        }
        packed = pack_reservoir(merged.reservoir);
        if (KEEPS_DEBUG_WORDS) {
            uint before = neighbours.at[word_of(slot, neighbours_word(), restir.at.slots)];
            packed.words[neighbours_word()] = before + found;
        }
    } else {
        LOAD_RESERVOIR(neighbours, slot, restir.at.slots, packed);
    }
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
