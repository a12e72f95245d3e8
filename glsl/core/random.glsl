#pragma once
// Counter-based random numbers: draw n of a sample is a hash of (pixel, sample, seed, n), so results depend
// neither on the number of threads nor on how samples are split into dispatches.
// pcg4d: Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020.
#include "prelude.glsl"

struct Random {
    uvec4 counter;
};

Random random_start(uint pixel, uint sample_index, uint seed) {
    return Random(uvec4(pixel, sample_index, seed, 0u));
}

// One of several streams of a sample. The starts of streams 0 to 88 are at least 2^25 draws apart, those of world reservoirs at
// least 2^19. They are multiples of the golden ratio, because the hash carries bits only upward: starts that differ in a few high
// bits alone would give correlated numbers.
Random random_stream(uint pixel, uint sample_index, uint seed, uint stream) {
    return Random(uvec4(pixel, sample_index, seed, stream * 0x9E3779B9u));
}

uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

uvec4 random_bits(inout Random random) {
    random.counter.w += 1u;
    return pcg4d(random.counter);
}

// 24 bits, in [0, 1).
float to_unit(uint bits) { return float(bits >> 8u) * 5.9604644775390625e-8; }

vec4 to_unit(uvec4 bits) { return vec4(bits >> 8u) * 5.9604644775390625e-8; }

// A uniform number in (0, 1] that decides whether a weighted candidate is selected. Small numbers are as precise as
// large ones, and none is 0: a rare candidate would otherwise be selected too often, and take on the weight of all.
float random_choice(uvec2 bits) {
    float rest = (float(bits.y) + 0.5) * 2.3283064365386963e-10;
    return (float(bits.x) + rest) * 2.3283064365386963e-10;
}

float random_choice(inout Random random) { return random_choice(random_bits(random).xy); }

// An integer below `count` from 64 random bits, and 32 bits that are uniform whichever it is. With 32 bits alone, the
// probabilities of ten million integers would differ by a thousandth.
uint scale_to(uvec2 bits, uint count, out uint fraction) {
    uint high, low, carried, unused;
    umulExtended(bits.x, count, high, low);
    umulExtended(bits.y, count, carried, unused);
    fraction = low + carried;
    return high + (fraction < low ? 1u : 0u);
}

uint scale_to(uvec2 bits, uint count) {
    uint unused;
    return scale_to(bits, count, unused);
}
