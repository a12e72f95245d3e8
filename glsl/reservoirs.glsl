// Reservoirs and where they lie. A buffer of them is words; format, arrays and order are settings.

layout(constant_id = 2) const uint RESERVOIR_FORMAT = FORMAT_COMPACT;
// Words of a reservoir beside each other (0), or equal words of all reservoirs (1).
layout(constant_id = 3) const bool RESERVOIR_SOA = false;
layout(constant_id = 4) const uint PIXEL_ORDER = ORDER_ROW;
layout(constant_id = 5) const uint SWIZZLE = 4u;
// Whether reservoirs remember where their samples come from, for those who look for faults.
layout(constant_id = 17) const bool KEEPS_ORIGINS = false;

// Of either kind of sample the first words hold weight and history.
const uint WEIGHT_WORD = 0u;
const uint HISTORY_WORD = 1u;

#ifdef INDIRECT
const uint COMPACT_WORDS = INDIRECT_COMPACT_WORDS;
const uint FULL_WORDS = INDIRECT_FULL_WORDS;
#else
const uint COMPACT_WORDS = DIRECT_COMPACT_WORDS;
const uint FULL_WORDS = DIRECT_FULL_WORDS;
#endif

struct PackedReservoir {
    uint words[FULL_WORDS + ORIGIN_WORDS];
};

// The kind's Sample, and how it is stored.
#ifdef INDIRECT
#include "pack_indirect.glsl"
#else
#include "pack_direct.glsl"
#endif

struct Reservoir {
    Sample value;
    // 0: empty, and `value` means nothing.
    float contribution_weight;
    // In initial reservoirs.
    float confidence;
    // Frames since the sample was made.
    uint age;
    // With KEEPS_ORIGINS the number of the pixel that made it, and the solid angle that a unit of area around the
    // sample had from there.
    uint origin;
    float origin_spread;
};

uint sample_words() { return RESERVOIR_FORMAT == FORMAT_FULL ? FULL_WORDS : COMPACT_WORDS; }

uint reservoir_words() { return sample_words() + (KEEPS_ORIGINS ? ORIGIN_WORDS : 0u); }

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

Reservoir empty_reservoir(float confidence) { return Reservoir(empty_sample(), 0.0, confidence, 0u, NONE, 0.0); }

PackedReservoir pack_reservoir(Reservoir r) {
    PackedReservoir p;
    for (uint i = 0u; i < FULL_WORDS + ORIGIN_WORDS; i += 1u) p.words[i] = 0u;
    p.words[HISTORY_WORD] = uint(min(r.confidence, 65535.0)) | (min(r.age, 0xFFFFu) << 16u);
    if (!(r.contribution_weight > 0.0)) return p;
    p.words[WEIGHT_WORD] = floatBitsToUint(r.contribution_weight);
    pack_sample(r.value, p);
    if (KEEPS_ORIGINS) {
        p.words[sample_words()] = r.origin;
        p.words[sample_words() + 1u] = floatBitsToUint(r.origin_spread);
    }
    return p;
}

Reservoir unpack_reservoir(PackedReservoir p) {
    uint history = p.words[HISTORY_WORD];
    Reservoir r = empty_reservoir(float(history & 0xFFFFu));
    r.age = history >> 16u;
    r.contribution_weight = uintBitsToFloat(p.words[WEIGHT_WORD]);
    if (r.contribution_weight > 0.0) r.value = unpack_sample(p);
    if (KEEPS_ORIGINS) {
        r.origin = p.words[sample_words()];
        r.origin_spread = uintBitsToFloat(p.words[sample_words() + 1u]);
    }
    return r;
}

// The solid angle that a unit of area around a sample has from a point.
float sample_spread(vec3 from, Sample value) {
    vec3 direction;
    float cosine;
    return spread_of(from, place_of(value), normal_of(value), direction, cosine);
}

// Marks a sample as made by the pixel of this number.
void mark_origin(inout Reservoir r, uint number, Domain domain) {
    if (!KEEPS_ORIGINS || r.contribution_weight <= 0.0) return;
    r.origin = number;
    r.origin_spread = sample_spread(domain.position, r.value);
}

// What resampling aims at: the luminance that a sample adds for each unit of its weight.
float target_function(Domain domain, Sample value) { return luminance(contribution(domain, value)); }

// GLSL passes no buffers, so these two are macros: PACKED is a PackedReservoir variable.
#define LOAD_RESERVOIR(BUFFER, SLOT, SLOTS, PACKED) \
    for (uint word_ = 0u; word_ < reservoir_words(); word_ += 1u) \
        PACKED.words[word_] = BUFFER.at[word_of(SLOT, word_, SLOTS)]

#define STORE_RESERVOIR(BUFFER, SLOT, SLOTS, PACKED) \
    for (uint word_ = 0u; word_ < reservoir_words(); word_ += 1u) \
        BUFFER.at[word_of(SLOT, word_, SLOTS)] = PACKED.words[word_]
