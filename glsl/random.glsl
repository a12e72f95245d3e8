// Random numbers by counting: the n-th draw of a sample is a hash of (pixel, sample, seed, n), so
// results depend neither on threads nor on how samples are split into dispatches.
// pcg4d: Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020.

struct Random {
    uvec4 counter;
};

Random random_start(uint pixel, uint sample_number, uint seed) {
    return Random(uvec4(pixel, sample_number, seed, 0u));
}

// One of several streams of a sample: 0 to 88 are 2^25 draws apart. They start where the golden ratio takes them:
// the hash carries bits upward, and what differs in a few high bits alone comes out alike.
Random random_stream(uint pixel, uint sample_number, uint seed, uint stream) {
    return Random(uvec4(pixel, sample_number, seed, stream * 0x9E3779B9u));
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

// A whole number below `count`, from 32 random bits.
uint scale_to(uint bits, uint count) {
    uint high, low;
    umulExtended(bits, count, high, low);
    return high;
}
