#pragma once
// A reservoir as words in memory.
#include "core/radiance.glsl"

// Bits of the confidence and of the age in their word. Both saturate; neither depends on the sample's value, so that
// nothing is biased. The other bits of the word belong to the sample.
const uint CONFIDENCE_BITS = 14u;
const uint AGE_BITS = 10u;
const uint SPARE_SHIFT = CONFIDENCE_BITS + AGE_BITS;
// Bits of each of the two coordinates of a point of a light: barycentric weights, or the position in a texel.
const uint UV_BITS = 20u;

// The first two words hold the weight, and confidence and age. The words of the sample follow, then those for debug
// AOVs. Large enough for every kind of sample.
struct PackedReservoir {
    uint words[INDIRECT_FULL_WORDS + DEBUG_WORDS];
};

const uint WEIGHT_WORD = 0u;
const uint HISTORY_WORD = 1u;

float unpack_confidence(uint history) { return float(bitfieldExtract(history, 0, int(CONFIDENCE_BITS))); }

PackedReservoir empty_packed() {
    PackedReservoir p;
    for (uint i = 0u; i < INDIRECT_FULL_WORDS + DEBUG_WORDS; i += 1u) p.words[i] = 0u;
    return p;
}

const float UV_STEPS = float((1u << UV_BITS) - 1u);

// In whole steps. Hits of a ray query may lie outside of their triangle by a rounding error.
vec2 uv_steps(vec2 uv) { return round(clamp(uv, 0.0, 1.0) * UV_STEPS); }

// As they are stored.
vec2 stored_uv(vec2 uv) { return uv_steps(uv) / UV_STEPS; }

// A point of a light needs a word and the spare bits. 16 bits a coordinate would be too few: on a light of two kilometres
// they are cells of three centimetres, which lobes of smooth surfaces are narrower than.
void pack_uv(vec2 uv, uint word, inout PackedReservoir p) {
    uvec2 fixed_point = uvec2(uv_steps(uv));
    p.words[word] = fixed_point.x | (fixed_point.y << UV_BITS);
    p.words[HISTORY_WORD] |= (fixed_point.y >> (32u - UV_BITS)) << SPARE_SHIFT;
}

// A colour takes a word and 7 of the spare bits.
void pack_color(uvec3 color, uint word, inout PackedReservoir p) {
    p.words[word] = color.x | (color.y << COLOR_BITS) | (color.z << (2u * COLOR_BITS));
    p.words[HISTORY_WORD] |= (color.z >> (32u - 2u * COLOR_BITS)) << SPARE_SHIFT;
}

uvec3 unpack_color(PackedReservoir p, uint word) {
    uint z = (p.words[word] >> (2u * COLOR_BITS)) | ((p.words[HISTORY_WORD] >> SPARE_SHIFT) << (32u - 2u * COLOR_BITS));
    const uint mask = (1u << COLOR_BITS) - 1u;
    return uvec3(p.words[word] & mask, (p.words[word] >> COLOR_BITS) & mask, z);
}

vec2 unpack_uv(PackedReservoir p, uint word) {
    uint x = bitfieldExtract(p.words[word], 0, int(UV_BITS));
    uint y = (p.words[word] >> UV_BITS) | ((p.words[HISTORY_WORD] >> SPARE_SHIFT) << (32u - UV_BITS));
    return vec2(x, y) / UV_STEPS;
}
