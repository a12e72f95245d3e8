// The resampling algebra, on numbers alone: weighted streams, and the MIS weights of a merge.
//
// Technique i made a sample y_i; it has an unbiased contribution weight W_i and a confidence c_i.
// p̂←k(y) is what technique k's target function says of y, carried to the canonical technique's
// space. The canonical technique is number 0; C = Σ_{j≠0} c_j and T = C + c_0. A merge resamples
// with the weights m_i(y_i) · p̂_0(y_i) · W_i, where m is one of
//   constant   c_i / T; biased where supports differ
//   balance    c_i p̂←i / Σ_k c_k p̂←k
//   pairwise   (c_i/C) · C p̂←i / (C p̂←i + c_0 p̂_0),
//              for the canonical Σ_j (c_j/C) · c_0 p̂_0 / (C p̂←j + c_0 p̂_0)
//   defensive  pairwise with c_i/T in front, and c_0/T more for the canonical
// (Lin et al., "Generalized Resampled Importance Sampling", 2022; Bitterli, "Correlations and Reuse
// for Fast and Accurate Physically Based Light Transport", 2022.) Each sums to one over the techniques
// wherever some technique can make the sample. An empty technique (W = 0) has no sample of its own to
// weigh, but stays in all other samples' weights: it might have made them.

// A running choice among weighted candidates.
struct Stream {
    float weight_sum;
    // The candidate chosen so far; NONE while all weights were 0.
    uint chosen;
    // The target function at the chosen one.
    float target;
};

Stream empty_stream() { return Stream(0.0, NONE, 0.0); }

// Offers a candidate; returns whether it is chosen now. `random` is uniform in [0, 1).
bool stream_add(inout Stream stream, uint candidate, float weight, float target, float random) {
    // NaN and infinity would stay for ever.
    weight = accept_weight(weight);
    if (weight == 0.0) return false;
    stream.weight_sum += weight;
    // A weight of 0 is never chosen: random · sum < weight fails.
    if (random * stream.weight_sum >= weight) return false;
    stream.chosen = candidate;
    stream.target = target;
    return true;
}

// The unbiased contribution weight of the chosen candidate; 0 if there is none.
float contribution_weight(Stream stream) {
    return stream.chosen == NONE ? 0.0 : stream.weight_sum / stream.target;
}

// c / (c + other), safe where both are 0 or their sum overflows.
float share_of(float own, float other) {
    if (own <= 0.0) return 0.0;
    return 1.0 / (1.0 + other / own);
}

// What the MIS weight of one technique's sample is made of, gathered target by target.
struct Balance {
    // c_k p̂←k(y) summed over the techniques, and its term for the sample's own technique.
    float all;
    float own;
    // p̂_0(y).
    float canonical;
    // The pair terms of the canonical's own sample.
    float pairs;
};

Balance empty_balance() { return Balance(0.0, 0.0, 0.0, 0.0); }

// Whether p̂←k(y_i) enters the merge at all.
bool pair_counts(uint mis, uint i, uint k) {
    if (k == 0u) return true;
    if (mis == MIS_CONSTANT) return false;
    return mis == MIS_BALANCE || i == k || i == 0u;
}

// Takes up p̂←k(y_i), in the order of k. `confidence` is c_k, `canonical_confidence` c_0. Returns by how much
// the canonical's own weight would grow if technique k did not see the sample.
float balance_add(inout Balance balance, uint i, uint k, float target, float confidence,
                 float canonical_confidence, float neighbour_confidence) {
    float term = confidence * target;
    balance.all += term;
    if (k == 0u) balance.canonical = target;
    if (k == i) balance.own = term;
    if (i != 0u || k == 0u || neighbour_confidence <= 0.0) return 0.0;
    float part = confidence / neighbour_confidence;
    float share = share_of(canonical_confidence * balance.canonical, neighbour_confidence * target);
    balance.pairs += part * share;
    // Who cannot make the sample at all has nothing to hide.
    return target > 0.0 ? part * (1.0 - share) : 0.0;
}

// m_i(y_i), once every target that counts was added.
float mis_weight(uint mis, uint i, Balance balance, float confidence, float canonical_confidence,
                 float neighbour_confidence) {
    float total = canonical_confidence + neighbour_confidence;
    // Without neighbours, or with none that was ever filled, the canonical is all there is.
    if (neighbour_confidence <= 0.0) return i == 0u ? 1.0 : 0.0;
    if (mis == MIS_CONSTANT) return confidence / total;
    if (mis == MIS_BALANCE) return balance.own > 0.0 ? balance.own / balance.all : 0.0;
    bool defensive = mis == MIS_DEFENSIVE;
    float front = neighbour_confidence / (defensive ? total : neighbour_confidence);
    if (i == 0u) return front * balance.pairs + (defensive ? canonical_confidence / total : 0.0);
    // C p̂←i over C p̂←i + c_0 p̂_0; `own` is c_i p̂←i.
    float pair = share_of(neighbour_confidence * balance.own, confidence * canonical_confidence * balance.canonical);
    return front * confidence / neighbour_confidence * pair;
}
