#version 460
// The indirect light that a pixel has chosen.
#define INDIRECT
#include "shade.glsl"

layout(local_size_x = TILE * TILE) in;

void main() { shade(); }
