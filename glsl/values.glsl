// The one place where values enter an image or a reservoir: NaN, negative ones and those beyond MOST_RADIANCE are
// refused and counted. A count above 0 on a finite scene is a bug.

vec3 accept_radiance(vec3 value) {
    // Written so that NaN fails every comparison.
    bool good = all(greaterThanEqual(value, vec3(0.0))) && all(lessThanEqual(value, vec3(MOST_RADIANCE)));
    if (good) return value;
    count_fault(COUNTER_REJECTED);
    return vec3(0.0);
}

// A weight, of a candidate or of a reservoir.
float accept_weight(float value) {
    if (value >= 0.0 && value <= LARGEST) return value;
    count_fault(COUNTER_REJECTED);
    return 0.0;
}
