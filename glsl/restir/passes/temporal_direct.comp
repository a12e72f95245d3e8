#version 460
// Temporal reuse of direct light.
#include "restir/samples/direct.glsl"
#include "restir/temporal.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { merge_history(); }
