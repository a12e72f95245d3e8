#pragma once
// The one place where values enter an image or a reservoir. NaN, negative values and those above MAX_RADIANCE are
// rejected and counted; a count above 0 on a finite scene is a bug.
#include "core/counters.glsl"
#include "core/math.glsl"

vec3 accept_radiance(vec3 value) {
    // Written so that NaN fails every comparison.
    bool good = all(greaterThanEqual(value, vec3(0.0))) && all(lessThanEqual(value, vec3(MAX_RADIANCE)));
    if (good) return value;
    count_fault(COUNTER_REJECTED);
    return vec3(0.0);
}

// The weight of a candidate or of a reservoir.
float accept_weight(float value) {
    if (value >= 0.0 && value <= LARGEST) return value;
    count_fault(COUNTER_REJECTED);
    return 0.0;
}
