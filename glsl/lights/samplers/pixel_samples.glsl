#pragma once
// The light samples of a pixel, from all light samplers. The pass of initial candidates calls these functions only:
//
//   begin_light_samples    once per pixel
//   draw_light_sample      one sample after the other, and its density
//   merge_reused_samples   after the last one: samples that a sampler keeps from other pixels
//   pixel_weight           the MIS weight of the pixel's own candidates against those samples
//
// The file that includes this one declares `sample_data`.
#include "lights/samplers/hash_grid/grid_merge.glsl"
#include "lights/samplers/light_bvh/list_samples.glsl"
#include "lights/samplers/sources.glsl"
#include "restir/samples/direct.glsl"
#include "restir/reservoir.glsl"

struct PixelSampler {
    // Of the point that draws: the pixel's, or that of the tile which drew a list for it.
    LightSampleContext context;
    // The first word of the list, if there are lists.
    uint list;
};

PixelSampler begin_light_samples(uvec2 pixel, ShadingPoint shading_point) {
    PixelSampler source;
    source.list = 0u;
    if (LIGHT_LISTS) source.list = load_list(pixel, source.context);
    else source.context = light_sample_context(shading_point);
    return source;
}

LightSample draw_light_sample(inout PixelSampler source, uint index, uvec4 bits, out float pdf) {
    if (LIGHT_LISTS && draws_near(source.context, index, bits))
        return sample_of_list(source.list, source.context, index, bits, pdf);
    return draw_light_sample(source.context, index, bits, pdf);
}

void merge_reused_samples(uvec2 pixel, ShadingPoint shading_point, inout Stream stream, inout LightSample selected, inout Random random) {
    if (HASH_GRID == HASH_GRID_NONE) return;
    canonical_point = shading_point;
    find_in_grid(pixel, shading_point);
    merge_grid(stream, selected, random);
}

float pixel_weight(LightSample value, float target) { return canonical_weight(value, target); }
