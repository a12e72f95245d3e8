//! Tests of shader functions: the merge of a few samples. Every outcome of every technique is enumerated, so that the
//! expected value is known exactly.

use crate::{Function, floats, number};
use headwater::shader_interface::Mis;

/// The number of samples from which the techniques of a toy select.
const SAMPLES: usize = 4;
/// The maximum number of techniques of a toy, a small made-up merge.
const MOST: usize = 4;
/// The number of draws whose mean stands for the expectation, for weights that are random themselves.
const DRAWS: u32 = 1 << 16;
const UNBIASED: [Mis; 3] = [Mis::Balance, Mis::Pairwise, Mis::Defensive];

/// One possible outcome of a technique: a sample with its contribution weight, or no sample (`None`), and the probability of
/// it.
#[derive(Clone, Copy, Debug)]
struct Outcome {
    probability: f64,
    sample: Option<usize>,
    weight: f64,
}

/// A technique of a toy merge. For each sample it has the value of the target function in the canonical's space, whether the
/// sample is visible, and the Jacobian of the shift to the canonical (0 = the shift fails). It also has its confidence and
/// its outcomes.
#[derive(Clone, Debug)]
struct Technique {
    targets: [f64; SAMPLES],
    sees: [bool; SAMPLES],
    jacobians: [f64; SAMPLES],
    confidence: f64,
    outcomes: Vec<Outcome>,
}

impl Technique {
    /// A technique that draws the samples with these probabilities, and no sample with the remaining probability. It sees
    /// all samples, and its shifts have Jacobian 1.
    fn new(targets: [f64; SAMPLES], confidence: f64, probabilities: [f64; SAMPLES]) -> Self {
        let mut outcomes: Vec<Outcome> = probabilities
            .iter()
            .enumerate()
            .filter(|(_, p)| **p > 0.0)
            .map(|(sample, p)| Outcome {
                probability: *p,
                sample: Some(sample),
                weight: 1.0 / p,
            })
            .collect();
        let rest = 1.0 - probabilities.iter().sum::<f64>();
        if rest > 1e-12 {
            outcomes.push(Outcome {
                probability: rest,
                sample: None,
                weight: 0.0,
            });
        }
        Self {
            targets,
            sees: [true; SAMPLES],
            jacobians: [1.0; SAMPLES],
            confidence,
            outcomes,
        }
    }

    /// The technique with walls: samples where `sees` is false are hidden, but the target function does not know it.
    fn seeing(self, sees: [bool; SAMPLES]) -> Self {
        Self { sees, ..self }
    }

    /// The technique with other Jacobians of its shifts. Where one is 0, the shift fails, and no other technique can use
    /// that sample.
    fn shifting(self, jacobians: [f64; SAMPLES]) -> Self {
        Self { jacobians, ..self }
    }

    /// True if a sample contributes to the picture at the technique's own shading point: it is visible and has a target
    /// above 0.
    fn needs(&self, sample: usize) -> bool {
        self.sees[sample] && self.targets[sample] > 0.0
    }
}

/// All combinations of one outcome per technique, each with its probability.
fn combinations(techniques: &[Technique]) -> Vec<(f64, Vec<Outcome>)> {
    let start = vec![(1.0, Vec::new())];
    techniques.iter().fold(start, |all, technique| {
        all.iter()
            .flat_map(|(p, chosen)| {
                technique.outcomes.iter().map(move |outcome| {
                    let mut chosen = chosen.clone();
                    chosen.push(*outcome);
                    (p * outcome.probability, chosen)
                })
            })
            .collect()
    })
}

/// One combination of outcomes with the resampling weights that the merge in the shaders gives it; where weights are random,
/// their mean.
struct Weighed {
    probability: f64,
    outcomes: Vec<Outcome>,
    weights: Vec<f64>,
}

fn weigh(mis: Mis, techniques: &[Technique], fault: Option<(&str, &str, &str)>) -> Vec<Weighed> {
    let table = |values: Vec<f64>| {
        let texts: Vec<String> = values.iter().map(|v| format!("{v:?}")).collect();
        format!("float[]({})", texts.join(", "))
    };
    let targets = table(techniques.iter().flat_map(|t| t.targets).collect());
    let jacobians = table(techniques.iter().flat_map(|t| t.jacobians).collect());
    let confidences = table(techniques.iter().map(|t| t.confidence).collect());
    let sees = techniques.iter().flat_map(|t| t.sees);
    let walls = sees.clone().any(|sees| !sees);
    let sees = table(sees.map(|sees| f64::from(u8::from(sees))).collect());
    let draws = if walls { DRAWS } else { 1 };
    let count = techniques.len();
    let mis = mis as u32;
    let globals = format!(
        "#include \"restir/shift.glsl\"
        struct Sample {{ uint number; }};
        struct ShadingPoint {{ uint technique; }};
        struct Reservoir {{ Sample value; float contribution_weight; float confidence; }};
        Reservoir toys[{MOST}];
        // The weight with which each technique's sample was resampled.
        float weights[{MOST}];
        const float TARGETS[{all}] = {targets};
        const float JACOBIANS[{all}] = {jacobians};
        const float SEES[{all}] = {sees};
        const float CONFIDENCES[{count}] = {confidences};
        Reservoir empty_reservoir(float confidence) {{ return Reservoir(Sample(NONE), 0.0, confidence); }}
        float confidence_of(uint technique) {{ return CONFIDENCES[technique]; }}
        Reservoir technique_at(uint technique) {{ return toys[technique]; }}
        ShadingPoint shading_point_of(uint technique) {{ return ShadingPoint(technique); }}
        // Each technique numbers the samples in its own way, so that no shift is the identity, not even that to the canonical.
        uint entry(uint technique, Sample value) {{ return {SAMPLES}u * technique + (value.number + technique) % {SAMPLES}u; }}
        vec3 contribution(ShadingPoint shading_point, Sample value) {{
            uint index = entry(shading_point.technique, value);
            return vec3(TARGETS[index] / (JACOBIANS[index] > 0.0 ? JACOBIANS[index] : 1.0));
        }}
        float transmittance(uint technique, ShadingPoint shading_point, Sample value) {{
            return SEES[entry(technique, value)];
        }}
        bool shift(uint from, uint to, ShadingPoint there, inout Sample value, out Shifted shifted) {{
            uint other = from != 0u ? from : to;
            uint number = (value.number + from) % {SAMPLES}u;
            float jacobian = JACOBIANS[{SAMPLES}u * other + number];
            value.number = (number + {SAMPLES}u - to) % {SAMPLES}u;
            shifted = Shifted(contribution(there, value), from == to ? 1.0 : from == 0u ? jacobian : 1.0 / jacobian);
            return from == to || jacobian > 0.0;
        }}
        // A reservoir in the technique's own space, of a sample and a weight in the canonical's.
        Reservoir reservoir_of(uint technique, uint number, float weight) {{
            float jacobian = JACOBIANS[{SAMPLES}u * technique + number];
            Sample value = Sample((number + {SAMPLES}u - technique) % {SAMPLES}u);
            return Reservoir(value, jacobian > 0.0 ? weight * jacobian : weight, CONFIDENCES[technique]);
        }}
        #define MergeSample Sample
        #define MergeReservoir Reservoir
        #define MERGE_EMPTY empty_reservoir(0.0)
        #include \"restir/merge.glsl\"",
        all = count * SAMPLES,
    );
    let body = format!(
        "for (uint i = 0u; i < {count}u; i += 1u)
            toys[i] = reservoir_of(i, a[i], uintBitsToFloat(b[i]));
        Random random = random_start(1u, 2u, 3u);
        float sums[{count}];
        for (uint i = 0u; i < {count}u; i += 1u) sums[i] = 0.0;
        for (uint n = 0u; n < {draws}u; n += 1u) {{
            for (uint i = 0u; i < {count}u; i += 1u) weights[i] = 0.0;
            merge({mis}u, {count}u, {walls}, true, random);
            for (uint i = 0u; i < {count}u; i += 1u) sums[i] += weights[i];
        }}
        for (uint i = 0u; i < {count}u; i += 1u) x[i] = floatBitsToUint(sums[i] / float({draws}u));"
    );
    // What is selected by these weights depends on chance, and is tested elsewhere.
    let mut changes = vec![(
        "restir/merge.glsl",
        "if (weight == 0.0) return;",
        "weights[i] = weight; if (weight == 0.0) return;",
    )];
    changes.extend(fault);
    let function = Function {
        globals: &globals,
        body: &body,
        changes: &changes,
        ..Function::default()
    };
    let all = combinations(techniques);
    let inputs: Vec<[u32; 8]> = all
        .iter()
        .map(|(_, outcomes)| {
            let mut words = floats(&[0.0; 8]);
            for (i, outcome) in outcomes.iter().enumerate() {
                words[i] = outcome.sample.unwrap_or(0) as u32;
                words[4 + i] = (outcome.weight as f32).to_bits();
            }
            words
        })
        .collect();
    all.into_iter()
        .zip(function.run(&inputs))
        .map(|((probability, outcomes), words)| Weighed {
            probability,
            weights: words[..count].iter().map(|w| number(*w)).collect(),
            outcomes,
        })
        .collect()
}

/// The mean weight that the merge gives each sample: 1 where it is unbiased. For any selected sample, resampling by weight w
/// and division by the target give Σ w_i / p̂_0(y_i).
fn mean_weights(techniques: &[Technique], weighed: &[Weighed]) -> [f64; SAMPLES] {
    let mut mean = [0.0; SAMPLES];
    for w in weighed {
        for (outcome, weight) in w.outcomes.iter().zip(&w.weights) {
            let Some(sample) = outcome.sample.filter(|_| *weight > 0.0) else {
                continue;
            };
            mean[sample] += w.probability * weight / techniques[0].targets[sample];
        }
    }
    mean
}

/// The largest deviation of the mean weights from 1 on the canonical's support, and from 0 elsewhere.
fn bias(mis: Mis, techniques: &[Technique], fault: Option<(&str, &str, &str)>) -> f64 {
    let mean = mean_weights(techniques, &weigh(mis, techniques, fault));
    (0..SAMPLES)
        .map(|y| (mean[y] - f64::from(u8::from(techniques[0].needs(y)))).abs())
        .fold(0.0, f64::max)
}

/// Toy merges with their names. In each, the canonical can draw every sample that its own target needs.
fn toys() -> Vec<(&'static str, Vec<Technique>)> {
    let t = Technique::new;
    vec![
        (
            "alone",
            vec![t([1.0, 2.0, 0.0, 3.0], 1.0, [0.2, 0.3, 0.0, 0.5])],
        ),
        (
            "same shading point",
            vec![
                t([1.0, 2.0, 3.0, 4.0], 1.0, [0.25; 4]),
                t([1.0, 2.0, 3.0, 4.0], 5.0, [0.1, 0.2, 0.3, 0.4]),
                t([1.0, 2.0, 3.0, 4.0], 2.0, [0.4, 0.3, 0.2, 0.1]),
            ],
        ),
        (
            "partial supports, unequal confidences",
            vec![
                t([1.0, 2.0, 3.0, 0.0], 1.0, [0.5, 0.25, 0.25, 0.0]),
                t([0.0, 5.0, 1.0, 2.0], 20.0, [0.0, 0.3, 0.3, 0.4]),
                t([4.0, 0.0, 0.5, 1.0], 3.0, [0.6, 0.0, 0.3, 0.1]),
            ],
        ),
        (
            "disjoint supports",
            vec![
                t([1.0, 2.0, 0.0, 0.0], 1.0, [0.5, 0.5, 0.0, 0.0]),
                t([0.0, 0.0, 3.0, 1.0], 9.0, [0.0, 0.0, 0.5, 0.5]),
            ],
        ),
        (
            "often empty",
            vec![
                t([1.0, 2.0, 3.0, 4.0], 1.0, [0.2, 0.1, 0.1, 0.1]),
                t([1.0, 0.0, 3.0, 2.0], 4.0, [0.02, 0.0, 0.05, 0.03]),
                t([2.0, 2.0, 0.0, 1.0], 7.0, [0.2, 0.2, 0.0, 0.1]),
                t([0.0, 1.0, 1.0, 1.0], 1.0, [0.0, 0.1, 0.1, 0.1]),
            ],
        ),
        (
            "neighbours almost always and always empty",
            vec![
                t([1.0, 2.0, 3.0, 4.0], 1.0, [0.25; 4]),
                // What it can never make, its target must not claim.
                t([1.0, 2.0, 3.0, 4.0], 6.0, [1e-3; 4]),
                t([0.0; 4], 6.0, [0.0; 4]),
            ],
        ),
        (
            "shifts that stretch or fail",
            vec![
                t([1.0, 2.0, 3.0, 4.0], 1.0, [0.25; 4]),
                t([4.0, 3.0, 2.0, 1.0], 5.0, [0.1, 0.2, 0.3, 0.4]).shifting([2.0, 0.5, 0.0, 3.0]),
                t([1.0; 4], 2.0, [0.4, 0.3, 0.2, 0.1]).shifting([0.0, 1.0, 4.0, 0.0]),
            ],
        ),
        (
            "twenty decades between targets",
            vec![
                t([1e-10, 1.0, 1e10, 1.0], 1.0, [0.25; 4]),
                t([1e10, 1.0, 1e-10, 0.0], 30.0, [0.3, 0.3, 0.4, 0.0]),
            ],
        ),
        (
            "targets almost as large as numbers can be",
            vec![
                t([1e36, 1e34, 3e37, 1e35], 17.0, [0.25; 4]),
                t([1e35, 2e37, 0.0, 4e36], 500.0, [0.3, 0.3, 0.0, 0.4]),
                t([1e37, 1e33, 1e36, 1e36], 128.0, [0.1, 0.2, 0.3, 0.4]),
            ],
        ),
    ]
}

/// Toy merges with walls. Each technique sees the samples that it can draw.
fn walled() -> Vec<(&'static str, Vec<Technique>)> {
    let t = Technique::new;
    let all = [1.0, 2.0, 3.0, 4.0];
    vec![
        (
            "a neighbour before the wall",
            vec![
                t(all, 1.0, [0.3, 0.4, 0.0, 0.0]).seeing([true, true, false, false]),
                t([4.0, 3.0, 2.0, 1.0], 5.0, [0.0, 0.2, 0.3, 0.4])
                    .seeing([false, true, true, true]),
            ],
        ),
        (
            "three views",
            vec![
                t(all, 1.0, [0.2, 0.2, 0.2, 0.0]).seeing([true, true, true, false]),
                t(all, 4.0, [0.4, 0.0, 0.3, 0.2]).seeing([true, false, true, true]),
                t([2.0, 1.0, 1.0, 3.0], 2.0, [0.0, 0.5, 0.0, 0.5])
                    .seeing([false, true, false, true]),
                t([1.0, 1.0, 4.0, 0.0], 7.0, [0.3, 0.3, 0.3, 0.0]),
            ],
        ),
    ]
}

/// The shaders test one random neighbour's view of the pixel's sample, and the pixel's view of one neighbour's sample. The
/// weights are then random, and must be right on average.
#[test]
fn merges_behind_walls_are_unbiased() {
    for (name, techniques) in walled() {
        for mis in UNBIASED {
            let bias = bias(mis, &techniques, None);
            println!("{name}, mode {mis:?}: {bias:.4}");
            assert!(bias < 0.02, "{name}, mode {mis:?}: {bias}");
        }
    }
}

#[test]
fn faults_behind_walls_are_seen() {
    let (_, techniques) = walled().swap_remove(1);
    let faults = [
        (
            "neighbours never asked",
            (
                "restir/merge.glsl",
                "if (asks && passed == 0.0)",
                "if (false)",
            ),
        ),
        (
            "one that does not see it answers for itself alone",
            (
                "restir/merge.glsl",
                "canonical_terms.pairs = 1.0;",
                "canonical_terms.pairs += confidence_of(viewer) / neighbour_confidence * 0.25;",
            ),
        ),
        (
            "the canonical's own view left out",
            (
                "restir/merge.glsl",
                "drawn_seen = passed > 0.0;",
                "drawn_seen = true;",
            ),
        ),
    ];
    for (name, fault) in faults {
        let seen = bias(Mis::Pairwise, &techniques, Some(fault));
        println!("{name}: {seen:.3}");
        assert!(seen > 0.05, "{name}: {seen}");
    }
}

#[test]
fn merges_are_unbiased_on_every_toy() {
    for (name, techniques) in toys() {
        for mis in UNBIASED {
            let bias = bias(mis, &techniques, None);
            assert!(bias < 2e-6, "{name}, mode {mis:?}: {bias}");
        }
    }
}

/// With constant weights, a sample counts by the fraction of the confidence of the techniques that can draw it. That is
/// right only where all techniques can draw it.
#[test]
fn confidence_alone_is_biased_where_supports_differ() {
    let mut biased = 0;
    for (name, techniques) in toys() {
        let total: f64 = techniques.iter().map(|t| t.confidence).sum();
        let draws = |technique: &Technique, y: usize| {
            technique.outcomes.iter().any(|o| o.sample == Some(y)) && technique.jacobians[y] > 0.0
        };
        let mean = mean_weights(&techniques, &weigh(Mis::Constant, &techniques, None));
        for (y, mean) in mean.iter().enumerate() {
            let able = techniques.iter().filter(|t| draws(t, y));
            let fraction = able.map(|t| t.confidence).sum::<f64>() / total;
            let needed = techniques[0].needs(y);
            let expected = if needed { fraction } else { 0.0 };
            assert!(
                (mean - expected).abs() < 2e-6,
                "{name}, {y}: {mean} for {expected}"
            );
            biased += u32::from(needed && fraction < 0.9);
        }
    }
    assert!(biased > 5, "{biased} samples differ");
}

/// On identical shading points, balance and pairwise weights are fractions of confidence; the defensive weight of the
/// canonical is (c/T)(1 + C/T).
#[test]
fn on_identical_shading_points_the_weights_are_known() {
    let (_, techniques) = toys().swap_remove(1);
    let c: Vec<f64> = techniques.iter().map(|t| t.confidence).collect();
    let (neighbours, total) = (c[1] + c[2], c.iter().sum::<f64>());
    for mis in UNBIASED {
        for w in weigh(mis, &techniques, None) {
            for (i, (outcome, weight)) in w.outcomes.iter().zip(&w.weights).enumerate() {
                let target = techniques[0].targets[outcome.sample.unwrap()];
                let m = weight / (target * outcome.weight);
                let expected = match (mis, i) {
                    (Mis::Defensive, 0) => c[0] / total * (1.0 + neighbours / total),
                    (Mis::Defensive, _) => c[i] / total * (neighbours / total),
                    _ => c[i] / total,
                };
                assert!(
                    (m - expected).abs() < 1e-6,
                    "mode {mis:?}, technique {i}: {m}"
                );
            }
        }
    }
}

/// A merged reservoir is a technique for the next merge, which must be unbiased too.
#[test]
fn merges_of_merges_are_unbiased() {
    let (_, first) = toys().swap_remove(4);
    for mis in UNBIASED {
        // Whatever is chosen of a combination, by its fraction of the weights.
        let mut outcomes = Vec::new();
        for w in weigh(mis, &first, None) {
            let sum: f64 = w.weights.iter().sum();
            if sum == 0.0 {
                outcomes.push(Outcome {
                    probability: w.probability,
                    sample: None,
                    weight: 0.0,
                });
                continue;
            }
            for (outcome, weight) in w.outcomes.iter().zip(&w.weights) {
                if let Some(sample) = outcome.sample.filter(|_| *weight > 0.0) {
                    outcomes.push(Outcome {
                        probability: w.probability * weight / sum,
                        sample: Some(sample),
                        weight: sum / first[0].targets[sample],
                    });
                }
            }
        }
        let merged = Technique {
            targets: first[0].targets,
            sees: [true; SAMPLES],
            jacobians: [1.0; SAMPLES],
            confidence: first.iter().map(|t| t.confidence).sum(),
            outcomes,
        };
        let canonical = Technique::new([2.0, 1.0, 0.5, 0.0], 1.0, [0.3, 0.3, 0.3, 0.0]);
        let bias = bias(mis, &[canonical, merged], None);
        assert!(bias < 1e-5, "mode {mis:?}: {bias}");
    }
}

/// Each planted fault of the merge must make its bias visible to the checks above.
#[test]
fn planted_faults_are_seen() {
    let (_, techniques) = toys().swap_remove(4);
    let faults = [
        (
            "empty neighbours skipped",
            (
                "restir/merge.glsl",
                "ShadingPoint there = shading_point_of(i);",
                "if (i > 0u && !(technique_at(i).contribution_weight > 0.0)) continue; ShadingPoint there = shading_point_of(i);",
            ),
        ),
        (
            "a confidence that depends on the sample",
            (
                "restir/merge.glsl",
                "float fraction = confidence_of(i) / total;",
                "float fraction = confidence_of(i) / total * (technique_at(i).contribution_weight > 10.0 ? 2.0 : 1.0);",
            ),
        ),
        (
            "the canonical's pair term without its own target",
            (
                "restir/algebra.glsl",
                "fraction_of(canonical_fraction * terms.canonical, neighbour_fraction * target)",
                "0.5",
            ),
        ),
    ];
    for (name, fault) in faults {
        let seen = bias(Mis::Pairwise, &techniques, Some(fault));
        println!("{name}: {seen:.3}");
        assert!(seen > 0.005, "{name}: {seen}");
    }
}

#[test]
fn a_failed_shift_that_the_canonical_forgets_is_seen() {
    let (name, techniques) = toys().swap_remove(6);
    assert_eq!(name, "shifts that stretch or fail");
    let fault = (
        "restir/merge.glsl",
        "if (!shift(k == 0u ? i : 0u, k, shading_point, value, shifted)) {",
        "bool exists = shift(k == 0u ? i : 0u, k, shading_point, value, shifted);
        if (i == 0u) { exists = true; shifted.jacobian = 1.0; }
        if (!exists) {",
    );
    for mis in UNBIASED {
        let seen = bias(mis, &techniques, Some(fault));
        assert!(seen > 0.1, "mode {mis:?}: {seen}");
    }
}

/// The faults of a missing shift must be seen, which needs shifts that are not the identity at the canonical.
#[test]
fn neighbours_that_are_not_shifted_to_the_canonical_are_seen() {
    let (name, techniques) = toys().swap_remove(6);
    assert_eq!(name, "shifts that stretch or fail");
    for text in [
        "neighbour.contribution_weight *= shifted.jacobian;",
        "neighbour.value = value;",
    ] {
        let fault = ("restir/merge.glsl", text, "");
        for mis in UNBIASED {
            let seen = bias(mis, &techniques, Some(fault));
            assert!(seen > 0.1, "{text}, mode {mis:?}: {seen}");
        }
    }
}
