// The one place where values enter an image: NaN, negative ones and those beyond MOST_RADIANCE are
// refused and counted. A count above 0 on a finite scene is a bug.

layout(scalar) buffer CountersBlock { uint at[]; } counters;

vec3 accept_radiance(vec3 value, uint counter) {
    // Written so that NaN fails every comparison.
    bool good = all(greaterThanEqual(value, vec3(0.0))) && all(lessThanEqual(value, vec3(MOST_RADIANCE)));
    if (good) return value;
    atomicAdd(counters.at[counter], 1u);
    return vec3(0.0);
}
