#pragma once
// Russian roulette: dim paths end at random, and those that continue are weighted up to compensate.
#include "core/math.glsl"

// Returns whether a path continues after its `scatterings`-th scattering event; `number` is uniform in [0, 1).
bool survives_roulette(inout vec3 throughput, uint scatterings, uint start, float min_survival, float number) {
    if (scatterings < start) return true;
    float survival = clamp(max_component(throughput), min_survival, 1.0);
    throughput /= survival;
    return number < survival;
}
