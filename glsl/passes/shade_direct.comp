#version 460
// The direct light that a pixel has chosen.
#include "shade.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { shade(); }
