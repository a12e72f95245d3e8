#version 460
// Spatial reuse of direct light.
#include "restir/samples/direct.glsl"
#include "restir/spatial.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { merge_neighbours(); }
