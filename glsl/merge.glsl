// One merge for every kind of reuse and of sample: a canonical reservoir with neighbours, each with
// its own domain. Who includes this has declared
//   Sample, Reservoir { Sample value; float contribution_weight; float confidence; … }, Domain
//   Domain domain_of(uint technique)
//   float target_function(Domain domain, Sample value)
//   bool is_visible(uint technique, Domain domain, Sample value), as the technique knows it
//   Sample known_to(uint technique, Sample value, out float jacobian), the canonical's sample as the technique
//     knows it. The Jacobian is how much larger the same piece of the space is to the technique. It is 0 where the
//     shift does not exist, which must hold both ways: what rejects samples has to stand here, where all weights
//     see it

Reservoir techniques[MOST_TECHNIQUES];

// What each technique's sample weighs in the merge, m_i · p̂_0(y_i) · W_i, and p̂_0(y_i).
float technique_weights[MOST_TECHNIQUES];
float technique_targets[MOST_TECHNIQUES];

// Weighs `count` techniques, the canonical being number 0. With `visibility`, targets include it.
//
// The balance heuristic must know for every sample who sees it. Weights by pairs need that only in two sums:
// of what neighbours say of the canonical's sample, and of the neighbours' samples that the canonical sees.
// A term of each, drawn by what it may change, stands for all of its sum: two rays, however many neighbours,
// and the weights keep their expectation.
void weigh_techniques(uint mis, uint count, bool visibility, inout Random random) {
    // Whether a ray for each sum stands for the rays of all its terms.
    bool draws = visibility && mis != MIS_BALANCE;
    float canonical_confidence = techniques[0].confidence;
    float neighbour_confidence = 0.0;
    for (uint i = 1u; i < count; i += 1u) neighbour_confidence += techniques[i].confidence;

    Balance balances[MOST_TECHNIQUES];
    // The neighbour that is asked whether it sees the canonical's sample.
    Stream asked = empty_stream();
    for (uint i = 0u; i < count; i += 1u) balances[i] = empty_balance();
    for (uint k = 0u; k < count; k += 1u) {
        Domain domain = domain_of(k);
        for (uint i = 0u; i < count; i += 1u) {
            // An empty technique has no sample to look at; its domain still judges the others'.
            if (techniques[i].contribution_weight <= 0.0 || !pair_counts(mis, i, k)) continue;
#ifdef COUNTS
            count_lanes(COUNTER_MERGE_LANES);
#endif
            float target = 0.0, jacobian;
            // The canonical takes samples as they stand, if their technique could have taken them from it.
            Sample value = known_to(k != 0u ? k : i, techniques[i].value, jacobian);
            if (jacobian > 0.0) {
                if (k == 0u) {
                    value = techniques[i].value;
                    jacobian = 1.0;
                }
                target = target_function(domain, value) * jacobian;
                // Where a sample lives it is visible, or its weight were 0.
                bool unseen = visibility && !draws && i != k && target > 0.0 && !is_visible(k, domain, value);
                if (unseen) target = 0.0;
            }
            float hides = balance_add(balances[i], i, k, target, techniques[k].confidence, canonical_confidence,
                                      neighbour_confidence);
            if (draws && hides > 0.0) stream_add(asked, k, hides, 1.0, to_unit(random_bits(random).x));
        }
    }
    // The neighbours' sample that is looked for from the canonical's domain.
    Stream drawn = empty_stream();
    for (uint i = 0u; i < count; i += 1u) {
        float m = mis_weight(mis, i, balances[i], techniques[i].confidence, canonical_confidence,
                             neighbour_confidence);
        technique_targets[i] = balances[i].canonical;
        technique_weights[i] = m * balances[i].canonical * techniques[i].contribution_weight;
        if (draws && i > 0u) {
            stream_add(drawn, i, technique_weights[i], 1.0, to_unit(random_bits(random).x));
            technique_weights[i] = 0.0;
        }
    }
    if (!draws) return;
    // One trace in a loop: drivers compile it as often as it stands in the code.
    for (uint turn = 0u; turn < 2u; turn += 1u) {
        bool asks = turn == 0u;
        uint owner = asks ? 0u : drawn.chosen, looks = asks ? asked.chosen : 0u;
        if (owner == NONE || looks == NONE) continue;
        float jacobian;
        bool seen = is_visible(looks, domain_of(looks), known_to(looks, techniques[owner].value, jacobian));
        if (asks && !seen) {
            balances[0].pairs = 1.0;
            technique_weights[0] = mis_weight(mis, 0u, balances[0], canonical_confidence, canonical_confidence,
                                              neighbour_confidence)
                * balances[0].canonical * techniques[0].contribution_weight;
        }
        if (!asks && seen) technique_weights[owner] = drawn.weight_sum;
    }
}

// Merges `count` techniques that were weighed into one reservoir.
Reservoir choose_technique(uint count, inout Random random) {
    Stream stream = empty_stream();
    float confidence = 0.0;
    uint i = 0u;
    for (; i < count; i += 1u) {
        confidence += techniques[i].confidence;
        stream_add(stream, i, technique_weights[i], technique_targets[i], to_unit(random_bits(random).x));
    }
    // A driver that counts an invocation's turns ends all of its loops at once, this one too.
    if (i < count) count_fault(COUNTER_CUT_SHORT);
    Reservoir merged = empty_reservoir(0.0);
    if (stream.chosen != NONE) {
        merged = techniques[stream.chosen];
        merged.contribution_weight = accept_weight(contribution_weight(stream));
    }
    merged.confidence = confidence;
    return merged;
}
