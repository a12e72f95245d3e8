#pragma once
// Light lists: the picture is divided into tiles, and one pixel of each tile draws lights from the light BVH for all pixels
// around it. What a pixel's candidates are drawn by then depends on the sample data of another pixel, and on no reservoir.
#include "lights/samplers/sources.glsl"
#include "restir/sample_data.glsl"

uvec2 tile_counts() { return (picture_size() + restir.at.light_tile - 1u) / restir.at.light_tile; }

// The first word of a tile's list: its context, then for each entry a light and its probability.
uint list_word(uvec2 tile) {
    return (tile.y * tile_counts().x + tile.x) * (LIST_CONTEXT_WORDS + 2u * restir.at.light_list);
}

// The tile whose list a pixel reads: one of those that are near. If it were always the pixel's own, the borders of tiles would
// show.
uvec2 tile_near(uvec2 pixel, uvec2 bits) {
    ivec2 offset = ivec2(bits % restir.at.light_tile) - int(restir.at.light_tile / 2u);
    return uvec2(clamp(ivec2(pixel) + offset, ivec2(0), ivec2(picture_size()) - 1)) / restir.at.light_tile;
}

// Macros, because GLSL cannot pass buffers to functions.
#define STORE_VECTOR(BUFFER, WORD, VECTOR) \
    BUFFER.at[WORD] = floatBitsToUint((VECTOR).x); \
    BUFFER.at[(WORD) + 1u] = floatBitsToUint((VECTOR).y); \
    BUFFER.at[(WORD) + 2u] = floatBitsToUint((VECTOR).z)

#define LOAD_VECTOR(BUFFER, WORD) \
    uintBitsToFloat(uvec3(BUFFER.at[WORD], BUFFER.at[(WORD) + 1u], BUFFER.at[(WORD) + 2u]))

#define STORE_CONTEXT(BUFFER, WORD, CONTEXT) \
    STORE_VECTOR(BUFFER, WORD, CONTEXT.position); \
    STORE_VECTOR(BUFFER, (WORD) + 3u, CONTEXT.normal); \
    STORE_VECTOR(BUFFER, (WORD) + 6u, CONTEXT.outgoing); \
    STORE_VECTOR(BUFFER, (WORD) + 9u, vec3(CONTEXT.bsdf.diffuse, CONTEXT.bsdf.specular, CONTEXT.bsdf.specular_grazing)); \
    BUFFER.at[(WORD) + 12u] = floatBitsToUint(CONTEXT.bsdf.alpha_squared) | (HAS_TRANSMISSION && CONTEXT.bsdf.two_sided ? 1u << 31u : 0u); \
    BUFFER.at[(WORD) + 13u] = floatBitsToUint(CONTEXT.expected)

#define LOAD_CONTEXT(BUFFER, WORD, CONTEXT) \
    CONTEXT.position = LOAD_VECTOR(BUFFER, WORD); \
    CONTEXT.normal = LOAD_VECTOR(BUFFER, (WORD) + 3u); \
    CONTEXT.outgoing = LOAD_VECTOR(BUFFER, (WORD) + 6u); \
    vec3 lobes_ = LOAD_VECTOR(BUFFER, (WORD) + 9u); \
    CONTEXT.bsdf.diffuse = lobes_.x; \
    CONTEXT.bsdf.specular = lobes_.y; \
    CONTEXT.bsdf.specular_grazing = lobes_.z; \
    uint width_ = BUFFER.at[(WORD) + 12u]; \
    CONTEXT.bsdf.two_sided = HAS_TRANSMISSION && width_ >> 31u != 0u; \
    CONTEXT.bsdf.alpha_squared = uintBitsToFloat(HAS_TRANSMISSION ? width_ & 0x7FFFFFFFu : width_); \
    CONTEXT.expected = uintBitsToFloat(BUFFER.at[(WORD) + 13u])
