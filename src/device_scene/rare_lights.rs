//! Rare lights: lights of emitters that are so dim, compared with others, that resampling would lose their light.
//!
//! Resampling compares candidates before their shadow rays. An emitter that is a million times brighter wins every
//! reservoir, even where it is hidden, and the light of a dim emitter is lost. Therefore dim emitters are kept out of
//! reservoirs, and get separate candidates and shadow rays (`glsl/lights/samplers/sources.glsl`).

use std::collections::HashMap;
use std::hash::Hash;

/// The upper limit of the summed power of all rare emitters, as a fraction of the power of all emitters.
/// Emitters become rare in ascending order of their power, until the next one would reach this limit or that
/// of [`PART`]. Draws by power seldom select an emitter so dim, and if one is drawn, a brighter emitter
/// nearly always replaces it in the reservoir. Rare emitters therefore get separate candidates.
const FRACTION: f64 = 1.0 / 96.0;

/// The upper limit of the power of one rare emitter, as a fraction of the mean power of all emitters that
/// have power. With this limit, no emitter is rare in a scene whose emitters have similar powers.
const PART: f64 = 1.0 / 8.0;

/// The minimum ratio of the smaller to the larger of two powers at which they count as equal. It is below 1, because
/// rounding makes the powers of equal emitters differ slightly. Of emitters with equal power, either all are rare or none
/// is.
const SAME: f64 = 1.0 - 1e-6;

/// The classification of a scene's lights into rare lights (far dimmer than the others) and ordinary ones. Two tables of
/// weights follow from it: one for the candidates that compete in reservoirs, and one for the separate candidates of rare
/// lights.
pub struct RareLights {
    /// For each light, the index of its emitter. An emitter is all triangles of one material in one instance, or a single
    /// light of another kind. The lights of an emitter are either all rare or all ordinary, so that small triangles of a
    /// bright emitter are not rare.
    emitters: Vec<usize>,
    /// One entry per light: true if it is rare. The entries do not change with time, even if powers do. If they changed, a
    /// reservoir of an earlier frame could hold a light that has separate candidates now.
    pub is_rare: Vec<bool>,
}

impl RareLights {
    /// Finds the rare lights of a scene; `None` if no light is rare. `powers` has the largest power that each light has at
    /// any time, in any unit. `names` has one name per light; lights with equal names form one emitter.
    pub fn find<Name: Hash + Eq>(
        powers: &[f64],
        names: impl Iterator<Item = Name>,
    ) -> Option<Self> {
        let mut indices = HashMap::new();
        let emitters: Vec<usize> = names
            .map(|name| {
                let next = indices.len();
                *indices.entry(name).or_insert(next)
            })
            .collect();
        let of_emitters = sums(powers, &emitters, indices.len());
        let mut lit: Vec<f64> = of_emitters.iter().copied().filter(|p| *p > 0.0).collect();
        lit.sort_by(f64::total_cmp);
        let total: f64 = lit.iter().sum();
        let dim = PART * total / lit.len() as f64;
        // The least power of an emitter that is not rare. Emitters of the same power are rare together, or none of them is.
        let mut sum = 0.0;
        let common = SAME
            * lit.into_iter().find(|power| {
                sum += power;
                sum >= FRACTION * total || *power >= dim
            })?;
        let is_rare = emitters
            .iter()
            .map(|emitter| of_emitters[*emitter] > 0.0 && of_emitters[*emitter] < common);
        let is_rare: Vec<bool> = is_rare.collect();
        is_rare
            .contains(&true)
            .then_some(Self { emitters, is_rare })
    }

    /// The weights, one per light, with which ordinary candidates (those that compete in reservoirs) are
    /// drawn. The weight of an ordinary light is its current power from `powers`, and that of a rare light is
    /// 0. If no ordinary light has power now, every ordinary light has the weight 1, because the alias table
    /// must select some light.
    pub fn common_weights(&self, powers: &[f64]) -> Vec<f64> {
        self.weights_among(powers, false)
    }

    /// The weights, one per light, with which the separate candidates of rare lights are drawn; 0 for a light
    /// that is not rare. The weights of the lights of one rare emitter are in proportion to their current
    /// `powers` and add up to 1. So all rare emitters that have power now are equally likely. A rare emitter
    /// without power now has the weight 0. If no rare emitter has power now, the lights of each rare emitter
    /// have equal weights, which add up to 1.
    pub fn rare_weights(&self, powers: &[f64]) -> Vec<f64> {
        let weights = self.weights_among(powers, true);
        let of_emitters = sums(&weights, &self.emitters, self.emitters.len());
        let fractions = weights.iter().zip(&self.emitters);
        let fractions = fractions.map(|(weight, emitter)| {
            let emitter = of_emitters[*emitter];
            if emitter > 0.0 { weight / emitter } else { 0.0 }
        });
        fractions.collect()
    }

    /// One weight per light, for draws among the rare lights only (`rare` is true) or among the ordinary lights only (`rare`
    /// is false). The weight of a light of the chosen kind is its entry in `powers`, and that of any other light is 0. If no
    /// light of the chosen kind has power, each of them has the weight 1 instead, so that some light can be drawn.
    fn weights_among(&self, powers: &[f64], rare: bool) -> Vec<f64> {
        let lights = || self.is_rare.iter().zip(powers);
        let is_lit = lights().any(|(is_rare, power)| *is_rare == rare && *power > 0.0);
        let weight = |(is_rare, power): (&bool, &f64)| match (*is_rare == rare, is_lit) {
            (false, _) => 0.0,
            (true, true) => *power,
            (true, false) => 1.0,
        };
        lights().map(weight).collect()
    }
}

/// For each of `count` emitters, the sum of the `values` (such as powers) of its lights. `values` and `emitters` have one
/// entry per light: its value, and the index of its emitter.
fn sums(values: &[f64], emitters: &[usize], count: usize) -> Vec<f64> {
    let mut sums = vec![0.0; count];
    for (value, emitter) in values.iter().zip(emitters) {
        sums[*emitter] += value;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Classifies lights, each of which is a separate emitter with one of the `powers`. The result has one entry per light:
    /// true if it is rare.
    fn rare(powers: &[f64]) -> Vec<bool> {
        let found = RareLights::find(powers, 0..powers.len());
        found.map_or(vec![false; powers.len()], |found| found.is_rare)
    }

    #[test]
    fn few_dim_emitters_beside_a_bright_one_are_rare() {
        assert_eq!(rare(&[1000.0, 1.0, 0.0, 2.0]), [false, true, false, true]);
        assert_eq!(rare(&[20.0, 1.0]), [false; 2]);
        assert_eq!(rare(&[5.0]), [false]);
        assert!(rare(&[]).is_empty());
        // As dim as others may be, together they are not.
        let with = |bright: &[f64], dim: usize| rare(&[bright, &vec![1.0; dim]].concat());
        assert!(with(&[1000.0], 10).contains(&true));
        assert!(!with(&[1000.0], 11).contains(&true));
        // Many bright emitters make one rare that is not so much dimmer than each of them.
        assert!(with(&[20.0; 30], 1).contains(&true));
        assert!(!with(&[7.0; 30], 1).contains(&true));
    }

    /// Equal emitters at different positions have slightly different areas, which must not make some of them rare.
    #[test]
    fn emitters_that_differ_by_rounding_are_rare_together() {
        let dim: Vec<f64> = (0..11).map(|i| 1.0 + 1e-15 * f64::from(i)).collect();
        assert!(!rare(&[vec![1000.0], dim].concat()).contains(&true));
    }

    #[test]
    fn slivers_of_a_bright_emitter_are_not_rare() {
        let powers = [1000.0, 0.001, 1.0];
        let found = RareLights::find(&powers, [7, 7, 8].into_iter()).unwrap();
        assert_eq!(found.is_rare, [false, false, true]);
        assert_eq!(found.common_weights(&powers), [1000.0, 0.001, 0.0]);
        assert_eq!(found.rare_weights(&powers), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn rare_emitters_count_the_same_and_share_by_power() {
        let powers = [1e6, 3.0, 1.0, 1.0];
        let found = RareLights::find(&powers, [0, 1, 1, 2].into_iter()).unwrap();
        assert_eq!(found.rare_weights(&powers), [0.0, 0.75, 0.25, 1.0]);
        // While all of them are off, some must still be drawn.
        let weights = found.rare_weights(&[1e6, 0.0, 0.0, 0.0]);
        assert_eq!(weights, [0.0, 0.5, 0.5, 1.0]);
        assert_eq!(
            found.common_weights(&[0.0, 3.0, 1.0, 1.0]),
            [1.0, 0.0, 0.0, 0.0]
        );
    }
}
