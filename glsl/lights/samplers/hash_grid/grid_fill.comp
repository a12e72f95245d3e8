#version 460
// Surfaces whose claims stayed fill their slots of the hash grid.
#include "lights/samplers/hash_grid/hash_grid.glsl"
#include "lights/samplers/sources.glsl"

layout(local_size_x = TILE * TILE) in;

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
layout(scalar) readonly buffer GridPointsBlock { GpuGridPoint at[]; } grid_points;
layout(scalar) buffer GridSlotsBlock { GpuGridSlot at[]; } grid_slots;
layout(scalar) writeonly buffer GridReservoirsBlock { uint at[]; } grid_reservoirs;

void main() {
    uint source = invocation_index(restir.at.view.interleave);
    if (source >= restir.at.grid.sources) return;
    Random random = claim_random(source);
    GridClaim claim;
    bool valid;
    CLAIM_OF_SOURCE(source, random, claim, valid);
    if (!valid || grid_slots.at[claim.slot].claim != claim.value) return;
    grid_slots.at[claim.slot].key = claim.key;

    ShadingPoint shading_point;
    GRID_SHADING_POINT(claim.value, shading_point);
    LightSampleContext context = distant_context();
    Stream stream = empty_stream();
    Reservoir reservoir = empty_reservoir(1.0);
    uint i = 0u;
    for (; i < restir.at.grid.candidates; i += 1u) {
        if (HASH_GRID == HASH_GRID_POINTS) {
            // As published: each candidate at another point of the cell, so that the reservoir has no shading point of its own.
            uint index = random_bits(random).x % restir.at.grid.reservoirs;
            uint claimed = grid_slots.at[grid_slot(claim.key, index)].claim;
            if (claimed != 0u) shading_point = grid_point_shading(grid_points.at[(claimed & GRID_SOURCE_MASK) - 1u]);
        }
        float pdf;
        LightSample value = draw_light_sample(context, i, random_bits(random), pdf);
        float target = target_function(shading_point, value);
        float weight = target / (float(restir.at.grid.candidates) * pdf);
        if (stream_add(stream, i, weight, target, random_choice(random))) reservoir.value = value;
    }
    if (i < restir.at.grid.candidates) count_fault(COUNTER_CUT_SHORT);
    if (stream.chosen != NONE) {
        reservoir.value = as_stored(reservoir.value);
        // As published, the target is that of the point that drew the sample.
        float target = HASH_GRID == HASH_GRID_POINTS ? stream.target : target_function(shading_point, reservoir.value);
        if (target > 0.0) reservoir.contribution_weight = accept_weight(stream.weight_sum / target);
    }
    PackedReservoir packed = pack_reservoir(reservoir);
    STORE_RESERVOIR(grid_reservoirs, claim.slot, restir.at.grid.slots, packed);
}
