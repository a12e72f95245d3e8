#version 460
// Surfaces claim slots of the hash grid.
#include "lights/samplers/hash_grid/hash_grid.glsl"

layout(local_size_x = TILE * TILE) in;

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
layout(scalar) readonly buffer GridPointsBlock { GpuGridPoint at[]; } grid_points;
layout(scalar) buffer GridSlotsBlock { GpuGridSlot at[]; } grid_slots;

void main() {
    uint source = invocation_index(restir.at.view.interleave);
    if (source >= restir.at.grid.sources) return;
    Random random = claim_random(source);
    GridClaim claim;
    bool valid;
    CLAIM_OF_SOURCE(source, random, claim, valid);
    // The maximum does not depend on the order.
    if (valid) atomicMax(grid_slots.at[claim.slot].claim, claim.value);
}
