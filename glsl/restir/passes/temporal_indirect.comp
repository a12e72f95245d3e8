#version 460
// Temporal reuse of indirect light.
#include "restir/samples/indirect.glsl"
#include "restir/temporal.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { merge_history(); }
