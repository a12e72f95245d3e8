//! The times of the configurations of a study, and their errors at equal time. They differ from run to run
//! with the speed of the machine, so they are kept apart from the results, which are the same in every
//! repetition.

use super::plan::Resolved;
use super::run::{Milliseconds, Run, frame_times};
use crate::metrics::statistics::Estimate;
use crate::render::settings::Integrator;
use serde::Serialize;

/// The times of one configuration on one scene, and its errors compared with path tracing in the same time.
#[derive(Clone, Debug, Serialize)]
pub struct Cost {
    /// The name of the scene in the plan, which tables show.
    pub scene: String,
    /// The name of the configuration in the plan, which tables show.
    pub configuration: String,
    /// The number of runs from which the times were computed, one run for each seed.
    pub seeds: usize,
    /// The time of each pass in one frame, in milliseconds: the median over the frames of all runs. Frame 0 is left out if a
    /// run has more frames, because it has no history. The first execution of each pass is left out too, because it may
    /// contain the compilation of the pass.
    pub milliseconds: Milliseconds,
    /// The time of each pass when it was executed for the first time, in milliseconds; some drivers compile the pass then.
    /// The times are taken from the first run that has such times; the list is empty if no run has them.
    pub first_runs: Milliseconds,
    /// The time of a frame, divided by the time of a frame of path tracing: the mean over the runs with the
    /// same seed, because these were rendered in turns under the same conditions. Null for path tracing
    /// itself, if the scene has no path tracing in the plan, or for fewer than two common seeds.
    pub time_ratio: Option<Ratio>,
    /// The root of the relMSE of the last frame, divided by the error of path tracing in the same time; below
    /// 1, the configuration is better. The time is that of one frame, or of all frames if the configuration
    /// accumulates; path tracing averages all frames that fit into it. Null if [`Self::time_ratio`] is null,
    /// or if an error is 0.
    pub error_at_equal_time: Option<Ratio>,
    /// The clamped RMSE of the last frame, divided by that of path tracing in the same time, like
    /// [`Self::error_at_equal_time`].
    pub clamped_error_at_equal_time: Option<Ratio>,
}

/// A ratio of two measured quantities, such as times or errors, with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ratio {
    /// The estimated ratio; below 1, the configuration has the smaller quantity.
    pub value: f64,
    /// The lower and the upper end of the 95 % interval of [`Self::value`].
    pub interval: [f64; 2],
}

impl Ratio {
    /// The ratio whose natural logarithm is estimated by `log`. `None` if the estimate is from fewer than two
    /// samples or not finite.
    fn of(log: Estimate) -> Option<Self> {
        let half_width = log.t_interval_half_width(0.95);
        (log.mean.is_finite() && half_width.is_finite()).then(|| Self {
            value: log.mean.exp(),
            interval: [log.mean - half_width, log.mean + half_width].map(f64::exp),
        })
    }
}

impl Cost {
    /// Computes the costs of one configuration from its runs. `base` is path tracing on the same scene with
    /// its runs, with which the configuration is compared; with `None`, there are no ratios.
    pub fn of(
        scene: &str,
        (configuration, runs): (&Resolved, &[&Run]),
        base: Option<(&Resolved, &[&Run])>,
    ) -> Self {
        // With itself, nothing is to be compared.
        let base = base.filter(|(base, _)| base.name != configuration.name);
        let time_ratio = base.map(|(_, base)| log_time_ratio(runs, base));
        let at_equal_time = |squared: fn(&Run) -> &[f64]| {
            let (base, base_runs) = base?;
            let own = log_squared_error(configuration, runs, squared);
            let other = log_squared_error(base, base_runs, squared);
            let ratio = own.minus(&other);
            // Squared errors fall with the inverse of the time.
            let time = time_ratio?;
            Ratio::of(Estimate {
                mean: 0.5 * (ratio.mean + time.mean),
                standard_error: 0.5 * ratio.standard_error.hypot(time.standard_error),
                samples: ratio.samples.min(time.samples),
            })
        };
        let with_first = runs.iter().find(|run| !run.first_runs.is_empty());
        Self {
            scene: scene.to_owned(),
            configuration: configuration.name.clone(),
            seeds: runs.len(),
            milliseconds: frame_times(runs),
            // Later runs may have such times too, because passes are made again if a study continues in another process.
            first_runs: with_first.map_or_else(Milliseconds::new, |run| run.first_runs.clone()),
            time_ratio: time_ratio.and_then(Ratio::of),
            error_at_equal_time: at_equal_time(|run| &run.relmse),
            clamped_error_at_equal_time: at_equal_time(|run| &run.clamped_mse),
        }
    }

    /// The time of a frame on the device, in milliseconds: the sum over its passes.
    pub fn frame_milliseconds(&self) -> f64 {
        self.milliseconds.iter().map(|(_, ms)| ms).sum()
    }
}

/// True if the configuration is path tracing. The first such configuration on a scene is the one that the
/// others are compared with.
pub fn is_path_tracing(configuration: &Resolved) -> bool {
    configuration.settings.integrator == Integrator::PathTracing
}

/// The natural logarithm of the ratio of frame times, `runs` to `base`: the mean and the standard error over
/// the seeds that both have.
fn log_time_ratio(runs: &[&Run], base: &[&Run]) -> Estimate {
    // Frames in which a pass ran for the first time lack it, so the medians are those of passes.
    let frame = |run: &Run| -> f64 { frame_times(&[run]).iter().map(|(_, ms)| ms).sum() };
    let pairs = runs.iter().filter_map(|run| {
        let other = base.iter().find(|other| other.seed == run.seed)?;
        let ratio = (frame(run) / frame(other)).ln();
        // A run whose every pass ran for the first time has no time.
        ratio.is_finite().then_some(ratio)
    });
    Estimate::of(&pairs.collect::<Vec<f64>>())
}

/// The natural logarithm of the squared error of a single frame, with its standard error over the runs;
/// `squared` selects the relMSE or the clamped MSE. If n frames are accumulated, it is n times the squared
/// error of their mean, because the errors of independent frames average out.
fn log_squared_error(
    configuration: &Resolved,
    runs: &[&Run],
    squared: fn(&Run) -> &[f64],
) -> Estimate {
    let of_run = |run: &&Run| -> f64 {
        let frames = squared(run);
        let last = frames.last().copied().unwrap_or(f64::NAN);
        if configuration.accumulate {
            last * frames.len() as f64
        } else if is_path_tracing(configuration) && configuration.clock.fps.is_none() {
            frames.iter().sum::<f64>() / frames.len() as f64
        } else {
            last
        }
    };
    let each: Vec<f64> = runs.iter().map(of_run).collect();
    let mean = Estimate::of(&each);
    Estimate {
        mean: mean.mean.ln(),
        standard_error: mean.standard_error / mean.mean,
        samples: mean.samples,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Settings;

    fn configuration(integrator: Integrator, accumulate: bool) -> Resolved {
        Resolved {
            accumulate,
            ..Resolved::of(Settings {
                integrator,
                ..Settings::default()
            })
        }
    }

    /// Four runs of four frames for tests. The relMSE of the frames is about `relmse`, and their time about
    /// `ms` milliseconds; frame 0 is slower.
    fn runs(relmse: [f64; 4], ms: f64) -> Vec<Run> {
        (0..4)
            .map(|seed| {
                let scatter = [0.97, 1.03, 0.99, 1.01][seed as usize];
                let frame = |ms: f64| vec![("pass".to_owned(), ms * scatter)];
                Run {
                    seed,
                    relmse: relmse.map(|e| e * scatter).to_vec(),
                    clamped_mse: relmse.map(|e| e * scatter).to_vec(),
                    milliseconds: vec![frame(50.0 * ms), frame(ms), frame(ms), frame(ms)],
                    ..Run::default()
                }
            })
            .collect()
    }

    #[test]
    fn errors_are_compared_at_equal_time() {
        // A frame of path tracing has the relMSE 0.8; accumulated, the fourth one has 0.2.
        let accumulated = runs([0.8, 0.4, 0.8 / 3.0, 0.2], 10.0);
        let single = runs([0.8; 4], 10.0);
        let own = runs([0.9, 0.5, 0.3, 0.1], 20.0);
        let refs = |runs: &'static [Run]| -> Vec<&'static Run> { runs.iter().collect() };
        let [accumulated, single, own] =
            [accumulated, single, own].map(|runs| refs(Vec::leak(runs)));
        for (base, accumulates) in [(accumulated, true), (single, false)] {
            let mut path_tracing = configuration(Integrator::PathTracing, accumulates);
            path_tracing.name = "path tracing".into();
            let cost = Cost::of(
                "scene",
                (&configuration(Integrator::Restir, false), &own),
                Some((&path_tracing, &base)),
            );
            let time = cost.time_ratio.unwrap();
            assert!((time.value - 2.0).abs() < 1e-9, "{time:?}");
            assert_eq!(cost.frame_milliseconds(), 20.0);
            // In the time of two frames path tracing has 0.4.
            let error = cost.error_at_equal_time.unwrap();
            assert!((error.value - 0.5).abs() < 1e-9, "{error:?}");
            assert!(
                error.interval[0] > 0.45 && error.interval[1] < 0.55,
                "{error:?}"
            );
        }
    }

    #[test]
    fn without_path_tracing_there_are_no_ratios() {
        let own = runs([0.1; 4], 5.0);
        let own: Vec<&Run> = own.iter().collect();
        let cost = Cost::of(
            "scene",
            (&configuration(Integrator::Restir, false), &own),
            None,
        );
        assert_eq!((cost.time_ratio, cost.error_at_equal_time), (None, None));
    }
}
