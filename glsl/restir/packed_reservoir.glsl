#pragma once
// A reservoir as words in memory.
#include "prelude.glsl"

// The first two words hold the weight, and confidence and age. The words of the sample follow, then those of its
// origin. Large enough for every kind of sample.
struct PackedReservoir {
    uint words[INDIRECT_FULL_WORDS + ORIGIN_WORDS];
};

const uint WEIGHT_WORD = 0u;
const uint HISTORY_WORD = 1u;
