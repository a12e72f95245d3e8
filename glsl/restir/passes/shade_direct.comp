#version 460
// Adds the selected direct light to each pixel.
#include "restir/samples/direct.glsl"
#include "restir/shade.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { shade(); }
