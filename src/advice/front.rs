//! The result of a race, called a front: the frame time and the error of each candidate. It can be stored,
//! and settings can be chosen from it later without another race.

use super::candidates::Candidate;
use super::chain::{Chain, Purpose, logarithms};
use super::truth::Truth;
use crate::metrics::statistics::Estimate;
use serde::{Deserialize, Serialize};

/// Minimum median brightness of a candidate's frame, as a fraction of that of a path-traced frame. The
/// brightness of a lit pixel is its luminance divided by that of the reference. A candidate below this limit
/// is never recommended: a picture whose pixels are mostly dark can have a small error, because it has little
/// noise, but it is useless.
const LEAST_MEDIAN: f64 = 0.5;

/// The result of a race: the measured candidates of one scene, view and device, and the conditions of the
/// measurement.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Front {
    /// Purpose of the advice, which decided which frames were measured.
    pub purpose: Purpose,
    /// Width and height, in pixels, of the frames in which errors were measured.
    pub size: (u32, u32),
    /// Width and height, in pixels, of the picture that the user wants. The frame times of all points are for
    /// this size.
    pub wanted_size: (u32, u32),
    /// Number of samples per pixel of each of the two path-traced references.
    pub reference_samples: u32,
    /// Result of the comparison of the first finalist with the second one, at equal time.
    pub verdict: Verdict,
    /// The measurements of the candidates in the final, the recommended one first. They come from seeds that
    /// the race did not use.
    pub finalists: Vec<Point>,
    /// The measurements of all candidates in the race, which decided which candidates came into the final.
    /// The race measures its first errors with references that are still noisy. So these errors tend to be
    /// too large, and their intervals do not show this.
    pub race: Vec<Point>,
    /// Time on the host, in seconds, that the race took, without the compilation of shaders.
    pub seconds: f64,
    /// Time on the host, in seconds, that the compilation of shaders took.
    pub compilation_seconds: f64,
}

impl Front {
    /// The measurements of all candidates, one entry per candidate: the finalists first, with their values
    /// from the final, then the others.
    pub fn points(&self) -> Vec<&Point> {
        let is_final = |p: &&Point| self.finalists.iter().any(|f| f.candidate == p.candidate);
        let others = self.race.iter().filter(|point| !is_final(point));
        self.finalists.iter().chain(others).collect()
    }

    /// The measurements of `candidate`, which the caller can change: those of the final, or those of the race
    /// if the candidate was not in the final. `None` if the candidate was not measured.
    pub fn point_of(&mut self, candidate: &Candidate) -> Option<&mut Point> {
        let mut points = self.finalists.iter_mut().chain(&mut self.race);
        points.find(|point| point.candidate == *candidate)
    }

    /// Takes measured times of frames of the wanted size, in milliseconds. The times of the other candidates that are not
    /// measured at that size change by the geometric mean of the factors by which these change.
    pub(super) fn set_times(&mut self, times: &[(&Candidate, f64)]) {
        let mut changes = Vec::new();
        for (candidate, milliseconds) in times {
            if let Some(point) = self.point_of(candidate) {
                changes.push((milliseconds / point.milliseconds).ln());
                point.set_time(*milliseconds);
                point.is_timed = true;
            }
        }
        let change = (changes.iter().sum::<f64>() / changes.len().max(1) as f64).exp();
        let points = self.finalists.iter_mut().chain(&mut self.race);
        for point in points.filter(|point| !point.is_timed) {
            point.set_time(change * point.milliseconds);
        }
    }
}

/// Result of the comparison of the best candidate with its closest competitor. The text of the advice depends
/// on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The first candidate has a smaller error at equal time than all others. No difference is explained by
    /// chance, at a confidence of 95 %.
    Better,
    /// The first two candidates have the same error at equal time, within the accuracy of the measurement. A
    /// frame of the first one takes less time.
    Cheaper,
    /// The first candidate has the smallest error at equal time in this measurement, but its advantage over
    /// the second one may be due to chance.
    Likely,
    /// The error of the best candidate is too uncertain for a recommendation. The value is a factor: the
    /// measurement must take about this many times as long.
    Undecided(f64),
}

/// An estimated number, such as an error, with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Estimated value, for example the error of a candidate (root of the relMSE).
    pub value: f64,
    /// Lower and upper end of the 95 % confidence interval, in the unit of the value; `None` (`null` in JSON)
    /// if it is not known, for example after only one measurement.
    pub interval: Option<[f64; 2]>,
}

impl Measured {
    /// Converts `log`, an estimate of the natural logarithm of a positive number, to an estimate of the
    /// number itself.
    fn of_log(log: Estimate) -> Self {
        let half_width = log.t_interval_half_width(0.95);
        Self {
            value: log.mean.exp(),
            interval: (half_width.is_finite())
                .then(|| [log.mean - half_width, log.mean + half_width].map(f64::exp)),
        }
    }

    fn times(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            interval: self.interval.map(|ends| ends.map(|end| end * factor)),
        }
    }

    /// Half the width of the 95 % confidence interval, in the unit of the value; infinite if the interval is
    /// not known.
    pub fn half_width(&self) -> f64 {
        self.interval
            .map_or(f64::INFINITY, |[low, high]| 0.5 * (high - low))
    }
}

/// The measurements of one candidate in a race: its frame time, error, brightness and bias.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Point {
    /// The candidate (settings with a name) that was measured.
    pub candidate: Candidate,
    /// Number of independent measurements, one per seed, from which the values were computed.
    pub chains: usize,
    /// Time of a frame of the wanted size on the device, in milliseconds.
    pub milliseconds: f64,
    /// True if the frame time was measured at the wanted size; false if it was computed from the time of
    /// smaller frames, in proportion to the number of pixels.
    pub is_timed: bool,
    /// Number of frames per picture with which the errors, measured in small pictures, were corrected to the
    /// wanted size ([`Self::carry_over`]); 0 if the errors are those of the race.
    pub sized_frames: u32,
    /// Factor by which the relMSE of the race was multiplied to correct it from small pictures to the wanted
    /// size; 1 if it was not corrected.
    pub size_factor: f64,
    /// Error (root of the relMSE) of a typical frame or, for [`Purpose::Mean`], of the mean of all frames.
    pub error: Measured,
    /// Median over the lit pixels of a frame of their luminance, divided by that of the reference. It is
    /// small if most pixels are dark.
    pub median: f64,
    /// Bias of the mean radiance of the picture, as a fraction of the reference's mean in its brightest
    /// channel. It is that of the colour channel with a significant bias or, without one, of the channel
    /// whose bias can be largest.
    pub bias: Bias,
    /// Natural logarithm of the relMSE of a typical frame or, for [`Purpose::Mean`], of the mean of all
    /// frames: mean over the seeds, with its standard error.
    pub log_relmse: Estimate,
    /// Largest error (root of the relMSE) that was measured with a single seed. It shows how bad a frame can
    /// be with an unlucky seed.
    pub largest_error: f64,
    /// True if a frame reuses data of earlier frames. Frames without history are independent, so the relMSE
    /// of their mean is inversely proportional to their number.
    pub has_history: bool,
    /// The relMSE of the mean of the first 1, 2, 4, … frames, as the geometric mean over the seeds: entry `i`
    /// is for 2^i frames. Empty if the candidate has history and the purpose is not [`Purpose::Mean`].
    pub of_means: Vec<f64>,
    /// Natural logarithms of the frame times in milliseconds, one per seed, in the order of the measurements.
    /// Values of two candidates with the same index were measured shortly after each other, so they are
    /// compared in pairs.
    pub log_times: Vec<f64>,
}

/// Estimated bias of the mean radiance of a picture, with the half-width of its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// Estimated bias, as a fraction of the mean of the reference; positive if the picture is too bright.
    pub relative: f64,
    /// Half-width of the 95 % confidence interval of the bias, as a fraction of the mean of the reference.
    pub half_width: f64,
}

impl Bias {
    /// The largest magnitude of the bias that the confidence interval contains, as a fraction of the mean of
    /// the reference. The advice prints it as the bound above which no bias was found.
    pub fn bound(&self) -> f64 {
        self.relative.abs() + self.half_width
    }

    /// True if the confidence interval does not contain 0; the advice then warns of a bias.
    pub fn is_found(&self) -> bool {
        self.relative.abs() > self.half_width
    }
}

impl Point {
    /// Computes the summary of a candidate from `chains`, its measurements with one seed each; `truth` has
    /// the references for the bias. Frames count as independent, so the caller must set `has_history` if they
    /// are not. The relMSE is the geometric mean over the seeds. An arithmetic mean would depend on rare
    /// bright pixels, and its confidence interval would often miss the true value.
    pub fn of(candidate: &Candidate, chains: &[Chain], truth: &Truth) -> Self {
        let relmse: Vec<f64> = chains.iter().map(|chain| chain.observed.relmse).collect();
        let times: Vec<f64> = chains.iter().map(|chain| chain.milliseconds.ln()).collect();
        let largest = relmse.iter().copied().fold(0.0, f64::max);
        let relmse = Estimate::of(&logarithms(&relmse));
        let time = times.iter().sum::<f64>() / times.len() as f64;
        let root = Estimate {
            mean: 0.5 * relmse.mean,
            standard_error: 0.5 * relmse.standard_error,
            ..relmse
        };
        let medians = chains.iter().map(|chain| chain.observed.median);
        Self {
            candidate: candidate.clone(),
            chains: chains.len(),
            milliseconds: time.exp(),
            is_timed: true,
            sized_frames: 0,
            size_factor: 1.0,
            error: Measured::of_log(root),
            median: medians.sum::<f64>() / chains.len().max(1) as f64,
            bias: bias(chains, truth),
            log_relmse: relmse,
            largest_error: largest.sqrt(),
            has_history: false,
            of_means: mean_of(chains.iter().map(|chain| chain.of_means.as_slice())),
            log_times: times,
        }
    }

    /// The expected relMSE of the mean of `frames` frames, interpolated between the entries of
    /// [`Self::of_means`]. Less than one frame means a part of its samples; the relMSE is then inversely
    /// proportional to `frames`. For more frames than were measured, the product of relMSE and `frames` still
    /// rises, because frames share their history and long means are more likely to contain a rare bright
    /// pixel; the rise is assumed to halve with each doubling of `frames`. If fewer than three means were
    /// measured, the result is computed from the relMSE of a single frame: unchanged with history, divided by
    /// `frames` without.
    pub fn relmse_after(&self, frames: f64) -> f64 {
        let [first, .., before, last] = *self.of_means.as_slice() else {
            let single = self.log_relmse.mean.exp();
            return if self.has_history {
                single
            } else {
                single / frames
            };
        };
        if frames < 1.0 {
            return first / frames;
        }
        let doublings = frames.log2();
        let measured = self.of_means.len() - 1;
        if doublings < measured as f64 {
            let index = doublings as usize;
            let [a, b] =
                [self.of_means[index], self.of_means[index + 1]].map(|v| v.max(1e-12).ln());
            return (a + (b - a) * doublings.fract()).exp();
        }
        let rise = (2.0 * last / before).max(1.0).ln();
        let further = doublings - measured as f64;
        last * (rise * (1.0 - (-further).exp2()) - further * 2f64.ln()).exp()
    }

    /// Replaces the frame time by `milliseconds`. All values of [`Self::log_times`], by which candidates are
    /// compared, are changed by the same factor.
    pub fn set_time(&mut self, milliseconds: f64) {
        let change = (milliseconds / self.milliseconds).ln();
        for time in &mut self.log_times {
            *time += change;
        }
        self.milliseconds = milliseconds;
    }

    /// Corrects all errors from the small pictures of the race to pictures of the wanted size: multiplies the
    /// relMSE by `factor`, which was measured with `frames` frames per picture. The factor of an earlier call
    /// is replaced.
    pub fn carry_over(&mut self, factor: f64, frames: u32) {
        let change = factor / self.size_factor;
        let root = change.sqrt();
        self.error = self.error.times(root);
        self.largest_error *= root;
        self.log_relmse.mean += change.ln();
        for relmse in &mut self.of_means {
            *relmse *= change;
        }
        (self.size_factor, self.sized_frames) = (factor, frames);
    }

    /// Natural logarithm of relMSE × frame time (in milliseconds), by which candidates are sorted, the
    /// smallest first. It does not change if independent frames are averaged, so it compares errors at equal
    /// time.
    pub fn log_cost(&self) -> f64 {
        let times = self.log_times.iter().sum::<f64>() / self.log_times.len() as f64;
        self.log_relmse.mean + times
    }

    /// Natural logarithm of the ratio of this candidate's error to that of `other` at equal time; negative if
    /// this candidate is better. The frame times are compared in pairs that were measured shortly after each
    /// other, so that a disturbance of the machine has no effect.
    pub fn log_error_at_equal_time(&self, other: &Self) -> Estimate {
        let pairs = self.log_times.iter().zip(&other.log_times);
        let time = Estimate::of(&pairs.map(|(own, other)| own - other).collect::<Vec<f64>>());
        let relmse = self.log_relmse.minus(&other.log_relmse);
        Estimate {
            mean: 0.5 * (relmse.mean + time.mean),
            standard_error: 0.5 * relmse.standard_error.hypot(time.standard_error),
            samples: relmse.samples.min(time.samples),
        }
    }

    /// True if so many lit pixels of a frame are dark, compared with the frame of `path_tracing`, that the
    /// candidate must not be recommended, however small its error is.
    pub fn is_empty(&self, path_tracing: &Self) -> bool {
        self.median < LEAST_MEDIAN * path_tracing.median
    }

    /// The error (root of the relMSE) that path tracing has after `milliseconds` of time on the device. If this is
    /// longer or shorter than the time of its frame, the error is that of as many more or fewer samples. `self` must
    /// have the measurements of path tracing.
    pub fn error_in(&self, milliseconds: f64) -> Measured {
        let frames = milliseconds / self.milliseconds;
        let factor = (self.relmse_after(frames) / self.relmse_after(1.0)).sqrt();
        self.error.times(factor)
    }
}

/// Geometric means of lists of equal length, value by value: entry `i` of the result is the mean of the
/// entries `i` of all lists.
fn mean_of<'a>(lists: impl ExactSizeIterator<Item = &'a [f64]> + Clone) -> Vec<f64> {
    let count = lists.len() as f64;
    let length = lists.clone().next().map_or(0, <[f64]>::len);
    let mean = |index: usize| {
        let values: Vec<f64> = lists.clone().map(|list| list[index]).collect();
        (logarithms(&values).iter().sum::<f64>() / count).exp()
    };
    (0..length).map(mean).collect()
}

fn bias(chains: &[Chain], truth: &Truth) -> Bias {
    let largest = truth
        .means()
        .iter()
        .map(|t| t.mean.abs())
        .fold(0.0, f64::max);
    let of_channel = |c: usize| {
        let means: Vec<f64> = chains.iter().map(|chain| chain.observed.mean[c]).collect();
        let difference = Estimate::of(&means).minus(&truth.means()[c]);
        // Three channels are looked at.
        let half_width = difference.t_interval_half_width(1.0 - 0.05 / 3.0);
        Bias {
            relative: difference.mean / largest,
            half_width: half_width / largest,
        }
    };
    [0, 1, 2]
        .map(of_channel)
        .into_iter()
        .max_by(|a, b| {
            let found = a.is_found().cmp(&b.is_found());
            found.then(a.bound().total_cmp(&b.bound()))
        })
        .unwrap_or(Bias {
            relative: 0.0,
            half_width: f64::INFINITY,
        })
}
