#version 460
// Debug AOVs of the reservoirs of indirect light.
#include "restir/samples/indirect.glsl"
#include "restir/reservoir_aovs.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { write_aovs(); }
