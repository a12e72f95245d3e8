#pragma once
// A pixel's light samples from the list of a tile.
#include "lights/samplers/light_bvh/light_lists.glsl"

layout(scalar) readonly buffer LightListsBlock { uint at[]; } light_lists;

// The first word of the list that a pixel reads, and the point of its tile that drew the list.
uint load_list(uvec2 pixel, out LightSampleContext context) {
    Random random = pass_random(pixel, STREAM_TILES);
    uint list = list_word(tile_near(pixel, random_bits(random).xy));
    LOAD_CONTEXT(light_lists, list, context);
    count_read(LIST_CONTEXT_WORDS);
    return list;
}

// Number `index` of the samples: one entry of each part of the list, which is in the order of the walk.
LightSample sample_of_list(uint list, LightSampleContext context, uint index, uvec4 bits, out float pdf) {
    float part = (float(index) + to_unit(pcg4d(bits).x)) / float(restir.at.reuse.near_samples);
    uint entry = list + LIST_CONTEXT_WORDS + 2u * min(uint(part * float(restir.at.light_list)), restir.at.light_list - 1u);
    float near = uintBitsToFloat(light_lists.at[entry + 1u]);
    count_read(2u);
    return sample_of_light(context, false, light_lists.at[entry], near, bits, pdf);
}
