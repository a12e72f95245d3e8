#version 460
// Counts the vertices of each cell, and replaces their keys by the slot of their cell, plus 1; 0: they have none.
#include "core/counters.glsl"
#include "world_reservoirs/world_table.glsl"

layout(local_size_x = TILE * TILE) in;

layout(scalar) buffer WorldKeysBlock { uint at[]; } world_keys;
layout(scalar) buffer WorldCellsBlock { uint at[]; } world_cells;

void main() {
    uint vertex = invocation_vertex();
    if (vertex >= restir.at.world.vertices) return;
    if (vertex == 0u) count(COUNTER_SLOTS, list_of(0u));
    uint key = world_keys.at[vertex];
    if (key == 0u) return;
    count(COUNTER_VERTICES, 1u);
    uint slot;
    FIND_CELL(key, slot);
    world_keys.at[vertex] = slot + 1u;
    if (slot == NONE) {
        count(COUNTER_DROPPED, 1u);
    } else {
        if (atomicAdd(world_cells.at[list_of(slot)], 1u) == 0u) count(COUNTER_CELLS, 1u);
    }
}
