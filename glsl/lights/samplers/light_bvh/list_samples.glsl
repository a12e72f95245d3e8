#pragma once
// A pixel's light samples from the list of a tile.
#include "lights/samplers/light_bvh/light_lists.glsl"

layout(scalar) readonly buffer LightListsBlock { uint at[]; } light_lists;

// The first word of the list that a pixel reads, and the point of its tile that drew the list.
uint load_list(uvec2 pixel, out Receiver receiver) {
    Random random = pass_random(pixel, STREAM_TILES);
    uint list = list_word(tile_near(pixel, random_bits(random).xy));
    LOAD_RECEIVER(light_lists, list, receiver);
    count_read(LIST_RECEIVER_WORDS);
    return list;
}

// Number `index` of the samples: one entry of each part of the list, which is in the order of the walk.
LightSample sample_of_list(uint list, Receiver receiver, uint index, uvec4 bits, out float pdf) {
    float part = (float(index) + to_unit(pcg4d(bits).x)) / float(restir.at.reuse.near_samples);
    uint entry = list + LIST_RECEIVER_WORDS + 2u * min(uint(part * float(restir.at.light_list)), restir.at.light_list - 1u);
    float near = uintBitsToFloat(light_lists.at[entry + 1u]);
    count_read(2u);
    return sample_of_light(receiver, false, light_lists.at[entry], near, bits, pdf);
}
