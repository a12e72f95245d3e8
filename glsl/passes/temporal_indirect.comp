#version 460
// Temporal reuse of indirect light.
#define INDIRECT
#include "temporal.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { merge_history(); }
