#pragma once
// Reservoirs: a selected sample with its contribution weight and confidence; packing, reading and writing; and the
// target function. Settings choose the format (compact or full), whether the words of one reservoir or equal words of
// all are side by side in memory, and the order of pixels. A pass first includes direct.glsl or indirect.glsl, which
// declare the type of the samples.
#include "core/counters.glsl"
#include "restir/packed_reservoir.glsl"
#include "restir/pixel_order.glsl"

struct Reservoir {
    Sample value;
    // Unbiased contribution weight. 0: the reservoir is empty, and `value` has no meaning.
    float contribution_weight;
    // In units of one initial reservoir.
    float confidence;
    // Frames since the sample was drawn.
    uint age;
    // With KEEPS_DEBUG_WORDS: the index of the pixel that drew the sample, and the solid angle per unit of the sample's measure
    // seen from there.
    uint origin;
    float origin_solid_angle;
};

uint sample_words() { return RESERVOIR_FORMAT == FORMAT_FULL ? FULL_WORDS : COMPACT_WORDS; }

uint reservoir_words() { return sample_words() + (KEEPS_DEBUG_WORDS ? DEBUG_WORDS : 0u); }

// With KEEPS_DEBUG_WORDS: the word with the number of neighbours that the frame's spatial passes found for the pixel.
uint neighbours_word() { return sample_words() + 2u; }

uint word_of(uint slot, uint word, uint slots) {
    return RESERVOIR_SOA ? word * slots + slot : slot * reservoir_words() + word;
}

Reservoir empty_reservoir(float confidence) { return Reservoir(empty_sample(), 0.0, confidence, 0u, NONE, 0.0); }

PackedReservoir pack_reservoir(Reservoir r) {
    PackedReservoir p = empty_packed();
    p.words[HISTORY_WORD] = min(uint(r.confidence), (1u << CONFIDENCE_BITS) - 1u)
        | (min(r.age, (1u << AGE_BITS) - 1u) << CONFIDENCE_BITS);
    if (!(r.contribution_weight > 0.0)) return p;
    p.words[WEIGHT_WORD] = floatBitsToUint(r.contribution_weight);
    pack_sample(r.value, p);
    if (KEEPS_DEBUG_WORDS) {
        p.words[sample_words()] = r.origin;
        p.words[sample_words() + 1u] = floatBitsToUint(r.origin_solid_angle);
    }
    return p;
}

// `epoch` is the one in which the reservoir was stored: the sample is placed in it.
Reservoir unpack_reservoir(PackedReservoir p, uint epoch) {
    uint history = p.words[HISTORY_WORD];
    Reservoir r = empty_reservoir(unpack_confidence(history));
    r.age = bitfieldExtract(history, int(CONFIDENCE_BITS), int(AGE_BITS));
    r.contribution_weight = uintBitsToFloat(p.words[WEIGHT_WORD]);
    if (r.contribution_weight > 0.0) unpack_sample(p, epoch, r.value);
    if (KEEPS_DEBUG_WORDS) {
        r.origin = p.words[sample_words()];
        r.origin_solid_angle = uintBitsToFloat(p.words[sample_words() + 1u]);
    }
    return r;
}

// Records the pixel that drew the sample, for debug AOVs.
void record_origin(inout Reservoir r, uint pixel, ShadingPoint shading_point) {
    if (!KEEPS_DEBUG_WORDS || r.contribution_weight <= 0.0) return;
    r.origin = pixel;
    r.origin_solid_angle = sample_solid_angle(ray_start(shading_point), r.value);
}

// The target function: the luminance that a sample adds per unit of its weight.
float target_function(ShadingPoint shading_point, Sample value) { return luminance(contribution(shading_point, value)); }

// The fraction of a sample's light that arrives: along the segment from the shading point and, where surfaces cover a part, those
// behind it that belong to the sample.
float trace_segments(ShadingPoint shading_point, Sample value, uint epoch) {
    uint segments = HAS_BLEND ? segment_count(value) : 1u;
    float passed = 1.0;
    for (uint i = 0u; passed > 0.0 && i < segments; i += 1u) {
        passed *= trace_transmittance(segment_ray(shading_point, value, i, epoch));
    }
    return passed;
}

// Macros, because GLSL cannot pass buffers to functions. PACKED is a PackedReservoir variable.
#define LOAD_RESERVOIR(BUFFER, SLOT, SLOTS, PACKED) \
    for (uint word_ = 0u; word_ < reservoir_words(); word_ += 1u) { \
        PACKED.words[word_] = BUFFER.at[word_of(SLOT, word_, SLOTS)]; \
        count_read(1u); \
    }

#define STORE_RESERVOIR(BUFFER, SLOT, SLOTS, PACKED) \
    for (uint word_ = 0u; word_ < reservoir_words(); word_ += 1u) { \
        BUFFER.at[word_of(SLOT, word_, SLOTS)] = PACKED.words[word_]; \
        count_written(1u); \
    }
