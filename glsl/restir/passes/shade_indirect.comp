#version 460
// Adds the selected indirect light to each pixel.
#include "restir/samples/indirect.glsl"
#include "restir/shade.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { shade(); }
