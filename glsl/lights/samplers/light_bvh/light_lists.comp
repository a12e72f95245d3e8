#version 460
// Draws the light list of each tile from the light BVH.
#include "lights/samplers/light_bvh/light_lists.glsl"

layout(local_size_x = TILE * TILE) in;

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
layout(scalar) writeonly buffer LightListsBlock { uint at[]; } light_lists;

// Pixels that are tried until one shows a surface.
const uint TRIES = 4u;

void main() {
    uvec2 tile = tile_pixel(tile_counts().x, 0u, restir.at.view.interleave);
    if (any(greaterThanEqual(tile, tile_counts()))) return;
    Random random = random_stream(tile.y * tile_counts().x + tile.x, restir.at.frame, restir.at.view.seed, STREAM_LISTS);
    LightSampleContext context = distant_context();
    for (uint i = 0u; i < TRIES; i += 1u) {
        uvec2 pixel = min(tile * restir.at.light_tile + random_bits(random).xy % restir.at.light_tile, picture_size() - 1u);
        SampleData data = LOAD_SAMPLE_DATA(sample_data, slot_of(pixel));
        if (!has_surface(data)) continue;
        context = light_sample_context(unpack_shading_point(data, primary_ray(pixel)));
        break;
    }
    uint word = list_word(tile);
    STORE_CONTEXT(light_lists, word, context);
    count_written(LIST_CONTEXT_WORDS);
    if (!has_near_lights(context)) return;
    uint i = 0u;
    for (; i < restir.at.light_list; i += 1u) {
        float probability;
        uint light = draw_near_light(context, i, restir.at.light_list, random_bits(random).xy, probability);
        uint entry = word + LIST_CONTEXT_WORDS + 2u * i;
        light_lists.at[entry] = light;
        light_lists.at[entry + 1u] = floatBitsToUint(probability);
        count_written(2u);
    }
    if (i < restir.at.light_list) count_fault(COUNTER_CUT_SHORT);
}
