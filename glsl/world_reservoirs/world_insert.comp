#version 460
// Puts the keys of all cells with a vertex into the table of world reservoirs.
//
// A bucket keeps the largest of its keys, whatever their order: each slot receives all that the slots before it passed on,
// keeps the maximum, and passes on the rest.
#include "world_reservoirs/world_table.glsl"

layout(local_size_x = TILE * TILE) in;

layout(scalar) readonly buffer WorldKeysBlock { uint at[]; } world_keys;
layout(scalar) buffer WorldCellsBlock { uint at[]; } world_cells;

void main() {
    uint vertex = invocation_vertex();
    if (vertex >= restir.at.world.vertices) return;
    uint key = world_keys.at[vertex];
    uint first = bucket_of(key);
    for (uint i = 0u; key != 0u && i < restir.at.world.bucket_slots; i += 1u) {
        uint old = atomicMax(world_cells.at[first + i], key);
        // The key was there, or the slot was free; otherwise the smaller of both goes on.
        key = old == key ? 0u : min(old, key);
    }
}
