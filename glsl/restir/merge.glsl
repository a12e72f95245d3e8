#pragma once
// One merge for every kind of reuse and of sample: a canonical reservoir with neighbours, each with its own domain.
// The file that includes it defines
//   Sample, Reservoir { Sample value; float contribution_weight; float confidence; … }, Domain
//   MAX_TECHNIQUES
//   Domain domain_of(uint technique)
//   float target_function(Domain domain, Sample value)
//   bool is_visible(uint technique, Domain domain, Sample value), with the sample as the technique sees it
//   Sample shift_to(uint technique, Sample value, out float jacobian): the canonical's sample in the technique's
//     space. The Jacobian is the ratio of the sample's measure there to its measure here; 0 where the shift does not
//     exist. Its existence must be symmetric, and every rejection that looks at a sample must be here, so that all
//     weights use the same domain of the shift.
//
// Visibility with two rays. The balance heuristic needs the visibility of every sample in every domain. The pairwise
// weights need it in two sums only, and one random term of each sum can stand for the whole:
//
// 1. The canonical's sample y_0. Let s_j = c_0 p̂_0 / (C p̂←j + c_0 p̂_0) be its share in the pair with neighbour j if j
//    sees it. If j does not, p̂←j = 0 and the share is 1. With V_j = 1 if j sees y_0, else 0:
//        m_0 = Σ_j (c_j/C) [s_j + (1 − V_j)(1 − s_j)].
//    Let h_j = (c_j/C)(1 − s_j) and H = Σ_j h_j. Select one j with probability h_j / H, trace its ray, and add H to
//    Σ_j (c_j/C) s_j if it does not see y_0. The expectation of the added term is Σ_j (1 − V_j) h_j, which is exact.
//    Since Σ_j (c_j/C) s_j + H = Σ_j c_j/C = 1, the sum becomes exactly 1, whichever j was selected.
// 2. The neighbours' samples y_i at the canonical. Each resampling weight is w_i = V_0(y_i) · w̃_i, with w̃_i the weight
//    without visibility. Select one i with probability w̃_i / Σw̃, trace its ray, and give it the weight V_0(y_i) · Σw̃,
//    all others 0. Each expected weight is w̃_i V_0(y_i), as it should be.
//
// A sample is visible in its own domain, or its weight would be 0, so no ray is needed there.
#include "core/random.glsl"
#include "restir/algebra.glsl"

Reservoir techniques[MAX_TECHNIQUES];

// The resampling weight m_i · p̂_0(y_i) · W_i of each technique's sample, and p̂_0(y_i).
float technique_weights[MAX_TECHNIQUES];
float technique_targets[MAX_TECHNIQUES];

// Computes the resampling weights of `count` techniques. With `visibility`, targets include visibility.
void weigh_techniques(uint mis, uint count, bool visibility, inout Random random) {
    // Whether two rays stand for all.
    bool two_rays = visibility && mis != MIS_BALANCE;
    float neighbour_confidence = 0.0;
    for (uint i = 1u; i < count; i += 1u) neighbour_confidence += techniques[i].confidence;
    float total = max(techniques[0].confidence + neighbour_confidence, 1.0);
    float canonical_share = techniques[0].confidence / total, neighbour_share = neighbour_confidence / total;

    MisTerms terms[MAX_TECHNIQUES];
    // The neighbour that decides on the canonical's sample (j in 1).
    Stream asked = empty_stream();
    for (uint i = 0u; i < count; i += 1u) terms[i] = empty_mis_terms();
    for (uint k = 0u; k < count; k += 1u) {
        Domain domain = domain_of(k);
        for (uint i = 0u; i < count; i += 1u) {
            // An empty technique has no sample; its domain is still evaluated for the others' samples.
            if (techniques[i].contribution_weight <= 0.0 || !needs_target(mis, i, k)) continue;
            count_lanes(COUNTER_MERGE_LANES);
            float target = 0.0, jacobian;
            // At the canonical (k = 0) a sample keeps its value, but it counts only if the shift from there to its own
            // technique exists.
            Sample value = shift_to(k != 0u ? k : i, techniques[i].value, jacobian);
            if (jacobian > 0.0) {
                if (k == 0u) {
                    value = techniques[i].value;
                    jacobian = 1.0;
                }
                target = target_function(domain, value) * jacobian;
                bool unseen = visibility && !two_rays && i != k && target > 0.0 && !is_visible(k, domain, value);
                if (unseen) target = 0.0;
            }
            float change = add_target(terms[i], i, k, target, techniques[k].confidence / total, canonical_share,
                                      neighbour_share);
            if (two_rays && change > 0.0) stream_add(asked, k, change, 1.0, random_choice(random));
        }
    }
    // The neighbour's sample that is traced from the canonical (i in 2).
    Stream drawn = empty_stream();
    for (uint i = 0u; i < count; i += 1u) {
        float m = mis_weight(mis, i, terms[i], techniques[i].confidence / total, canonical_share, neighbour_share);
        technique_targets[i] = terms[i].canonical;
        technique_weights[i] = m * terms[i].canonical * techniques[i].contribution_weight;
        if (two_rays && i > 0u) {
            stream_add(drawn, i, technique_weights[i], 1.0, random_choice(random));
            technique_weights[i] = 0.0;
        }
    }
    if (!two_rays) return;
    // Both rays in one loop: drivers compile the trace as often as it stands in the code.
    for (uint turn = 0u; turn < 2u; turn += 1u) {
        bool asks = turn == 0u;
        uint owner = asks ? 0u : drawn.chosen, viewer = asks ? asked.chosen : 0u;
        if (owner == NONE || viewer == NONE) continue;
        float jacobian;
        bool seen = is_visible(viewer, domain_of(viewer), shift_to(viewer, techniques[owner].value, jacobian));
        if (asks && !seen) {
            terms[0].pairs = 1.0;
            float m = mis_weight(mis, 0u, terms[0], canonical_share, canonical_share, neighbour_share);
            technique_weights[0] = m * terms[0].canonical * techniques[0].contribution_weight;
        }
        if (!asks && seen) technique_weights[owner] = drawn.weight_sum;
    }
}

// Resamples one of `count` weighed techniques into a merged reservoir.
Reservoir choose_technique(uint count, inout Random random) {
    Stream stream = empty_stream();
    float confidence = 0.0;
    uint i = 0u;
    for (; i < count; i += 1u) {
        confidence += techniques[i].confidence;
        stream_add(stream, i, technique_weights[i], technique_targets[i], random_choice(random));
    }
    // A driver that limits loop iterations ends all loops of an invocation at once, this one too.
    if (i < count) count_fault(COUNTER_CUT_SHORT);
    Reservoir merged = empty_reservoir(0.0);
    if (stream.chosen != NONE) {
        merged = techniques[stream.chosen];
        merged.contribution_weight = accept_weight(contribution_weight(stream));
    }
    merged.confidence = confidence;
    return merged;
}
