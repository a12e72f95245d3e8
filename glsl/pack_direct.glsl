// How reservoirs store samples of direct light.
#include "radiance.glsl"

#define Sample LightSample

Sample empty_sample() { return Sample(NONE, 0u, vec3(0.0), vec3(0.0), vec3(0.0), false); }

void pack_sample(Sample value, inout PackedReservoir p) {
    p.words[2] = (KIND_TRIANGLE << KIND_SHIFT) | value.light;
    p.words[3] = value.barycentrics;
    if (RESERVOIR_FORMAT != FORMAT_FULL) return;
    if (value.double_sided) p.words[2] |= KIND_DOUBLE_SIDED;
    uvec3 position = floatBitsToUint(value.position);
    uvec2 radiance = pack_radiance(value.emission);
    // A vector is not split over blocks of 16 bytes.
    p.words[4] = position.x;
    p.words[5] = position.y;
    p.words[6] = position.z;
    p.words[7] = pack_octahedral(value.normal, 16u);
    p.words[8] = radiance.x;
    p.words[9] = radiance.y;
}

Sample unpack_sample(PackedReservoir p) {
    uint light = p.words[2] & LIGHT_MASK;
    if (RESERVOIR_FORMAT != FORMAT_FULL) return sample_at(light, p.words[3]);
    return Sample(light, p.words[3], uintBitsToFloat(uvec3(p.words[4], p.words[5], p.words[6])),
                  unpack_octahedral(p.words[7], 16u), unpack_radiance(uvec2(p.words[8], p.words[9])),
                  (p.words[2] & KIND_DOUBLE_SIDED) != 0u);
}

vec3 place_of(Sample value) { return value.position; }

vec3 normal_of(Sample value) { return value.normal; }
