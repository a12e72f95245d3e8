#pragma once
// One merge for every kind of reuse and of sample: a canonical reservoir with neighbours, each with its own shading point.
// The file that includes it defines
//   MergeSample, MergeReservoir { MergeSample value; float contribution_weight; float confidence; … }, ShadingPoint
//   MERGE_EMPTY: an empty MergeReservoir
//   float confidence_of(uint technique)
//   MergeReservoir technique_at(uint technique): technique 0 is the canonical
//   ShadingPoint shading_point_of(uint technique)
//   float transmittance(uint technique, ShadingPoint shading point, MergeSample value), with the sample as the technique sees it: the
//     fraction of its light that arrives. Targets include whether it is above 0, light includes the fraction itself: then a
//     technique's own sample needs no ray for its weight, only where its light is added
//   bool shift(uint from, uint to, ShadingPoint there, inout MergeSample value, out Shifted shifted): moves a sample from the space
//     of one technique to that of another. One of them is the canonical, or both are the same. `there` is the shading point of
//     `to`. Returns false where the shift does not exist. Its existence must be symmetric, and every rejection that looks at a
//     sample must be here, so that all weights use the same domain of the shift
//
// A technique's reservoir is in the technique's own space: its sample, and its weight in the measure of that space. The merge shifts
// both to the canonical, and stores the shifted sample.
//
// Techniques are read one after the other, and only the canonical, one neighbour and the selected samples are held:
// arrays of samples with dynamic indices would live in memory.
//
// Visibility with two rays. The balance heuristic needs the visibility of every sample in every shading point. The pairwise
// weights need it in two sums only, and one random term of each sum can stand for the whole:
//
// 1. The canonical's sample y_0. Let s_j = c_0 p̂_0 / (C p̂←j + c_0 p̂_0) be its fraction in the pair with neighbour j if j
//    sees it. If j does not, p̂←j = 0 and the fraction is 1. With V_j = 1 if j sees y_0, else 0:
//        m_0 = Σ_j (c_j/C) [s_j + (1 − V_j)(1 − s_j)].
//    Let h_j = (c_j/C)(1 − s_j) and H = Σ_j h_j. Select one j with probability h_j / H, trace its ray, and add H to
//    Σ_j (c_j/C) s_j if it does not see y_0. The expectation of the added term is Σ_j (1 − V_j) h_j, which is exact.
//    Since Σ_j (c_j/C) s_j + H = Σ_j c_j/C = 1, the sum becomes exactly 1, whichever j was selected.
// 2. The neighbours' samples y_i at the canonical. Each resampling weight is w_i = V_0(y_i) · w̃_i, with w̃_i the weight
//    without visibility. Select one i with probability w̃_i / Σw̃, trace its ray, and give it the weight V_0(y_i) · Σw̃,
//    all others 0. Each expected weight is w̃_i V_0(y_i), as it should be.
//
// A sample is visible in its own shading point, or its weight would be 0, so no ray is needed there.
#include "core/random.glsl"
#include "restir/algebra.glsl"
#include "restir/shift.glsl"

// The outcome of a merge.
struct Merged {
    MergeReservoir reservoir;
    // The light of all samples that got a weight: with two rays, those of the canonical and of one neighbour. The selected sample
    // alone would have the same expected brightness, but more colour noise.
    vec3 light;
};

// p̂←k(y) of a sample y of technique i, in the measure of the canonical, and its light at technique k. The sample is in the canonical's
// space, except for k = 0, where a neighbour's comes from its own space. `shading_point` is that of k.
float target_at(uint k, ShadingPoint shading_point, uint i, inout MergeSample value, bool visibility, out Shifted shifted) {
    count_lanes(COUNTER_MERGE_LANES);
    if (!shift(k == 0u ? i : 0u, k, shading_point, value, shifted)) {
        shifted = Shifted(vec3(0.0), 0.0);
        return 0.0;
    }
    float target = luminance(shifted.contribution) * (k == 0u ? 1.0 : shifted.jacobian);
    if (visibility && i != k && target > 0.0) {
        float passed = transmittance(k, shading_point, value);
        shifted.contribution *= passed;
        if (passed == 0.0) target = 0.0;
    }
    return target;
}

// Resamples technique i's sample with the weight m_i · p̂_0(y_i) · W_i. `target` is p̂_0(y_i), `light` its light.
void resample(inout Merged merged, inout Stream selected, uint i, MergeReservoir reservoir, float weight, float target,
              vec3 light, inout Random random) {
    // One infinite weight would make the light of all techniques infinite.
    weight = accept_weight(weight);
    if (weight == 0.0) return;
    merged.light += light * (weight / target);
    if (stream_add(selected, i, weight, target, random_choice(random))) merged.reservoir = reservoir;
}

// Merges `count` techniques. With `visibility`, targets include visibility. With `shades`, the light is used.
Merged merge(uint mis, uint count, bool visibility, bool shades, inout Random random) {
    // Whether two rays stand for all.
    bool two_rays = visibility && mis != MIS_BALANCE, all_rays = visibility && !two_rays;
    float neighbour_confidence = 0.0;
    for (uint i = 1u; i < count; i += 1u) neighbour_confidence += confidence_of(i);
    MergeReservoir canonical = technique_at(0u);
    float confidence = canonical.confidence + neighbour_confidence;
    float total = max(confidence, 1.0);
    float canonical_fraction = canonical.confidence / total, neighbour_fraction = neighbour_confidence / total;

    // An empty technique has no sample; its shading point is still evaluated for the others' samples.
    bool has_canonical = canonical.contribution_weight > 0.0;
    MisTerms canonical_terms = empty_mis_terms();
    vec3 canonical_light = vec3(0.0);
    ShadingPoint here;

    Merged merged = Merged(MERGE_EMPTY, vec3(0.0));
    Stream selected = empty_stream();
    // The neighbour that decides on the canonical's sample (j in 1), and the neighbour's sample that is traced from the
    // canonical (i in 2).
    Stream asked = empty_stream(), drawn = empty_stream();
    MergeReservoir drawn_reservoir = merged.reservoir;
    vec3 drawn_light = vec3(0.0);
    uint i = 0u;
    for (; i < count; i += 1u) {
        float fraction = confidence_of(i) / total;
        ShadingPoint there = shading_point_of(i);
        if (i == 0u) here = there;
        if (has_canonical && needs_target(mis, 0u, i)) {
            Shifted shifted;
            MergeSample value = canonical.value;
            float target = target_at(i, there, 0u, value, all_rays, shifted);
            if (i == 0u) canonical_light = shifted.contribution;
            float change = add_target(canonical_terms, 0u, i, target, fraction, canonical_fraction, neighbour_fraction);
            if (two_rays && change > 0.0) stream_add(asked, i, change, 1.0, random_choice(random));
        }
        if (i == 0u) continue;
        MergeReservoir neighbour = technique_at(i);
        if (!(neighbour.contribution_weight > 0.0)) continue;
        MisTerms terms = empty_mis_terms();
        vec3 neighbour_light = vec3(0.0);
        // Drivers compile the target function, with all that it traces, as often as it stands in the code.
        for (uint k = 0u; k < count; k += 1u) {
            if (!needs_target(mis, i, k)) continue;
            ShadingPoint shading_point = there;
            float technique_fraction = fraction;
            if (k == 0u) {
                shading_point = here;
                technique_fraction = canonical_fraction;
            } else if (k != i) {
                shading_point = shading_point_of(k);
                technique_fraction = confidence_of(k) / total;
            }
            Shifted shifted;
            MergeSample value = neighbour.value;
            float target = target_at(k, shading_point, i, value, all_rays, shifted);
            if (k == 0u) {
                // From here on it is the canonical's.
                neighbour.value = value;
                neighbour.contribution_weight *= shifted.jacobian;
                neighbour_light = shifted.contribution;
            }
            add_target(terms, i, k, target, technique_fraction, canonical_fraction, neighbour_fraction);
        }
        float weight = mis_weight(mis, i, terms, fraction, canonical_fraction, neighbour_fraction) * terms.canonical
            * neighbour.contribution_weight;
        if (!two_rays) {
            resample(merged, selected, i, neighbour, weight, terms.canonical, neighbour_light, random);
        } else if (stream_add(drawn, i, weight, terms.canonical, random_choice(random))) {
            drawn_reservoir = neighbour;
            drawn_light = neighbour_light;
        }
    }
    // A driver that limits loop iterations ends all loops of an invocation at once, this one too.
    if (i < count) count_fault(COUNTER_CUT_SHORT);

    bool drawn_seen = false;
    // Both rays in one loop: drivers compile the trace as often as it stands in the code.
    for (uint turn = 0u; two_rays && turn < 2u; turn += 1u) {
        bool asks = turn == 0u;
        if ((asks ? asked.chosen : drawn.chosen) == NONE) continue;
        uint viewer = 0u;
        ShadingPoint shading_point = here;
        MergeSample value = drawn_reservoir.value;
        if (asks) {
            Shifted shifted;
            viewer = asked.chosen;
            shading_point = shading_point_of(viewer);
            value = canonical.value;
            shift(0u, viewer, shading_point, value, shifted);
        }
        float passed = transmittance(viewer, shading_point, value);
        if (asks && passed == 0.0) canonical_terms.pairs = 1.0;
        if (!asks) {
            drawn_seen = passed > 0.0;
            drawn_light *= passed;
        }
    }
    if (has_canonical) {
        if (HAS_BLEND && visibility && shades) canonical_light *= transmittance(0u, here, canonical.value);
        float weight = mis_weight(mis, 0u, canonical_terms, canonical_fraction, canonical_fraction, neighbour_fraction)
            * canonical_terms.canonical * canonical.contribution_weight;
        resample(merged, selected, 0u, canonical, weight, canonical_terms.canonical, canonical_light, random);
    }
    if (drawn_seen) {
        resample(merged, selected, drawn.chosen, drawn_reservoir, drawn.weight_sum, drawn.target, drawn_light, random);
    }
    if (selected.chosen != NONE) merged.reservoir.contribution_weight = accept_weight(contribution_weight(selected));
    merged.reservoir.confidence = confidence;
    return merged;
}
