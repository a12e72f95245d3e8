// Russian roulette: dim paths end by chance, and those that go on make up for them.

// Decides after so many scatterings by a number in 0…1; returns whether the path goes on.
bool survives_roulette(inout vec3 throughput, uint scatterings, uint start, float least, float number) {
    if (scatterings < start) return true;
    float survival = clamp(max_component(throughput), least, 1.0);
    throughput /= survival;
    return number < survival;
}
