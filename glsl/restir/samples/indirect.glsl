#pragma once
// Indirect light: its reservoirs hold path samples.
#include "restir/samples/path_sample.glsl"

#define Sample PathSample
#define empty_sample empty_path_sample

const uint COMPACT_WORDS = INDIRECT_COMPACT_WORDS;
const uint FULL_WORDS = INDIRECT_FULL_WORDS;
// Added to the random stream of a pass.
const uint FIRST_STREAM = STREAM_INDIRECT;
