// Which pixels a spatial merge takes in. Who includes this has declared MOST_TECHNIQUES and the
// buffer `sample_data`.

// The pixel itself, and after it its neighbours.
uvec2 pixels[MOST_TECHNIQUES];

// Chooses neighbours by their surfaces alone, and returns how many there are with the pixel itself.
// Those that are refused are made up for while tries last: lanes whose lists are equally long idle less.
uint find_neighbours(uvec2 pixel, SampleData data, inout Random random) {
    Ray ray = primary_ray(pixel);
    pixels[0] = pixel;
    uint found = 1u;
    for (uint i = 0u; i < restir.at.tries && found <= NEIGHBOURS; i += 1u) {
        vec2 u = to_unit(random_bits(random)).xy;
        // Half of them within a quarter of the radius, where surfaces and light are most alike; the rest bring
        // samples that those around do not share.
        vec2 offset = mix(min(1.0, restir.at.radius), restir.at.radius, square(u.x)) * on_circle(u.y);
        ivec2 other = ivec2(pixel) + ivec2(round(offset));
        if (other == ivec2(pixel) || is_outside(other)) continue;
        if (!similar(data, ray, sample_data.at[slot_of(uvec2(other))], primary_ray(uvec2(other)))) continue;
        pixels[found] = uvec2(other);
        found += 1u;
    }
    return found;
}
