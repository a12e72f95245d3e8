// The one place where values enter an image: NaN, infinite and negative ones are refused and
// counted. A count above 0 on a finite scene is a bug.

layout(scalar) buffer CountersBlock { uint at[]; } counters;

vec3 accept_radiance(vec3 value, uint counter) {
    // Written so that NaN fails every comparison.
    bool good = all(greaterThanEqual(value, vec3(0.0))) && all(lessThan(value, vec3(3.402823466e38)));
    if (good) return value;
    atomicAdd(counters.at[counter], 1u);
    return vec3(0.0);
}
