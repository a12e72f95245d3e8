//! Measures the bias of blocks of pixels. Unlike the bias of the mean of the picture, it is not 0 if positive and negative
//! biases cancel over the picture, for example where light is blurred.

use super::reference::Reference;
use super::run::Run;
use crate::metrics::statistics::Estimate;
use serde::Serialize;

/// The size of the bias in blocks of 8 × 8 pixels: the root mean square, over all blocks of a picture, of the bias of a
/// block's mean luminance. The part that noise explains is subtracted. Tables of results show it, so that users see a bias
/// that cancels over the picture; no verdict depends on it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BlockBias {
    /// The root mean square, over all blocks, of the bias of a block's mean luminance, as a fraction of the reference's mean
    /// luminance without directly visible emission. It is 0 if noise explains all differences.
    pub relative: f64,
    /// The lower and then the upper end of the 99 % interval of [`Self::relative`]. Both are at least 0, and
    /// fractions of the reference's mean luminance.
    pub interval: [f64; 2],
}

impl BlockBias {
    /// Measures the bias of the blocks from all runs of one configuration, one run for each seed. `reference` is that of the
    /// last frame. Returns `None` for fewer than three runs, from which the error of the result cannot be estimated.
    ///
    /// The product of two runs' differences from the reference has the square of the bias as its mean, since the noise of
    /// different runs is independent. The mean of this product over all pairs of runs is a U-statistic (Hoeffding, "A class
    /// of statistics with asymptotically normal distribution", 1948). Its error is estimated by the jackknife, which leaves
    /// out one run at a time.
    pub fn measure(runs: &[&Run], reference: &Reference) -> Option<Self> {
        let truth = reference.block_estimates();
        let blocks = truth.len() as f64;
        let count = runs.len() as f64;
        if runs.len() < 3 {
            return None;
        }
        let differences: Vec<Vec<f64>> = (runs.iter())
            .map(|run| {
                let pairs = run.blocks.iter().zip(&truth);
                pairs.map(|(own, truth)| own - truth.mean).collect()
            })
            .collect();
        // With Σ and Σ² over runs all pairs' products sum to (Σ)² − Σ².
        let mut sums = vec![(0.0, 0.0); truth.len()];
        for of_run in &differences {
            for (sum, d) in sums.iter_mut().zip(of_run) {
                *sum = (sum.0 + d, sum.1 + d * d);
            }
        }
        let mean_product = |without: &[f64], runs: f64| {
            let products = sums.iter().zip(without);
            let all: f64 = products
                .map(|((sum, squares), d)| (sum - d).powi(2) - (squares - d * d))
                .sum();
            all / (runs * (runs - 1.0) * blocks)
        };
        let whole = mean_product(&vec![0.0; truth.len()], count);
        let parts: Vec<f64> = (differences.iter())
            .map(|of_run| count * whole - (count - 1.0) * mean_product(of_run, count - 1.0))
            .collect();

        // The reference's own error e is in every difference, so that of a block with bias β the square is
        // (β − e)²: its mean is β² + v, its variance 4β²v + 2v².
        let (mut mean, mut variance) = (0.0, 0.0);
        for ((sum, squares), t) in sums.iter().zip(&truth) {
            let v = t.standard_error.powi(2);
            let bias_squared = (sum.powi(2) - squares) / (count * (count - 1.0)) - v;
            mean += v / blocks;
            variance += (4.0 * bias_squared.max(0.0) * v + 2.0 * v * v) / (blocks * blocks);
        }
        let shared = Estimate {
            mean,
            standard_error: variance.sqrt(),
            samples: truth.first().map_or(1, |t| t.samples),
        };
        let square = Estimate::of(&parts).minus(&shared);
        let half_width = square.t_interval_half_width(0.99);
        let (_, luminance) = reference.scale();
        let part = |square: f64| square.max(0.0).sqrt() / luminance;
        Some(Self {
            relative: part(square.mean),
            interval: [square.mean - half_width, square.mean + half_width].map(part),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::bias::samples::{noisy_reference, reference, runs};
    use super::*;

    fn measured(count: u32, offset: [f64; 6]) -> BlockBias {
        let runs = runs(count, 0, offset);
        BlockBias::measure(&runs.iter().collect::<Vec<_>>(), &reference()).unwrap()
    }

    #[test]
    fn a_bias_that_cancels_is_as_large_as_it_is() {
        let found = measured(64, [0.02, -0.02, 0.02, -0.02, 0.02, -0.02]);
        assert!((found.relative - 0.02).abs() < 0.005, "{found:?}");
        let [low, high] = found.interval;
        assert!(low > 0.01 && low < 0.02 && high > 0.02, "{found:?}");
    }

    #[test]
    fn noise_is_no_bias() {
        let found = measured(64, [0.0; 6]);
        assert!(
            found.interval[0] == 0.0 && found.relative < 0.006,
            "{found:?}"
        );
        assert!(found.interval[1] > found.relative, "{found:?}");
    }

    #[test]
    fn intervals_cover_the_truth() {
        const TRIALS: u32 = 200;
        let offset = [0.01, -0.01, 0.0, 0.01, -0.01, 0.0];
        let truth = (4.0_f64 / 6.0 * 1e-4).sqrt();
        let missed = (0..TRIALS).filter(|trial| {
            let runs = runs(64, 1000 * trial, offset);
            let found = BlockBias::measure(&runs.iter().collect::<Vec<_>>(), &reference()).unwrap();
            !(found.interval[0]..=found.interval[1]).contains(&truth)
        });
        // Of 200 at one in a hundred more than 8 come once in three thousand times.
        let missed = missed.count();
        assert!(missed <= 8, "{missed} of {TRIALS}");
    }

    /// In block 0, the reference has more noise than in the other five blocks. The runs have no bias in the first round, and
    /// a bias in this block alone in the second round.
    #[test]
    fn intervals_cover_the_truth_beside_a_noisy_reference() {
        const TRIALS: u32 = 200;
        for offset in [0.0, 0.1] {
            let truth = (offset * offset / 6.0_f64).sqrt();
            let missed = (0..TRIALS).filter(|trial| {
                let first_seed = 100_000 * (trial + 1);
                let noisy = noisy_reference(first_seed, [16, 128, 128, 128, 128, 128]);
                let runs = runs(128, first_seed + 7000, [offset, 0.0, 0.0, 0.0, 0.0, 0.0]);
                let found = BlockBias::measure(&runs.iter().collect::<Vec<_>>(), &noisy).unwrap();
                !(found.interval[0]..=found.interval[1]).contains(&truth)
            });
            // As above, but that the reference's errors are known from few runs themselves.
            let missed = missed.count();
            assert!(missed <= 12, "{missed} of {TRIALS} at {offset}");
        }
    }

    #[test]
    fn two_runs_say_nothing() {
        let runs = runs(2, 0, [0.5; 6]);
        let found = BlockBias::measure(&runs.iter().collect::<Vec<_>>(), &reference());
        assert!(found.is_none(), "{found:?}");
    }

    #[test]
    fn a_black_scene_has_no_bias_in_its_blocks() {
        let mut black = reference();
        black.mean = vec![[0.0; 3]; black.mean.len()];
        black.error = black.mean.clone();
        let mut runs = runs(8, 0, [0.0; 6]);
        for run in &mut runs {
            run.blocks = vec![0.0; 6];
        }
        let found = BlockBias::measure(&runs.iter().collect::<Vec<_>>(), &black).unwrap();
        assert_eq!((found.relative, found.interval), (0.0, [0.0; 2]));
    }
}
