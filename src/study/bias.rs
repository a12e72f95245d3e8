//! Whether a configuration is biased, and what the answer is worth.
//!
//! Frames of a run depend on each other, so seeds are the samples. The image's mean is compared with
//! the reference's by Student's t, the reference's error included, Holm's correction over everything
//! the study compares; an interval too wide to see half a percent is no pass. Block by block, light
//! noise is skewed to the right, so the t values are compared with those of an unbiased control.

use super::reference::Reference;
use super::run::Run;
use crate::metrics::statistics::{Estimate, kolmogorov_smirnov_p_value, welch_p_value};
use serde::Serialize;

/// Widest 99 % half-width, as a part of the mean, that still shows something.
pub const WIDEST: f64 = 0.005;
/// Chance of a false alarm over all that a study compares.
pub const LEVEL: f64 = 0.01;

/// What seeds say of a configuration's mean.
#[derive(Clone, Debug, Serialize)]
pub struct Bias {
    /// Relative bias of each channel's mean.
    pub relative: [f64; 3],
    /// 99 % half-widths of these.
    pub half_width: [f64; 3],
    /// Chance of differences as large without bias, for each channel, uncorrected.
    pub p_values: [f64; 3],
    /// Chance that the blocks' t values come from the control's distribution; 1 without a control.
    pub blocks_p_value: f64,
}

/// Measures the bias of one configuration's runs. `control` are the t values of an unbiased one.
pub fn measure(runs: &[&Run], reference: &Reference, control: Option<&[f64]>) -> Bias {
    let truth = reference.mean_estimates();
    let mut bias = Bias {
        relative: [0.0; 3],
        half_width: [0.0; 3],
        p_values: [1.0; 3],
        blocks_p_value: 1.0,
    };
    for (c, truth) in truth.iter().enumerate() {
        let means: Vec<f64> = runs.iter().map(|run| run.mean[c]).collect();
        let estimate = Estimate::of(&means);
        let difference = estimate.minus(truth);
        let scale = truth.mean.abs().max(f64::MIN_POSITIVE);
        bias.relative[c] = difference.mean / scale;
        bias.half_width[c] = difference.t_interval_half_width(0.99) / scale;
        bias.p_values[c] = welch_p_value(&estimate, truth);
    }
    if let Some(control) = control {
        bias.blocks_p_value = kolmogorov_smirnov_p_value(&block_t_values(runs, reference), control);
    }
    bias
}

/// How many standard errors each block's mean is from the reference's. Blocks without noise, black
/// ones, are left out.
pub fn block_t_values(runs: &[&Run], reference: &Reference) -> Vec<f64> {
    let truth = reference.block_estimates();
    truth
        .iter()
        .enumerate()
        .filter_map(|(block, truth)| {
            let means: Vec<f64> = runs.iter().map(|run| run.blocks[block]).collect();
            let difference = Estimate::of(&means).minus(truth);
            (difference.standard_error > 0.0).then(|| difference.mean / difference.standard_error)
        })
        .collect()
}
