#pragma once
// Radiance in 13 bits a channel: the exponent of a float and five bits of its mantissa. Rounding is random, so that the
// mean is exact. Each channel has its own exponent: with one for all three, a channel much dimmer than the brightest
// would usually round to 0, and rarely to a value far too bright. Surfaces that reflect only this channel would show it.
#include "core/math.glsl"

const uint COLOR_BITS = 13u;
// What a float has besides, and the sign.
const uint COLOR_SHIFT = 31u - COLOR_BITS;

// Rounds up or down by `numbers` in [0, 1), so that the expectation of each channel is exact. Rounding to nearest would
// bias every frame in the same way.
uvec3 pack_color(vec3 radiance, vec3 numbers) {
    // Without the sign, because -0 would become the largest number.
    uvec3 bits = (floatBitsToUint(radiance) & 0x7FFFFFFFu) + uvec3(numbers * float(1u << COLOR_SHIFT));
    // The largest number is not rounded up to infinity.
    return min(bits, uvec3(0x7F7FFFFFu)) >> COLOR_SHIFT;
}

vec3 unpack_color(uvec3 color) { return uintBitsToFloat(color << COLOR_SHIFT); }
