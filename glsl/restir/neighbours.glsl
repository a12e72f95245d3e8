#pragma once
// The choice of neighbours for a spatial merge.
#include "restir/similarity.glsl"

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);

// The canonical and its neighbours.
const uint MAX_TECHNIQUES = NEIGHBOURS + 1u;

// The pixel itself, followed by its neighbours.
uvec2 pixels[MAX_TECHNIQUES];

// Fills `pixels` with the pixel and up to `wanted` neighbours, and returns how many these are, the pixel included.
// Neighbours are chosen by their surfaces alone. A rejected one is replaced while tries remain (greedy search):
// invocations whose lists have the same length idle less.
uint find_neighbours(uvec2 pixel, SampleData data, uint wanted, inout Random random) {
    Ray ray = primary_ray(pixel);
    pixels[0] = pixel;
    uint found = 1u;
    for (uint i = 0u; i < wanted * restir.at.reuse.tries && found <= wanted; i += 1u) {
        vec2 u = to_unit(random_bits(random)).xy;
        // Half of them lie within a quarter of the radius, where surface and light are most similar. The others bring
        // samples that close neighbours do not have.
        vec2 offset = mix(min(1.0, restir.at.reuse.radius), restir.at.reuse.radius, square(u.x)) * on_circle(u.y);
        ivec2 other = ivec2(pixel) + ivec2(round(offset));
        if (other == ivec2(pixel) || is_outside(other)) continue;
        if (!is_similar(data, ray, LOAD_SAMPLE_DATA(sample_data, slot_of(uvec2(other))), primary_ray(uvec2(other)))) continue;
        pixels[found] = uvec2(other);
        found += 1u;
    }
    return found;
}
