// One merge for every kind of reuse and of sample: a canonical reservoir with neighbours, each with
// its own domain. Who includes this has declared
//   Sample, Reservoir { Sample value; float contribution_weight; float confidence; … }, Domain
//   Domain domain_of(uint technique)
//   float target_function(Domain domain, Sample value)
//   bool is_visible(uint technique, Domain domain, Sample value), as the technique knows it
// and, where techniques know one sample by different values, defines CARRIES_SAMPLES and
//   Sample carried(uint technique, Sample value, out float jacobian), the canonical's as the technique
//     knows it, and how much larger the same piece of the space is to the technique

Reservoir techniques[MOST_TECHNIQUES];

// What each technique's sample weighs in the merge, m_i · p̂_0(y_i) · W_i, and p̂_0(y_i).
float technique_weights[MOST_TECHNIQUES];
float technique_targets[MOST_TECHNIQUES];

// Weighs `count` techniques, the canonical being number 0. With `visibility`, targets include it.
void weigh_techniques(uint mis, uint count, bool visibility) {
    float canonical_confidence = techniques[0].confidence;
    float neighbour_confidence = 0.0;
    for (uint i = 1u; i < count; i += 1u) neighbour_confidence += techniques[i].confidence;

    Balance balances[MOST_TECHNIQUES];
    for (uint i = 0u; i < count; i += 1u) balances[i] = empty_balance();
    for (uint k = 0u; k < count; k += 1u) {
        Domain domain = domain_of(k);
        for (uint i = 0u; i < count; i += 1u) {
            // An empty technique has no sample to look at; its domain still judges the others'.
            if (techniques[i].contribution_weight <= 0.0 || !pair_counts(mis, i, k)) continue;
#ifdef COUNTS
            count_lanes(COUNTER_MERGE_LANES);
#endif
            Sample value = techniques[i].value;
#ifdef CARRIES_SAMPLES
            float jacobian;
            value = carried(k, value, jacobian);
            float target = target_function(domain, value) * jacobian;
#else
            float target = target_function(domain, value);
#endif
            // Where a sample lives it is visible, or its weight were 0.
            if (visibility && i != k && target > 0.0 && !is_visible(k, domain, value)) target = 0.0;
            balance_add(balances[i], i, k, target, techniques[k].confidence, canonical_confidence,
                        neighbour_confidence);
        }
    }
    for (uint i = 0u; i < count; i += 1u) {
        float m = mis_weight(mis, i, balances[i], techniques[i].confidence, canonical_confidence,
                             neighbour_confidence);
        technique_targets[i] = balances[i].canonical;
        technique_weights[i] = m * balances[i].canonical * techniques[i].contribution_weight;
    }
}

// Merges `count` techniques into one reservoir.
Reservoir merge_techniques(uint mis, uint count, bool visibility, inout Random random) {
    weigh_techniques(mis, count, visibility);
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
