#pragma once
// Radiance packed into two words, and into one.
#include "core/math.glsl"

// 18 bits a channel and a shared exponent of 8 bits: no overflow where half floats have one, and seven more bits
// of precision.
uvec2 pack_radiance(vec3 radiance) {
    float most = max_component(radiance);
    if (!(most > 0.0)) return uvec2(0u);
    // The least power of two above the largest channel. Below, the scale itself would overflow.
    int exponent = max(int(floatBitsToUint(most) >> 23u) - 126, -108);
    uvec3 m = uvec3(round(ldexp(radiance, ivec3(18 - exponent))));
    m = min(m, uvec3(0x3FFFFu));
    return uvec2(m.x | (m.y << 18u), (m.y >> 14u) | (m.z << 4u) | (uint(exponent + 126) << 22u));
}

vec3 unpack_radiance(uvec2 words) {
    uvec3 m = uvec3(words.x & 0x3FFFFu, (words.x >> 18u) | ((words.y & 0xFu) << 14u), (words.y >> 4u) & 0x3FFFFu);
    int exponent = int(words.y >> 22u) - 126;
    return ldexp(vec3(m), ivec3(exponent - 18));
}

// 8 bits a channel and a shared exponent of 8 bits, rounded up or down by `numbers` in [0, 1), so that the expectation
// of each channel is exact. Rounding to nearest would bias the dim channels of a coloured light in every frame.
uint pack_color(vec3 radiance, vec3 numbers) {
    float most = max_component(radiance);
    if (!(most > 0.0)) return 0u;
    int exponent = max(int(floatBitsToUint(most) >> 23u) - 126, -118);
    // Above the last of the 256 steps there is no step to round up to.
    if (ldexp(most, 8 - exponent) > 255.0) exponent += 1;
    // The sum itself rounds, from just below 256 to 256, which would carry into the next channel.
    uvec3 m = min(uvec3(ldexp(radiance, ivec3(8 - exponent)) + numbers), uvec3(0xFFu));
    return m.x | (m.y << 8u) | (m.z << 16u) | (uint(exponent + 126) << 24u);
}

vec3 unpack_color(uint word) {
    uvec3 m = uvec3(word & 0xFFu, (word >> 8u) & 0xFFu, (word >> 16u) & 0xFFu);
    return ldexp(vec3(m), ivec3(int(word >> 24u) - 134));
}
