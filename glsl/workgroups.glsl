// Which part of the work a workgroup does.

// The number of this workgroup, spread so that each of `threads` fixed runs of workgroups gets an
// even share of the image: llvmpipe hands every thread one run, and sky ends sooner than trees.
uint interleaved_group(uint threads) {
    uint total = gl_NumWorkGroups.x * gl_NumWorkGroups.y * gl_NumWorkGroups.z;
    uint group = (gl_WorkGroupID.z * gl_NumWorkGroups.y + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint run = total / threads;
    // Groups past the last full round keep their number.
    if (group >= run * threads) return group;
    return (group % run) * threads + group / run;
}

// The pixel of this invocation in a strip that begins at row `first_row`, or a pixel outside. Eight neighbouring
// invocations form a 4×2 block, so that a subgroup's rays stay close.
uvec2 tile_pixel(uint width, uint first_row, uint threads) {
    uint tiles_x = (width + TILE - 1u) / TILE;
    uint group = interleaved_group(threads);
    uint i = gl_LocalInvocationIndex;
    uvec2 local = uvec2((i & 3u) | ((i >> 1u) & 4u), ((i >> 2u) & 1u) | ((i >> 3u) & 6u));
    return uvec2(group % tiles_x, group / tiles_x) * TILE + local + uvec2(0u, first_row);
}
