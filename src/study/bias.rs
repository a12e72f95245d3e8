//! Tests whether a configuration has a bias: whether the mean of its pictures over many seeds differs from the reference. A
//! confidence interval states how well the difference is known.
//!
//! Frames of a run depend on each other, so runs with different seeds are the samples. Two things are tested:
//!
//! - the mean of the picture is compared with that of the reference by Welch's t-test, which includes the error of the
//!   reference. If no bias is found, but the half-width of the interval exceeds half a percent of the reference's mean, the
//!   verdict is `undecided`;
//! - blocks of pixels are compared too, because a bias can cancel over the picture. The noise of rendered pictures is skewed
//!   to the right, so the distribution of the blocks' t values is compared with that of a control: path tracing, which has
//!   no bias, with about as much noise as the configuration. The worst block is also tested by itself, since one corner of a
//!   picture hardly changes a distribution. These tests ignore that neighbouring blocks are correlated, so they only raise
//!   an alarm.
//!
//! After an alarm of either test, runs with fresh seeds alone decide, because the first seeds were the reason for the alarm.

use super::plan::{Expect, Resolved};
use super::reference::Reference;
use super::run::Run;
use super::subject::path_tracing;
use crate::metrics::statistics::{Estimate, kolmogorov_smirnov_p_value, t_tail, welch_p_value};
use serde::Serialize;

/// The limit for the half-width of the 99 % interval of a bias, as a fraction of the reference's mean. Above it, a
/// configuration never gets the verdict `unbiased`, because a wide interval could hide a bias. If the plan expects the
/// configuration to be unbiased, it gets more seeds until its half-width is at most this limit or its number of seeds is the
/// plan's maximum.
pub const MAX_HALF_WIDTH: f64 = 0.005;
/// The limit for the half-width of the 99 % interval of a reference's mean, as a fraction of this mean. If a plan expects
/// `unbiased`, a reference whose half-width is larger gets more samples, except with the option `--quick`. The limit is
/// below [`MAX_HALF_WIDTH`], because the interval of a bias contains the error of the reference and also the error of the runs.
pub const MAX_REFERENCE_HALF_WIDTH: f64 = 0.004;
/// The level of the tests for bias: if a corrected p-value of a configuration on a scene is below it, the verdict there is
/// `biased`. Holm's method corrects the p-values of several tests together for the number of these tests. The level is the
/// largest accepted probability, in [0, 1], that any of these tests finds a bias where there is none.
pub const LEVEL: f64 = 0.01;
/// The minimum number of runs with fresh seeds, which decide after an alarm (a sign of bias in the first runs) whether the
/// configuration is biased. If the alarm came from more seeds than this, the number of fresh seeds is as large as theirs,
/// because fewer runs could miss the same bias.
pub const CONFIRMING_SEEDS: u32 = 128;
/// The maximum number of samples per pixel of a control, which bounds the time that controls take. A control is path tracing
/// with about as much noise as a configuration. The blocks of pixels of the configuration are compared with those of its
/// control. If a configuration has less noise than this number of samples gives, its control has more noise than the
/// configuration.
const MAX_CONTROL_SAMPLES: u32 = 64;
/// The half-width of the central interval of a normal distribution that contains 99 % of it, in standard deviations. It
/// predicts how many seeds make an interval narrow enough; for many seeds, Student's distribution is nearly normal.
const NORMAL_99: f64 = 2.5758;
/// The number of standard errors by which a bias must exceed the smallest difference that the t-test of a mean calls a bias,
/// so that the test finds it with a probability of 90 %. [`Bias::detectable`], which results state, is computed with it.
const POWER: f64 = 1.2816;

/// The bias of the mean of a configuration's pictures, estimated from its runs: the difference from the mean of the
/// reference, with intervals and p-values. The verdict about the configuration on the scene follows from it. Lists have one
/// entry for each of red, green and blue.
#[derive(Clone, Debug, Serialize)]
pub struct Bias {
    /// The number of runs, each with its own seed, from which the bias was estimated.
    pub seeds: usize,
    /// For each channel, the mean of the runs minus the mean of the reference, as a fraction of [`Reference::scale`], which
    /// is the reference's mean unless the channel is black. It is positive if the pictures are too bright.
    pub relative: [f64; 3],
    /// For each channel, the half-width of the 99 % interval around [`Self::relative`], in the same unit. While it is above
    /// [`MAX_HALF_WIDTH`], the interval is too wide for the verdict `unbiased`.
    pub half_width: [f64; 3],
    /// For each channel, the probability that an unbiased configuration differs from the reference by at least the measured
    /// difference. Small values raise an alarm. The p-values are not corrected for the number of tests;
    /// [`judge`](super::results::judge) corrects them.
    pub p_values: [f64; 3],
    #[serde(skip)]
    differences: [Estimate; 3],
    /// For each channel, the standard error of the reference's mean, in the unit of its radiance. The error of a difference
    /// from the reference contains it, and more seeds do not reduce this part.
    #[serde(skip)]
    truth_errors: [f64; 3],
    #[serde(skip)]
    scale: [f64; 3],
}

impl Bias {
    /// Estimates the bias of one configuration: the mean of `runs`, one run for each seed, minus the mean of `reference`,
    /// which is the reference of the last frame. A difference so small that rounding alone can cause it counts as 0.
    pub fn measure(runs: &[&Run], reference: &Reference) -> Self {
        let truth = reference.mean_estimates();
        let own = [0, 1, 2].map(|c| {
            let means: Vec<f64> = runs.iter().map(|run| run.mean[c]).collect();
            Estimate::of(&means)
        });
        let (rounding, _) = reference.rounding();
        let (scale, _) = reference.scale();
        let is_exact = [0, 1, 2].map(|c| is_rounding(&own[c].minus(&truth[c]), rounding[c]));
        let differences = [0, 1, 2].map(|c| {
            let difference = own[c].minus(&truth[c]);
            if is_exact[c] {
                Estimate {
                    mean: 0.0,
                    standard_error: 0.0,
                    ..difference
                }
            } else {
                difference
            }
        });
        Self {
            seeds: runs.len(),
            relative: [0, 1, 2].map(|c| differences[c].mean / scale[c]),
            half_width: half_widths(&differences, &scale, 0.99),
            p_values: [0, 1, 2].map(|c| {
                if is_exact[c] {
                    1.0
                } else {
                    welch_p_value(&own[c], &truth[c])
                }
            }),
            differences,
            truth_errors: truth.map(|t| t.standard_error),
            scale,
        }
    }

    /// For each channel, the half-width of the interval around [`Self::relative`] that has the level `level`, such as 0.95.
    pub fn half_widths(&self, level: f64) -> [f64; 3] {
        half_widths(&self.differences, &self.scale, level)
    }

    /// The mean, over the three channels, of the radiance by which biases are divided ([`Reference::scale`]). Figures divide
    /// errors by it, so that bright and dark scenes are comparable.
    pub fn brightness(&self) -> f64 {
        self.scale.iter().sum::<f64>() / 3.0
    }

    /// The largest of the half-widths of the three channels ([`Self::half_width`]), as a fraction of the reference's mean. A
    /// study compares it with [`MAX_HALF_WIDTH`]: while it is larger, more seeds are needed for the verdict `unbiased`.
    pub fn largest_half_width(&self) -> f64 {
        self.half_width.iter().copied().fold(0.0, f64::max)
    }

    /// The smallest bias that the test finds with a probability of 90 %, as a fraction of the reference's mean; results
    /// state it as the power of the check. It is computed for each channel, and the largest of the three values is returned.
    /// `tests` is the number of tests that are corrected together; with more tests, only a larger bias is found.
    pub fn detectable(&self, tests: usize) -> f64 {
        let level = LEVEL / tests.max(1) as f64;
        let each = [0, 1, 2].map(|c| {
            let difference = &self.differences[c];
            let threshold = difference.t_interval_half_width(1.0 - level);
            (threshold + POWER * difference.standard_error) / self.scale[c]
        });
        each.into_iter().fold(0.0, f64::max)
    }

    /// The number of additional seeds with which the half-widths of all channels would be at most [`MAX_HALF_WIDTH`]; 0 if they are
    /// already. Results recommend it for an undecided configuration. `None` if the error of the reference is so large that
    /// no number of seeds suffices.
    pub fn missing_seeds(&self) -> Option<f64> {
        let seeds = self.seeds as f64;
        let needed = [0, 1, 2].map(|c| {
            let error = self.differences[c].standard_error;
            if self.half_width[c] <= MAX_HALF_WIDTH {
                return Some(seeds);
            }
            // Of as many seeds as it takes, Student's interval is nearly a normal one. Only the runs' part of the
            // error shrinks with their number.
            let wanted = MAX_HALF_WIDTH * self.scale[c] / NORMAL_99;
            let truth = self.truth_errors[c].powi(2);
            let left = wanted.powi(2) - truth;
            let needed = seeds * (error.powi(2) - truth).max(0.0) / left;
            (left > 0.0).then(|| needed.max(seeds + 1.0))
        });
        let needed: Option<Vec<f64>> = needed.into_iter().collect();
        needed.map(|all| (all.into_iter().fold(seeds, f64::max) - seeds).ceil())
    }
}

/// For each channel, the half-width of the interval of a difference, for the confidence level `level` such as
/// 0.95. The differences are divided by `scale` (see [`Reference::scale`]), so the results are fractions.
fn half_widths(differences: &[Estimate; 3], scale: &[f64; 3], level: f64) -> [f64; 3] {
    [0, 1, 2].map(|c| differences[c].t_interval_half_width(level) / scale[c])
}

/// True if the magnitude of a difference from the reference and its standard error are both at most `rounding`, so that
/// rounding alone explains the difference, and it does not count as a bias. All three have the unit of the compared means.
fn is_rounding(difference: &Estimate, rounding: f64) -> bool {
    difference.mean.abs() <= rounding && difference.standard_error <= rounding
}

/// For each block (a square of 8 × 8 pixels), row by row, the mean of its luminance over the runs minus its luminance in the
/// reference. Tests for a bias of blocks use it. It is `None` for a block without noise, such as a black one, and for a
/// block with a difference so small that rounding alone can cause it.
fn block_differences(runs: &[&Run], reference: &Reference) -> Vec<Option<Estimate>> {
    let truth = reference.block_estimates();
    let (_, rounding) = reference.rounding();
    (truth.iter().zip(rounding).enumerate())
        .map(|(block, (truth, rounding))| {
            let means: Vec<f64> = runs.iter().map(|run| run.blocks[block]).collect();
            let difference = Estimate::of(&means).minus(truth);
            let has_noise = difference.standard_error > 0.0;
            (has_noise && !is_rounding(&difference, rounding)).then_some(difference)
        })
        .collect()
}

/// The t value of each block: the difference of its mean luminance from the reference, divided by the standard error of this
/// difference. [`blocks_p_value`] compares their distribution with that of a control. Blocks with `None` in
/// [`block_differences`] are left out, so the index of an entry is not the index of a block.
fn t_values(runs: &[&Run], reference: &Reference) -> Vec<f64> {
    (block_differences(runs, reference).iter().flatten())
        .map(|difference| difference.mean / difference.standard_error)
        .collect()
}

/// The p-value for a bias in blocks (squares of 8 × 8 pixels) of a configuration; a small value raises an alarm. It is twice
/// the smaller p-value of two tests, and at most 1. The first test compares the distribution of the blocks' t values with
/// that of the blocks of `control` (runs of path tracing with similar noise). The second tests the block whose t value is
/// farthest from 0. The p-value would be exact if blocks were independent; it is 1 if no block has noise.
pub fn blocks_p_value(runs: &[&Run], control: &[&Run], reference: &Reference) -> f64 {
    let own = t_values(runs, reference);
    if own.is_empty() {
        return 1.0;
    }
    let all = kolmogorov_smirnov_p_value(&own, &t_values(control, reference));
    let farthest = own.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
    let worst = 2.0 * t_tail(farthest, runs.len() as f64 - 1.0) * own.len() as f64;
    (2.0 * all.min(worst)).min(1.0)
}

/// Makes the control of `configuration`, with which it is compared to find a bias: a configuration that renders the same
/// kinds of light by path tracing, which has no bias. Its picture is the mean of `samples` samples per pixel, and shows the
/// scene at the time of the last frame of `configuration`. The blocks of pixels of both are compared.
pub fn control(configuration: &Resolved, samples: u32) -> Resolved {
    Resolved {
        name: format!("control, {samples} samples"),
        settings: path_tracing(&configuration.settings),
        frames: samples,
        clock: configuration.clock.stopped_at(configuration.frames - 1),
        accumulate: true,
        count: false,
        scenes: [].into(),
        expect: Expect::Any,
    }
}

/// The number of samples per pixel with which the blocks of a control (path tracing for comparison) have about as much noise
/// as those of `runs`. It is a power of two from 1 to 64. It is computed from the noise of `single`, the runs of a control
/// with one sample per pixel.
pub fn control_samples(runs: &[&Run], single: &[&Run]) -> u32 {
    let variance = |runs: &[&Run]| {
        let blocks = runs.first().map_or(0, |run| run.blocks.len());
        let mut all: Vec<f64> = (0..blocks)
            .map(|b| {
                let means: Vec<f64> = runs.iter().map(|run| run.blocks[b]).collect();
                Estimate::of(&means).standard_error.powi(2) * means.len() as f64
            })
            .filter(|v| *v > 0.0)
            .collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(1.0)
    };
    let wanted = (variance(single) / variance(runs)).max(1.0).log2().round();
    (2.0_f64.powf(wanted) as u32).clamp(1, MAX_CONTROL_SAMPLES)
}

/// The result of the runs with fresh seeds, which alone decide whether a configuration is biased after an alarm (a sign of
/// bias in the first runs). The first runs cannot decide this, because they were the reason for the alarm.
#[derive(Clone, Debug, Serialize)]
pub struct Confirmation {
    /// The bias of the mean of the picture, estimated from the runs with fresh seeds alone. The verdict about the
    /// configuration follows from it, and not from the bias of the first runs.
    pub bias: Bias,
    /// The p-value of the test whether the fresh runs deviate from the reference in the same blocks, and to the same side,
    /// as the first runs. It is the probability, without bias, that they show this pattern at least as strongly. It is 1 if
    /// they deviate to the opposite side.
    pub pattern_p_value: f64,
}

impl Confirmation {
    /// Tests the runs `fresh` for a bias of their mean, and for the pattern of blocks in which the runs `first` deviated
    /// from the reference. A weighted sum over blocks, with the pattern as weights, reduces each run to one number.
    /// Therefore the test stays correct although the noise of neighbouring blocks is correlated.
    pub fn measure(first: &[&Run], fresh: &[&Run], reference: &Reference) -> Self {
        let differences = block_differences(first, reference);
        let pattern: Vec<f64> = (differences.iter())
            .map(|block| block.map_or(0.0, |d| d.mean / d.standard_error.powi(2)))
            .collect();
        let project = |values: &mut dyn Iterator<Item = f64>| -> f64 {
            values.zip(&pattern).map(|(v, w)| v * w).sum()
        };
        let own: Vec<f64> = (fresh.iter())
            .map(|run| project(&mut run.blocks.iter().copied()))
            .collect();
        let own = Estimate::of(&own);
        let blocks = reference.block_estimates();
        // The reference's error is in the pattern and in what the fresh runs are held against: they
        // would seem to agree by each block's fraction of it.
        let (mut shared, mut error) = (0.0, 0.0);
        for ((block, difference), weight) in blocks.iter().zip(&differences).zip(&pattern) {
            let Some(difference) = difference else {
                continue;
            };
            let fraction = (block.standard_error / difference.standard_error).powi(2);
            shared += fraction;
            error += (block.standard_error * weight).powi(2) + 2.0 * fraction * fraction;
        }
        let truth = Estimate {
            mean: project(&mut blocks.iter().map(|b| b.mean)) + shared,
            standard_error: error.sqrt(),
            samples: blocks.first().map_or(1, |b| b.samples),
        };
        // Only a difference to the same side confirms.
        let pattern_p_value = if own.mean > truth.mean {
            welch_p_value(&own, &truth) / 2.0
        } else {
            1.0
        };
        Self {
            bias: Bias::measure(fresh, reference),
            pattern_p_value,
        }
    }
}

#[cfg(test)]
pub(super) mod samples;

#[cfg(test)]
mod tests;
