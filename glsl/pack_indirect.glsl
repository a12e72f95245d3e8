// How reservoirs store samples of indirect light.
#include "radiance.glsl"

#define Sample IndirectSample
// In a full reservoir's material: the corners have normals.
const uint INTERPOLATED = 0x80000000u;

Sample empty_sample() {
    TrianglePoint point = TrianglePoint(vec3(0.0), vec3(0.0), vec3(0.0, 0.0, 1.0), vec3(0.0, 0.0, 1.0), false);
    return Sample(PATH_NONE, NONE, 0u, vec2(0.0), NONE, 0u, vec3(0.0, 0.0, 1.0), vec3(0.0), point, 0.0, 0u);
}

void pack_sample(Sample value, inout PackedReservoir p) {
    p.words[2] = (value.kind << KIND_SHIFT) | value.instance;
    p.words[3] = value.primitive;
    uvec2 barycentrics = floatBitsToUint(value.barycentrics);
    p.words[4] = barycentrics.x;
    p.words[5] = barycentrics.y;
    if (value.kind == PATH_TO_LIGHT) {
        p.words[6] = (KIND_TRIANGLE << KIND_SHIFT) | value.light;
        p.words[7] = value.light_barycentrics;
    } else {
        p.words[6] = pack_octahedral(value.direction, 16u);
        // What was unpacked once goes back as it was.
        p.words[7] = pack_color(value.radiance, vec3(0.5));
    }
    if (RESERVOIR_FORMAT != FORMAT_FULL) return;
    uvec3 position = floatBitsToUint(value.point.position);
    p.words[8] = position.x;
    p.words[9] = position.y;
    p.words[10] = position.z;
    p.words[11] = floatBitsToUint(value.clearance);
    p.words[12] = pack_octahedral(value.point.normal, 16u);
    p.words[13] = pack_octahedral(value.point.shading_normal, 16u);
    p.words[14] = value.material | (value.point.interpolated ? INTERPOLATED : 0u);
}

Sample unpack_sample(PackedReservoir p) {
    Sample value = empty_sample();
    value.kind = p.words[2] >> KIND_SHIFT;
    value.instance = p.words[2] & INSTANCE_MASK;
    value.primitive = p.words[3];
    value.barycentrics = uintBitsToFloat(uvec2(p.words[4], p.words[5]));
    if (RESERVOIR_FORMAT == FORMAT_FULL) {
        value.point.position = uintBitsToFloat(uvec3(p.words[8], p.words[9], p.words[10]));
        value.clearance = uintBitsToFloat(p.words[11]);
        value.point.normal = unpack_octahedral(p.words[12], 16u);
        value.point.shading_normal = unpack_octahedral(p.words[13], 16u);
        value.point.interpolated = (p.words[14] & INTERPOLATED) != 0u;
        value.material = p.words[14] & ~INTERPOLATED;
    } else {
        place_vertex(value, value.instance);
    }
    if (value.kind == PATH_TO_LIGHT) {
        value.light = p.words[6] & LIGHT_MASK;
        value.light_barycentrics = p.words[7];
        aim_at_light(value, value.light);
    } else {
        value.direction = unpack_octahedral(p.words[6], 16u);
        value.radiance = unpack_color(p.words[7]);
    }
    return value;
}

// A new sample as others will find it, but for its colour.
Sample stored(Sample value) {
    PackedReservoir packed;
    pack_sample(value, packed);
    Sample found = unpack_sample(packed);
    if (value.kind != PATH_TO_LIGHT) found.radiance = value.radiance;
    return found;
}

// Its colour too, once the sample's weight is known: judged by what chance made of the colour, the weight would
// make up in one channel for what another has lost.
void round_color(inout Sample value, inout Random random) {
    value.radiance = unpack_color(pack_color(value.radiance, to_unit(random_bits(random)).xyz));
}

vec3 place_of(Sample value) { return value.point.position; }

vec3 normal_of(Sample value) { return value.point.normal; }
