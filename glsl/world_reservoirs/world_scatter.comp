#version 460
// Enters each vertex in the list of its cell. Its slot there is random; of those that meet, one stays. So a list has gaps,
// but no order of threads shows in it, and no list has to be sorted.
#include "core/counters.glsl"
#include "world_reservoirs/world_table.glsl"

layout(local_size_x = TILE * TILE) in;

layout(scalar) readonly buffer WorldKeysBlock { uint at[]; } world_keys;
layout(scalar) readonly buffer WorldCellsBlock { uint at[]; } world_cells;
layout(scalar) buffer WorldListBlock { uint at[]; } world_list;

void main() {
    uint vertex = invocation_vertex();
    if (vertex >= restir.at.world.vertices) return;
    uint cell = world_keys.at[vertex];
    if (cell == 0u) return;
    uint first = world_cells.at[list_of(cell - 1u)], length = world_cells.at[list_of(cell)] - first;
    uint slot;
    uint entry = list_entry(vertex, length, slot);
    // Of two that meet, exactly one is dropped.
    if (atomicMax(world_list.at[first + slot], entry) != 0u) count(COUNTER_DROPPED, 1u);
}
