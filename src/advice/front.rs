//! The measurements of a race: for each candidate, the time of a frame and its error. A front can be stored, and a choice
//! made from it later.

use super::candidates::Candidate;
use super::chain::{Chain, Purpose, logarithms};
use super::truth::Truth;
use crate::metrics::statistics::Estimate;
use serde::{Deserialize, Serialize};

/// The smallest median brightness of a candidate's frame, as a fraction of that of a path-traced frame. The median is that
/// of the lit pixels, each divided by the reference. A candidate below this limit is not advised: a picture whose pixels
/// are mostly dark can have a small error, because it is clean, but it is empty.
const LEAST_MEDIAN: f64 = 0.5;

/// The measured candidates of one scene, view and device.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Front {
    /// The purpose, which decided which frames were measured.
    pub purpose: Purpose,
    /// The width and the height of the measured frames, in pixels.
    pub size: (u32, u32),
    /// The width and the height that the user wants; the times hold for them.
    pub wanted_size: (u32, u32),
    /// The number of samples per pixel of each of the two references.
    pub reference_samples: u32,
    /// The relation of the first finalist to the second one.
    pub verdict: Verdict,
    /// The points of the final, whose seeds the race did not use, the advised one first.
    pub finalists: Vec<Point>,
    /// The points of all candidates in the race. They decided who came into the final. The first references of the race are
    /// noisy, so these errors tend to be too large, and their intervals do not show this.
    pub race: Vec<Point>,
    /// The seconds that were spent on rendering and loading.
    pub seconds: f64,
    /// The seconds that were spent on the compilation of shaders.
    pub compilation_seconds: f64,
}

impl Front {
    /// The points of all candidates, the finalists first.
    pub fn points(&self) -> Vec<&Point> {
        let is_final = |p: &&Point| self.finalists.iter().any(|f| f.candidate == p.candidate);
        let others = self.race.iter().filter(|point| !is_final(point));
        self.finalists.iter().chain(others).collect()
    }

    /// The point of a candidate, that of the final if it has one.
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

/// The relation of the best candidate to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The first point is better at equal time.
    Better,
    /// The first two points cannot be told apart at equal time, and the first one is cheaper.
    Cheaper,
    /// The first point has the smaller error at equal time in this measurement, but compared with the second one it may be
    /// chance.
    Likely,
    /// Too little is known. The measurement must take about so many times as long.
    Undecided(f64),
}

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The estimate.
    pub value: f64,
    /// The lower and the upper end of the interval; null if it is not known.
    pub interval: Option<[f64; 2]>,
}

impl Measured {
    /// The estimate `log` of the logarithm of a positive number, as that number.
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

    /// Half the width of the interval; infinite if it is not known.
    pub fn half_width(&self) -> f64 {
        self.interval
            .map_or(f64::INFINITY, |[low, high]| 0.5 * (high - low))
    }
}

/// The measurements of one candidate.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Point {
    /// The candidate.
    pub candidate: Candidate,
    /// The number of independent chains.
    pub chains: usize,
    /// The time of a frame on the device, in milliseconds, at the wanted size.
    pub milliseconds: f64,
    /// True if the time was measured at the wanted size, and does not follow from that of smaller frames.
    pub is_timed: bool,
    /// The number of frames with which the errors were carried over from small pictures to those of the wanted size; 0 if
    /// they are those of the race.
    pub sized_frames: u32,
    /// The factor by which the relMSE was multiplied for this; 1 without.
    pub size_factor: f64,
    /// The error of a typical frame, or of the mean of all frames for [`Purpose::Mean`]: the root of its relMSE.
    pub error: Measured,
    /// The median over the lit pixels of a frame, divided by the references.
    pub median: f64,
    /// The bias of the mean of the picture, as a fraction of the reference: in the channel where it is found, or else in the
    /// one where it can be largest.
    pub bias: Bias,
    /// The logarithm of the relMSE of a typical frame, with its standard error.
    pub log_relmse: Estimate,
    /// The error of the chain with the largest one.
    pub largest_error: f64,
    /// True if a frame depends on those before it. Frames without history are independent.
    pub has_history: bool,
    /// The relMSE of the mean of the first 1, 2, 4 … frames, for [`Purpose::Mean`] and for candidates without history.
    /// Otherwise empty.
    pub of_means: Vec<f64>,
    /// The logarithms of the frame times of the chains, in the order in which they took turns with those of other candidates.
    pub log_times: Vec<f64>,
}

/// A bias, with the half-width of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// The bias.
    pub relative: f64,
    /// The half-width of the interval.
    pub half_width: f64,
}

impl Bias {
    /// The largest bias that the interval contains.
    pub fn bound(&self) -> f64 {
        self.relative.abs() + self.half_width
    }

    /// True if the interval does not contain 0.
    pub fn is_found(&self) -> bool {
        self.relative.abs() > self.half_width
    }
}

impl Point {
    /// Summarises the chains of a candidate whose frames are independent. The relMSE is the geometric mean over the chains.
    /// Rare bright pixels decide the arithmetic mean: in `two-rooms`, intervals of twenty chains contained the value of a
    /// thousand in two cases of three only.
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

    /// The relMSE of the mean of `frames` frames or, with history and unless means were measured, of a single one. A part of a
    /// frame has so much more. More frames than were measured lower it in proportion, except for two effects: frames share
    /// their history, and a mean of more frames is more likely to have one of the rare bright pixels that a typical frame
    /// lacks. So the product of relMSE and frames rises, and its rise is taken to halve with each doubling of the frames.
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

    /// Replaces the time of a frame, in milliseconds. Those of chains, by which candidates are compared, change by the same
    /// factor.
    pub fn set_time(&mut self, milliseconds: f64) {
        let change = (milliseconds / self.milliseconds).ln();
        for time in &mut self.log_times {
            *time += change;
        }
        self.milliseconds = milliseconds;
    }

    /// Multiplies the relMSE of the race by `factor`, which was measured with `frames` frames, so that it is that of pictures
    /// of the wanted size. An earlier factor is replaced.
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

    /// The logarithm of relMSE × time, by which candidates are sorted.
    pub fn log_cost(&self) -> f64 {
        let times = self.log_times.iter().sum::<f64>() / self.log_times.len() as f64;
        self.log_relmse.mean + times
    }

    /// The logarithm of the error at equal time, relative to that of `other`. Chains that took turns are compared in their times,
    /// so that a disturbance of the machine has no effect.
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

    /// True if a frame leaves so many pixels dark that it cannot be advised, however small its error is.
    pub fn is_empty(&self, path_tracing: &Self) -> bool {
        self.median < LEAST_MEDIAN * path_tracing.median
    }

    /// The error that this point, which is path tracing, has in the time `milliseconds`: samples are added up.
    pub fn error_in(&self, milliseconds: f64) -> Measured {
        let frames = milliseconds / self.milliseconds;
        let factor = (self.relmse_after(frames) / self.relmse_after(1.0)).sqrt();
        self.error.times(factor)
    }
}

/// The geometric means of lists of one length, value by value.
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
