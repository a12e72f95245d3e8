#version 460
// Exclusive prefix sums of blocks, in place, and the sum of each block. It uses no subgroup and waits for no other workgroup,
// so that it runs anywhere; `prefix_add.comp` adds the sums of the blocks before.
#include "core/workgroups.glsl"

layout(local_size_x = PREFIX_GROUP) in;

layout(scalar) buffer ValuesBlock { uint at[]; } values;
layout(push_constant, scalar) uniform LevelBlock { PrefixLevel at; } level;

const uint VALUES_EACH = PREFIX_BLOCK / PREFIX_GROUP;

shared uint sums[2][PREFIX_GROUP];

void main() {
    uint block = group_index();
    uint own = gl_LocalInvocationIndex;
    uint begin = block * PREFIX_BLOCK + own * VALUES_EACH;
    uint values_before[VALUES_EACH];
    uint sum = 0u;
    for (uint i = 0u; i < VALUES_EACH; i += 1u) {
        values_before[i] = sum;
        if (begin + i < level.at.count) sum += values.at[level.at.first + begin + i];
    }
    // Hillis and Steele: after step n each entry holds the sum of the 2ⁿ invocations up to its own.
    uint from = 0u;
    sums[0][own] = sum;
    barrier();
    for (uint reach = 1u; reach < PREFIX_GROUP; reach *= 2u) {
        sums[1u - from][own] = sums[from][own] + (own >= reach ? sums[from][own - reach] : 0u);
        from = 1u - from;
        barrier();
    }
    uint before = sums[from][own] - sum;
    for (uint i = 0u; i < VALUES_EACH; i += 1u) {
        if (begin + i < level.at.count) values.at[level.at.first + begin + i] = before + values_before[i];
    }
    if (own == PREFIX_GROUP - 1u && block * PREFIX_BLOCK < level.at.count) values.at[level.at.sums + block] = sums[from][own];
}
