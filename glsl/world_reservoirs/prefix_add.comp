#version 460
// Adds to each block of prefix sums the sum of the blocks before it.
#include "core/workgroups.glsl"

layout(local_size_x = PREFIX_GROUP) in;

layout(scalar) buffer ValuesBlock { uint at[]; } values;
layout(push_constant, scalar) uniform LevelBlock { PrefixLevel at; } level;

void main() {
    uint block = group_index();
    // The first has none before it.
    if (block == 0u) return;
    for (uint i = gl_LocalInvocationIndex; i < PREFIX_BLOCK; i += PREFIX_GROUP) {
        uint at = block * PREFIX_BLOCK + i;
        if (at < level.at.count) values.at[level.at.first + at] += values.at[level.at.sums + block];
    }
}
