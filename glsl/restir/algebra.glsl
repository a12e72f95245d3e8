#pragma once
// The resampling algebra on plain numbers: weighted streams, and the MIS weights of a merge.
//
// Technique i has drawn a sample y_i with the unbiased contribution weight W_i. c_i is its fraction of the confidence of all:
// Σ c_i = 1, so that no product with a target overflows. p̂←k(y) is the target function of technique k at y, carried to
// the space of the canonical technique, which is number 0. C = Σ_{j≠0} c_j. A merge resamples with the weights
// m_i(y_i) · p̂_0(y_i) · W_i, where m is one of
//   constant   c_i; biased where supports differ
//   balance    c_i p̂←i / Σ_k c_k p̂←k
//   pairwise   (c_i/C) · C p̂←i / (C p̂←i + c_0 p̂_0),
//              for the canonical Σ_j (c_j/C) · c_0 p̂_0 / (C p̂←j + c_0 p̂_0)
//   defensive  pairwise with C in front, and c_0 more for the canonical
// (Lin et al., "Generalized Resampled Importance Sampling", 2022; Bitterli, "Correlations and Reuse for Fast and
// Accurate Physically Based Light Transport", 2022.) Each sums to 1 over the techniques wherever some technique can
// draw the sample. An empty technique (W = 0) has no sample to weigh, but it stays in the weights of the others'
// samples, because it could have drawn them.
#include "core/values.glsl"

// A running choice among weighted candidates (weighted reservoir sampling).
struct Stream {
    float weight_sum;
    // The selected candidate; NONE while all weights were 0.
    uint chosen;
    // The target function at the selected candidate.
    float target;
};

Stream empty_stream() { return Stream(0.0, NONE, 0.0); }

// Adds a candidate; returns whether it is selected now. `random` is uniform in (0, 1].
bool stream_add(inout Stream stream, uint candidate, float weight, float target, float random) {
    // NaN or infinity would remain in the sum.
    weight = accept_weight(weight);
    if (weight == 0.0) return false;
    stream.weight_sum += weight;
    // The first candidate is selected even by a `random` that was rounded to 1.
    if (weight < stream.weight_sum && random * stream.weight_sum >= weight) return false;
    stream.chosen = candidate;
    stream.target = target;
    return true;
}

// The unbiased contribution weight of the selected candidate; 0 if there is none.
float contribution_weight(Stream stream) {
    return stream.chosen == NONE ? 0.0 : stream.weight_sum / stream.target;
}

// own / (own + other); also where both are 0 or their sum overflows.
float fraction_of(float own, float other) {
    if (own <= 0.0) return 0.0;
    return 1.0 / (1.0 + other / own);
}

// The sums that the MIS weight of one technique's sample is computed from, one target at a time.
struct MisTerms {
    // Σ_k c_k p̂←k(y).
    float all;
    // p̂←i(y), of the technique that drew the sample.
    float own;
    // p̂_0(y).
    float canonical;
    // Σ_j (c_j/C) · c_0 p̂_0 / (C p̂←j + c_0 p̂_0), for the canonical's sample.
    float pairs;
};

MisTerms empty_mis_terms() { return MisTerms(0.0, 0.0, 0.0, 0.0); }

// Whether the merge needs p̂←k(y_i).
bool needs_target(uint mis, uint i, uint k) {
    if (k == 0u) return true;
    if (mis == MIS_CONSTANT) return false;
    return mis == MIS_BALANCE || i == k || i == 0u;
}

// Adds p̂←k(y_i); called in the order of k. `fraction` is c_k, `canonical_fraction` c_0, `neighbour_fraction` C.
// Returns the amount by which the canonical's pair sum would grow if technique k did not see the sample.
float add_target(inout MisTerms terms, uint i, uint k, float target, float fraction, float canonical_fraction,
                 float neighbour_fraction) {
    terms.all += fraction * target;
    if (k == 0u) terms.canonical = target;
    if (k == i) terms.own = target;
    if (i != 0u || k == 0u || neighbour_fraction <= 0.0) return 0.0;
    float part = fraction / neighbour_fraction;
    float of_canonical = fraction_of(canonical_fraction * terms.canonical, neighbour_fraction * target);
    terms.pairs += part * of_canonical;
    // A technique with zero target cannot change the weight by not seeing the sample.
    return target > 0.0 ? part * (1.0 - of_canonical) : 0.0;
}

// m_i(y_i), after all targets that the merge needs were added.
float mis_weight(uint mis, uint i, MisTerms terms, float fraction, float canonical_fraction, float neighbour_fraction) {
    // Without neighbours that were ever filled, the canonical is the only technique.
    if (neighbour_fraction <= 0.0) return i == 0u ? 1.0 : 0.0;
    if (mis == MIS_CONSTANT) return fraction;
    if (mis == MIS_BALANCE) return terms.own > 0.0 ? fraction * terms.own / terms.all : 0.0;
    bool defensive = mis == MIS_DEFENSIVE;
    float front = defensive ? neighbour_fraction : 1.0;
    if (i == 0u) return front * terms.pairs + (defensive ? canonical_fraction : 0.0);
    float pair = fraction_of(neighbour_fraction * terms.own, canonical_fraction * terms.canonical);
    return front * fraction / neighbour_fraction * pair;
}
