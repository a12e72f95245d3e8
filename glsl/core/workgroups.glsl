#pragma once
// Which pixels or rays a workgroup works on.
#include "prelude.glsl"

// The index of this workgroup.
uint group_index() { return (gl_WorkGroupID.z * gl_NumWorkGroups.y + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x; }

// The same, interleaved so that each of `threads` contiguous ranges of workgroups covers the whole
// image: llvmpipe gives every thread one such range, and without this the thread with the sky would idle.
uint interleaved_group(uint threads) {
    uint total = gl_NumWorkGroups.x * gl_NumWorkGroups.y * gl_NumWorkGroups.z;
    uint group = group_index();
    uint run = total / threads;
    // Groups past the last full round keep their index.
    if (group >= run * threads) return group;
    return (group % run) * threads + group / run;
}

// The index of this invocation in a list that workgroups of TILE × TILE go through; possibly beyond its end.
uint invocation_index(uint threads) { return interleaved_group(threads) * (TILE * TILE) + gl_LocalInvocationIndex; }

// The pixel of this invocation in a strip that begins at row `first_row`, or a pixel outside. Eight neighbouring
// invocations form a 4×2 block, so that a subgroup's rays stay close.
uvec2 tile_pixel(uint width, uint first_row, uint threads) {
    uint tiles_x = (width + TILE - 1u) / TILE;
    uint group = interleaved_group(threads);
    uint i = gl_LocalInvocationIndex;
    uvec2 local = uvec2((i & 3u) | ((i >> 1u) & 4u), ((i >> 2u) & 1u) | ((i >> 3u) & 6u));
    return uvec2(group % tiles_x, group / tiles_x) * TILE + local + uvec2(0u, first_row);
}
