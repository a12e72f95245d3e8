#pragma once
// Direct light: its reservoirs hold light samples.
#include "restir/samples/light_sample.glsl"

#define Sample LightSample
#define empty_sample empty_light_sample

const uint COMPACT_WORDS = DIRECT_COMPACT_WORDS;
const uint FULL_WORDS = DIRECT_FULL_WORDS;
// Added to the random stream of a pass.
const uint FIRST_STREAM = 0u;
