#pragma once
// From radiance to display values, as src/image/tonemap.rs does it for PNG files.
#include "prelude.glsl"

// Radiance to display brightness, both linear RGB: the Khronos PBR neutral tone mapper without its toe.
vec3 tone_map(vec3 radiance) {
    // NaN becomes 0 too, and the arithmetic below stays finite.
    vec3 colour = mix(vec3(0.0), min(radiance, vec3(3.402823466e38)), greaterThan(radiance, vec3(0.0)));
    float peak = max(colour.r, max(colour.g, colour.b));
    if (peak <= TONE_KNEE) return colour;
    float room = 1.0 - TONE_KNEE;
    float mapped = 1.0 - room * (room / (peak - TONE_KNEE + room));
    float white = 1.0 - 1.0 / (TONE_DESATURATION * (peak - mapped) + 1.0);
    return mix((colour / peak) * mapped, vec3(mapped), white);
}

// Linear to sRGB (IEC 61966-2-1), 0…1.
vec3 to_srgb(vec3 value) {
    return mix(1.055 * pow(value, vec3(1.0 / 2.4)) - 0.055, 12.92 * value, lessThanEqual(value, vec3(0.0031308)));
}

// A display value as 8-bit sRGB, red in the least significant byte; what lies outside 0…1 is clamped.
uint srgb_bytes(vec3 value) {
    uvec3 bytes = uvec3(round(to_srgb(clamp(value, 0.0, 1.0)) * 255.0));
    return bytes.r | bytes.g << 8u | bytes.b << 16u | 0xFF000000u;
}
