#version 460
// What a frame left in its reservoirs of direct light.
#include "reservoir_aovs.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { look(); }
