#version 460
// Adds a frame's radiance, and its square, to the sums of each pixel; with alpha, also whether its ray met a surface.
#include "core/math.glsl"
#include "core/workgroups.glsl"

layout(local_size_x = TILE, local_size_y = TILE) in;

layout(scalar) readonly buffer ColorBlock { vec3 at[]; } color;
layout(scalar) buffer SumsBlock { PixelSums at[]; } sums;
layout(scalar) readonly buffer CoveredBlock { uint at[]; } covered;
layout(scalar) buffer CoverageBlock { uint at[]; } coverage;
layout(push_constant, scalar) uniform RangeBlock { PixelRange at; } range;

void main() {
    uint pixel = invocation_index(1u);
    if (pixel >= range.at.pixels) return;
    vec3 radiance = color.at[range.at.first_pixel + pixel];
    PixelSums total = sums.at[pixel];
    pair_add(total.sum, total.sum_low, radiance);
    pair_add(total.square, total.square_low, radiance * radiance);
    sums.at[pixel] = total;
    if (TRACKS_COVERAGE) coverage.at[pixel] += covered.at[range.at.first_pixel + pixel];
}
