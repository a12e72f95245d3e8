// Reservoirs and where they lie. A buffer of them is words; format, arrays and order are settings.

layout(constant_id = 2) const uint RESERVOIR_FORMAT = FORMAT_COMPACT;
// Words of a reservoir beside each other (0), or equal words of all reservoirs (1).
layout(constant_id = 3) const bool RESERVOIR_SOA = false;
layout(constant_id = 4) const uint PIXEL_ORDER = ORDER_ROW;
layout(constant_id = 5) const uint SWIZZLE = 4u;

struct Reservoir {
    Sample value;
    // 0: empty, and `value` means nothing.
    float contribution_weight;
    // In initial reservoirs.
    float confidence;
    // Frames since the sample was made.
    uint age;
};

struct PackedReservoir {
    uint words[FULL_WORDS];
};

uint reservoir_words() { return RESERVOIR_FORMAT == FORMAT_FULL ? FULL_WORDS : COMPACT_WORDS; }

// Where a pixel's data lie among those of all pixels.
uint slot_of(uvec2 pixel, uvec2 size) {
    if (PIXEL_ORDER == ORDER_COLUMN) return pixel.x * size.y + pixel.y;
    if (PIXEL_ORDER == ORDER_ROW) return pixel.y * size.x + pixel.x;
    uvec2 tile = pixel / SWIZZLE, within = pixel % SWIZZLE;
    uint across = (size.x + SWIZZLE - 1u) / SWIZZLE;
    return ((tile.y * across + tile.x) * SWIZZLE + within.y) * SWIZZLE + within.x;
}

uint word_of(uint slot, uint word, uint slots) {
    return RESERVOIR_SOA ? word * slots + slot : slot * reservoir_words() + word;
}

Reservoir empty_reservoir(float confidence) {
    return Reservoir(Sample(NONE, 0u, vec3(0.0), vec3(0.0), vec3(0.0), false), 0.0, confidence, 0u);
}

// Radiance as 18 bits a channel under a shared exponent of 8: no overflow where halves have one, and
// seven more digits than they have.
uvec2 pack_radiance(vec3 radiance) {
    float most = max_component(radiance);
    if (!(most > 0.0)) return uvec2(0u);
    // The least power of two above the largest channel. Below, the scale itself would overflow.
    int exponent = max(int(floatBitsToUint(most) >> 23u) - 126, -108);
    uvec3 m = uvec3(round(ldexp(radiance, ivec3(18 - exponent))));
    m = min(m, uvec3(0x3FFFFu));
    return uvec2(m.x | (m.y << 18u), (m.y >> 14u) | (m.z << 4u) | (uint(exponent + 126) << 22u));
}

vec3 unpack_radiance(uvec2 words) {
    uvec3 m = uvec3(words.x & 0x3FFFFu, (words.x >> 18u) | ((words.y & 0xFu) << 14u), (words.y >> 4u) & 0x3FFFFu);
    int exponent = int(words.y >> 22u) - 126;
    return ldexp(vec3(m), ivec3(exponent - 18));
}

PackedReservoir pack_reservoir(Reservoir r) {
    PackedReservoir p;
    for (uint i = 0u; i < FULL_WORDS; i += 1u) p.words[i] = 0u;
    bool empty = !(r.contribution_weight > 0.0);
    uint kind = empty ? KIND_NONE : KIND_TRIANGLE;
    uint light = (kind << KIND_SHIFT) | (empty ? 0u : r.value.light);
    uint history = uint(min(r.confidence, 65535.0)) | (min(r.age, 0xFFFFu) << 16u);
    uint weight = floatBitsToUint(empty ? 0.0 : r.contribution_weight);
    if (RESERVOIR_FORMAT == FORMAT_FULL) {
        if (r.value.double_sided) light |= KIND_DOUBLE_SIDED;
        uvec3 x = floatBitsToUint(r.value.position);
        uvec2 radiance = pack_radiance(r.value.emission);
        p.words[0] = x.x;
        p.words[1] = x.y;
        p.words[2] = x.z;
        p.words[3] = light;
        p.words[4] = pack_octahedral(empty ? vec3(0.0, 0.0, 1.0) : r.value.normal, 16u);
        p.words[5] = r.value.barycentrics;
        p.words[6] = weight;
        p.words[7] = history;
        p.words[8] = radiance.x;
        p.words[9] = radiance.y;
    } else {
        p.words[0] = light;
        p.words[1] = r.value.barycentrics;
        p.words[2] = weight;
        p.words[3] = history;
    }
    return p;
}

Reservoir unpack_reservoir(PackedReservoir p) {
    bool full = RESERVOIR_FORMAT == FORMAT_FULL;
    uint light = full ? p.words[3] : p.words[0];
    uint history = full ? p.words[7] : p.words[3];
    Reservoir r = empty_reservoir(float(history & 0xFFFFu));
    r.age = history >> 16u;
    if (light >> KIND_SHIFT == KIND_NONE) return r;
    r.contribution_weight = uintBitsToFloat(full ? p.words[6] : p.words[2]);
    uint number = light & LIGHT_MASK;
    if (full) {
        r.value = Sample(number, p.words[5], uintBitsToFloat(uvec3(p.words[0], p.words[1], p.words[2])),
                         unpack_octahedral(p.words[4], 16u), unpack_radiance(uvec2(p.words[8], p.words[9])),
                         (light & KIND_DOUBLE_SIDED) != 0u);
    } else {
        r.value = sample_at(number, p.words[1]);
    }
    return r;
}

// GLSL passes no buffers, so these two are macros: PACKED is a PackedReservoir variable.
#define LOAD_RESERVOIR(BUFFER, SLOT, SLOTS, PACKED) \
    for (uint word_ = 0u; word_ < reservoir_words(); word_ += 1u) \
        PACKED.words[word_] = BUFFER.at[word_of(SLOT, word_, SLOTS)]

#define STORE_RESERVOIR(BUFFER, SLOT, SLOTS, PACKED) \
    for (uint word_ = 0u; word_ < reservoir_words(); word_ += 1u) \
        BUFFER.at[word_of(SLOT, word_, SLOTS)] = PACKED.words[word_]
