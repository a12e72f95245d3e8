#pragma once
// The merge of a pixel's selected light sample with reservoirs of the hash grid. The file that includes this one declares
// `sample_data`.
#include "lights/samplers/hash_grid/hash_grid.glsl"
#include "restir/shift.glsl"

layout(scalar) readonly buffer GridPointsBlock { GpuGridPoint at[]; } grid_points;
layout(scalar) readonly buffer GridSlotsBlock { GpuGridSlot at[]; } grid_slots;
layout(scalar) readonly buffer GridReservoirsBlock { uint at[]; } grid_reservoirs;

// What the pixel's merge with the hash grid is made of: technique 0 is what its own light samples selected, the others are
// reservoirs of the grid. What BSDF rays hit belongs to technique 0 too, but comes later.
ShadingPoint canonical_point;
Reservoir canonical_reservoir;
uint grid_found[MAX_GRID_MERGED];
uint grid_claims[MAX_GRID_MERGED];
uint grid_count = 0u;

// Finds reservoirs at random slots of the pixel's cell, or of a cell close by: otherwise the borders of cells would show.
void find_in_grid(uvec2 pixel, ShadingPoint shading_point) {
    if (restir.at.frame >= restir.at.grid.until_frame) return;
    Random random = pass_random(pixel, STREAM_GRID + 1u);
    vec4 u = to_unit(random_bits(random));
    uint key = grid_key(shading_point.position, shading_point.geometric_normal, u.w, u.xyz - 0.5);
    uint merged = restir.at.grid.merged, reservoirs = restir.at.grid.reservoirs;
    for (uint i = 0u; i < merged; i += 1u) {
        float part = (float(i) + to_unit(random_bits(random).x)) / float(merged);
        uint slot = grid_slot(key, min(uint(part * float(reservoirs)), reservoirs - 1u));
        GpuGridSlot found = grid_slots.at[slot];
        if (found.claim == 0u || found.key != key) continue;
        grid_found[grid_count] = slot;
        grid_claims[grid_count] = found.claim;
        grid_count += 1u;
    }
}

float confidence_of(uint technique) { return technique == 0u ? 1.0 : restir.at.grid.confidence; }

Reservoir technique_at(uint technique) {
    if (technique == 0u) return canonical_reservoir;
    PackedReservoir packed;
    LOAD_RESERVOIR(grid_reservoirs, grid_found[technique - 1u], restir.at.grid.slots, packed);
    return unpack_reservoir(packed, CURRENT);
}

ShadingPoint shading_point_of(uint technique) {
    ShadingPoint shading_point = canonical_point;
    if (technique != 0u) {
        GRID_SHADING_POINT(grid_claims[technique - 1u], shading_point);
    }
    return shading_point;
}

// The merge asks no ray: its selected sample gets the shadow ray that all light samples share.
float transmittance(uint technique, ShadingPoint shading_point, LightSample value) { return 1.0; }

bool shift(uint from, uint to, ShadingPoint there, inout LightSample value, out Shifted shifted) {
    shifted = Shifted(contribution(there, value), 1.0);
    return true;
}

#define MergeSample Sample
#define MergeReservoir Reservoir
#define MERGE_EMPTY empty_reservoir(0.0)
#include "restir/merge.glsl"

// As published, reservoirs of points count by their confidence alone.
uint grid_mis() { return HASH_GRID == HASH_GRID_POINTS ? MIS_CONSTANT : MIS_DEFENSIVE; }

// Merges the selected light sample with the reservoirs of the hash grid.
void merge_grid(inout Stream stream, inout LightSample selected, inout Random random) {
    if (grid_count == 0u) return;
    canonical_reservoir = empty_reservoir(1.0);
    canonical_reservoir.value = selected;
    canonical_reservoir.contribution_weight = contribution_weight(stream);
    Reservoir merged = merge(grid_mis(), 1u + grid_count, false, false, random).reservoir;
    stream = empty_stream();
    if (!(merged.contribution_weight > 0.0)) return;
    selected = merged.value;
    float target = target_function(canonical_point, selected);
    // It needs a shadow ray, as light sample 0 does.
    stream_add(stream, 0u, target * merged.contribution_weight, target, 1.0);
}

// The MIS weight of the pixel's own candidates at a sample with this target, which one of its BSDF rays hit.
float canonical_weight(LightSample value, float target) {
    if (HASH_GRID == HASH_GRID_NONE || grid_count == 0u) return 1.0;
    float grid_confidence = float(grid_count) * restir.at.grid.confidence, total = 1.0 + grid_confidence;
    float canonical_fraction = 1.0 / total, grid_fraction = grid_confidence / total;
    MisTerms terms = empty_mis_terms();
    add_target(terms, 0u, 0u, target, canonical_fraction, canonical_fraction, grid_fraction);
    for (uint i = 1u; i <= grid_count && needs_target(grid_mis(), 0u, i); i += 1u) {
        add_target(terms, 0u, i, target_function(shading_point_of(i), value), restir.at.grid.confidence / total, canonical_fraction, grid_fraction);
    }
    return mis_weight(grid_mis(), 0u, terms, canonical_fraction, canonical_fraction, grid_fraction);
}
