#version 460
// Spatial reuse of indirect light.
#define INDIRECT
#include "spatial.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { merge_neighbours(); }
