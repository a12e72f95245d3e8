#version 460
// Spatial reuse of indirect light.
#include "restir/samples/indirect.glsl"
#include "restir/spatial.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { merge_neighbours(); }
