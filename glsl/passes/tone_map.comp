#version 460
// The picture as a display shows it, from radiance or from sums of radiance.
#include "core/tone_map.glsl"
#include "core/workgroups.glsl"

layout(local_size_x = TILE, local_size_y = TILE) in;

layout(scalar) readonly buffer RadianceBlock { float at[]; } radiance;
layout(scalar) writeonly buffer DisplayBlock { uint at[]; } display;
layout(push_constant, scalar) uniform ToneBlock { ToneMap at; } tone;

void main() {
    uint pixel = invocation_index(1u);
    if (pixel >= tone.at.pixels) return;
    uint first = pixel * tone.at.stride;
    vec3 value = vec3(radiance.at[first], radiance.at[first + 1u], radiance.at[first + 2u]);
    vec3 shown = tone_map(value * tone.at.scale);
    display.at[tone.at.first_pixel + pixel] = srgb_bytes(tone.at.begins_with_blue != 0u ? shown.bgr : shown);
}
