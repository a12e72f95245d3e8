#pragma once
// The BSDF of a surface: what all of its lobes (`bsdf/lobes.glsl`) reflect together. Other files call the functions below and read
// no member. Directions are in the shading frame, normal +Z, and point away from the surface.
#include "bsdf/lobes.glsl"

#define LOBE_MEMBER(TYPE, NAME, DELTA) TYPE NAME;
struct Bsdf { BSDF_LOBES(LOBE_MEMBER) };

#define LOBE_ONE(TYPE, NAME, DELTA) + 1u
const uint LOBE_COUNT = 0u BSDF_LOBES(LOBE_ONE);

// The largest number of delta lobes of a surface.
#define LOBE_DELTA(TYPE, NAME, DELTA) + DELTA
const uint MAX_DELTA_LOBES = 0u BSDF_LOBES(LOBE_DELTA);

// True if a lobe of `bsdf` reflects one direction only.
#define IS_DELTA(NAME, DELTA) (DELTA == 1u && alpha_of(bsdf.NAME) == 0.0)

struct BsdfSample {
    vec3 direction;
    // f · |cos| / pdf.
    vec3 weight;
    // 0 for a delta lobe.
    float pdf_solid_angle;
    bool delta;
    bool valid;
};

// The BSDF of a material and its layers for one outgoing direction.
Bsdf make_bsdf(GpuMaterial material, Layers layers, vec3 outgoing) {
    Bsdf bsdf;
    float cosine_out = max(outgoing.z, 0.0);
#define LOBE_MAKE(TYPE, NAME, DELTA) make_lobe(material, layers, outgoing, bsdf.NAME);
    BSDF_LOBES(LOBE_MAKE)
    // `left` is the light that the lobes from one to the bottom are expected to reflect; it begins with the sum over all.
    float left = 0.0, below = 1.0;
    uint reflecting = 0u, index = 0u;
#define LOBE_EXPECT(TYPE, NAME, DELTA) \
    bsdf.NAME.choice = expected(bsdf.NAME, below, cosine_out); \
    left += bsdf.NAME.choice; \
    below *= passes(bsdf.NAME, cosine_out); \
    if (reflects(bsdf.NAME)) reflecting += 1u;
    BSDF_LOBES(LOBE_EXPECT)
    // Every lobe keeps a minimum probability, because the estimates hold at the mirror direction only. What no other lobe takes is
    // the bottom's.
#define LOBE_CHOOSE(TYPE, NAME, DELTA) \
    { \
        float part = bsdf.NAME.choice; \
        bool has = reflects(bsdf.NAME); \
        if (has) reflecting -= 1u; \
        bsdf.NAME.choice = !has ? 0.0 : reflecting == 0u ? 1.0 : clamp(part / max(left, TINY), 0.1, 0.9); \
        index += 1u; \
        if (index == LOBE_COUNT) bsdf.NAME.choice = 1.0; \
        left -= part; \
    }
    BSDF_LOBES(LOBE_CHOOSE)
    return bsdf;
}

// True if light of a direction can be seen, by its cosines to both normals: both must be on one side. Light from below the surface
// comes through it.
bool is_seen(float geometric_cosine, float shading_cosine) {
    return HAS_TRANSMISSION ? geometric_cosine * shading_cosine > 0.0 : geometric_cosine > 0.0;
}

// The cosine by which light of a direction is spread over the surface.
float spread_cosine(float shading_cosine) { return HAS_TRANSMISSION ? abs(shading_cosine) : max(shading_cosine, 0.0); }

// f and the density of sampling it; below the horizon both are those of light that comes through the surface. Delta lobes are not
// included.
vec3 evaluate_bsdf(Bsdf bsdf, vec3 outgoing, vec3 incoming, out float pdf_solid_angle) {
    pdf_solid_angle = 0.0;
    vec3 f = vec3(0.0);
    bool through = HAS_TRANSMISSION && incoming.z < 0.0;
    if (outgoing.z <= 0.0 || (incoming.z <= 0.0 && !through)) return f;
    vec3 h;
    if (through) h = half_through(bsdf.transmission, outgoing, incoming);
    else h = normalize(outgoing + incoming);
    float cosine = dot(outgoing, h), below = 1.0, left = 1.0;
    // What passes a lobe is found before the branch, so that the compiler shares the Fresnel terms of both.
#define LOBE_EVALUATE(TYPE, NAME, DELTA) \
    { \
        float passing = passes(bsdf.NAME, cosine); \
        if (is_wide(bsdf.NAME) && transmits(bsdf.NAME) == through) \
            f += evaluate(bsdf.NAME, below, left * bsdf.NAME.choice, outgoing, incoming, h, pdf_solid_angle); \
        below *= passing; \
        left *= 1.0 - bsdf.NAME.choice; \
    }
    BSDF_LOBES(LOBE_EVALUATE)
    return f;
}

// A delta lobe of a surface, by its index in 0 … MAX_DELTA_LOBES − 1: its direction and its reflectance; false if there are fewer.
bool delta_lobe(Bsdf bsdf, uint index, vec3 outgoing, out vec3 direction, out vec3 reflectance) {
    direction = reflectance = vec3(0.0);
    bool found = false;
    uint before = 0u;
    float below = 1.0;
#define LOBE_REFLECT(TYPE, NAME, DELTA) \
    if (reflects(bsdf.NAME) && IS_DELTA(NAME, DELTA)) { \
        if (before == index) { \
            reflectance = reflect_delta(bsdf.NAME, below, outgoing, direction); \
            found = true; \
        } \
        before += 1u; \
    } \
    below *= passes(bsdf.NAME, outgoing.z);
    BSDF_LOBES(LOBE_REFLECT)
    return found;
}

// Samples a direction: a lobe by its probability, and the direction by the lobe.
BsdfSample sample_bsdf(Bsdf bsdf, vec3 outgoing, vec4 u) {
    BsdfSample result = BsdfSample(vec3(0.0), vec3(0.0), 0.0, false, false);
    if (outgoing.z <= 0.0) return result;
    bool selected = false, selected_transmits = false;
    float above = 0.0, below = 1.0;
    uint index = 0u;
    // The bottom is left for every number that no other lobe takes, however their probabilities are rounded.
#define LOBE_SAMPLE(TYPE, NAME, DELTA) \
    { \
        index += 1u; \
        float probability = (1.0 - above) * bsdf.NAME.choice, passing = passes(bsdf.NAME, outgoing.z); \
        if (!selected && bsdf.NAME.choice > 0.0 && (u.x < above + probability || index == LOBE_COUNT)) { \
            selected = true; \
            if (IS_DELTA(NAME, DELTA)) { \
                result.weight = reflect_delta(bsdf.NAME, below, outgoing, result.direction) / probability; \
                result.delta = result.valid = true; \
                return result; \
            } \
            result.direction = draw(bsdf.NAME, outgoing, u.yz); \
            selected_transmits = transmits(bsdf.NAME); \
        } \
        above += probability; \
        below *= passing; \
    }
    BSDF_LOBES(LOBE_SAMPLE)
    if (!selected) return result;
    // A lobe may miss its side of the surface, where another lobe has a density.
    if (HAS_TRANSMISSION && (result.direction.z < 0.0) != selected_transmits) return result;
    vec3 f = evaluate_bsdf(bsdf, outgoing, result.direction, result.pdf_solid_angle);
    result.valid = result.pdf_solid_angle > 0.0;
    float spread = HAS_TRANSMISSION ? abs(result.direction.z) : result.direction.z;
    if (result.valid) result.weight = f * (spread / result.pdf_solid_angle);
    return result;
}

// The fraction of light that the lobes reflect together, for an outgoing direction with this cosine.
vec3 albedo_of(Bsdf bsdf, float cosine) {
    vec3 sum = vec3(0.0);
    float below = 1.0;
#define LOBE_ALBEDO(TYPE, NAME, DELTA) \
    sum += albedo(bsdf.NAME, below, cosine); \
    below *= passes(bsdf.NAME, cosine);
    BSDF_LOBES(LOBE_ALBEDO)
    return sum;
}

// The same for the lobes of reflection that are no peak.
vec3 matte_albedo_of(Bsdf bsdf, float cosine) {
    vec3 sum = vec3(0.0);
    float below = 1.0;
#define LOBE_MATTE(TYPE, NAME, DELTA) \
    if (is_matte(bsdf.NAME)) sum += albedo(bsdf.NAME, below, cosine); \
    below *= passes(bsdf.NAME, cosine);
    BSDF_LOBES(LOBE_MATTE)
    return sum;
}

// True if a lobe that is no delta lobe lets light through the surface.
bool lets_light_through(Bsdf bsdf) { return HAS_TRANSMISSION && is_wide(bsdf.transmission); }

BsdfSummary summary_of(Bsdf bsdf, float cosine) {
    BsdfSummary summary = BsdfSummary(0.0, 0.0, 0.0, 1.0, false);
    float below = 1.0;
#define LOBE_SUMMARISE(TYPE, NAME, DELTA) \
    summarise(bsdf.NAME, below, cosine, summary); \
    below *= passes(bsdf.NAME, cosine);
    BSDF_LOBES(LOBE_SUMMARISE)
    return summary;
}

// 1 for lobes so narrow that light samples almost never fall into them, 0 for wide ones and delta lobes.
float narrowness_of(float choice, float alpha) { return choice > 0.0 && alpha > 0.0 ? max(1.0 - 4.0 * alpha, 0.0) : 0.0; }

// That of the narrowest lobe.
float narrowness_of(Bsdf bsdf) {
    float most = 0.0;
#define LOBE_NARROWNESS(TYPE, NAME, DELTA) most = max(most, narrowness_of(bsdf.NAME.choice, alpha_of(bsdf.NAME)));
    BSDF_LOBES(LOBE_NARROWNESS)
    return most;
}

// The probability that sampling selects a lobe whose GGX width is below `alpha`, delta lobes aside.
float narrow_probability(Bsdf bsdf, float alpha) {
    float sum = 0.0, left = 1.0;
#define LOBE_NARROW(TYPE, NAME, DELTA) \
    if (alpha_of(bsdf.NAME) > 0.0 && alpha_of(bsdf.NAME) < alpha) sum += left * bsdf.NAME.choice; \
    left *= 1.0 - bsdf.NAME.choice;
    BSDF_LOBES(LOBE_NARROW)
    return sum;
}

// Adapts the probabilities of lobes to a surface that also has light samples, which cover wide lobes: a narrow lobe gets most
// rays. A delta lobe gets none; `delta_lobe` has its ray. Only the selection of lobes changes, and with it all their densities.
void prefer_narrow_lobes(inout Bsdf bsdf) {
#define LOBE_PREFER(TYPE, NAME, DELTA) \
    if (IS_DELTA(NAME, DELTA)) { \
        bsdf.NAME.choice = 0.0; \
    } else if (bsdf.NAME.choice < 1.0) { \
        float own = bsdf.NAME.choice; \
        bsdf.NAME.choice = mix(own, max(own, 0.75), narrowness_of(own, alpha_of(bsdf.NAME))); \
    }
    BSDF_LOBES(LOBE_PREFER)
}
