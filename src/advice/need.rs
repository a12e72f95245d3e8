//! Chooses settings by the need of the user: the time that a frame may take, or the error that a picture may
//! have.

use super::candidates::Candidate;
use super::chain::Purpose;
use super::front::{Front, Point};
use crate::{Error, Result};

/// The requirement of the user, by which settings are chosen from measured candidates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Need {
    /// The maximum time of a frame on the device, in milliseconds.
    Milliseconds(f64),
    /// The maximum relMSE of the picture that is written.
    RelMse(f64),
}

/// Maximum number of frames that is computed for a choice. An error that needs more frames counts as not met.
pub const MOST_FRAMES: u32 = 1 << 20;

/// The settings and the number of frames that meet the user's need or, if none do, come nearest to it.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The chosen settings, as a candidate with a name.
    pub candidate: Candidate,
    /// Number of frames to render one after the other, at least 1.
    pub frames: u32,
    /// True if the picture is the mean of all frames; false if it is the last frame.
    pub accumulates: bool,
    /// Expected time on the device, in milliseconds. It is the time of one frame, unless several short frames
    /// are averaged in the time that one frame may take; it is then the time of all these frames together.
    pub milliseconds: f64,
    /// Number of frames to which the expected time in `milliseconds` applies together. It is 1, unless
    /// several short frames are averaged in the time that one frame may take.
    pub shares: u32,
    /// Expected relMSE of the picture that is written.
    pub relmse: f64,
    /// True if the measurements predict that the choice meets the user's need; false if it only comes nearest
    /// to it.
    pub is_met: bool,
}

impl Choice {
    /// Expected time on the device of each frame that is rendered, in milliseconds.
    pub fn milliseconds_per_frame(&self) -> f64 {
        self.milliseconds / f64::from(self.shares)
    }
}

/// Chooses the settings that meet `need` best from the measured candidates in `front`. Candidates for which
/// `is_allowed` returns false are left out, and so are those with empty pictures ([`Point::is_empty`]).
/// `frames` is the number of frames if the user has fixed it, and otherwise `None`.
///
/// For a maximum time, the settings with the smallest relMSE are chosen. Frames without history are
/// independent, so several of them may be averaged in the time that one frame may take. For a maximum error,
/// the settings that need the shortest time for the whole picture are chosen.
///
/// # Errors
/// All allowed candidates have empty pictures, or none is allowed.
pub fn choose(
    front: &Front,
    need: Need,
    frames: Option<u32>,
    is_allowed: impl Fn(&Candidate) -> bool,
) -> Result<Choice> {
    let points = front.points();
    let yardstick = points
        .iter()
        .find(|p| p.candidate.is_path_tracing().unwrap_or(false));
    let mut choices = Vec::new();
    for point in points.iter().copied() {
        if is_allowed(&point.candidate) && !yardstick.is_some_and(|y| point.is_empty(y)) {
            choices.push(choice_of(front.purpose, point, need, frames));
        }
    }
    let cost = |choice: &Choice| {
        let whole = choice.milliseconds * f64::from(choice.frames);
        match need {
            // The cheapest comes nearest to a time that nothing meets.
            Need::Milliseconds(_) if choice.is_met => choice.relmse,
            Need::Milliseconds(_) => choice.milliseconds,
            Need::RelMse(_) if choice.is_met => whole,
            Need::RelMse(_) => choice.relmse,
        }
    };
    choices
        .into_iter()
        .min_by(|a, b| (b.is_met.cmp(&a.is_met)).then(cost(a).total_cmp(&cost(b))))
        .ok_or_else(|| Error::failed("no candidate has a picture that is not empty"))
}

/// Computes how one candidate meets the need best: the number of its frames, their time, and the relMSE.
/// `bound` is the number of frames if the user has fixed it, and otherwise `None`.
fn choice_of(purpose: Purpose, point: &Point, need: Need, bound: Option<u32>) -> Choice {
    let is_mean = purpose == Purpose::Mean;
    let mut choice = Choice {
        candidate: point.candidate.clone(),
        frames: bound.unwrap_or(purpose.frames()),
        accumulates: is_mean,
        milliseconds: point.milliseconds,
        shares: 1,
        relmse: match is_mean {
            true => point.relmse_after(f64::from(bound.unwrap_or(purpose.frames()))),
            false => point.log_relmse.mean.exp(),
        },
        is_met: false,
    };
    match need {
        Need::Milliseconds(most) => {
            let independent = most / point.milliseconds;
            // With history, a frame is taken as a whole; where means are asked for, all candidates have as many frames.
            if bound.is_none() && purpose == Purpose::Steady && !point.has_history {
                let frames = (independent as u32).clamp(1, MOST_FRAMES);
                choice.frames = frames;
                choice.accumulates = frames > 1;
                choice.milliseconds *= f64::from(frames);
                choice.shares = frames;
                choice.relmse = point.relmse_after(f64::from(frames));
            }
            choice.is_met = choice.milliseconds <= most;
        }
        Need::RelMse(most) => {
            if is_mean && bound.is_none() {
                choice.frames = frames_for(point, most);
                choice.relmse = point.relmse_after(f64::from(choice.frames));
            }
            choice.is_met = choice.relmse <= most;
        }
    }
    choice
}

/// Smallest number of frames whose mean is expected to have at most the relMSE `relmse`; [`MOST_FRAMES`] if
/// even more frames would be needed.
fn frames_for(point: &Point, relmse: f64) -> u32 {
    let (mut low, mut high) = (0, MOST_FRAMES);
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        match point.relmse_after(f64::from(middle)) <= relmse {
            true => high = middle,
            false => low = middle,
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::advice::candidates;
    use crate::advice::chain::Chain;
    use crate::advice::front::Verdict;
    use crate::advice::sizing;
    use crate::advice::truth::{Observed, Truth};

    /// A candidate measured with two seeds, which have equal results. `of_means` has the relMSE of the mean
    /// of the first 1, 2, 4, … frames. The relMSE of the candidate is the first of these values without
    /// history, and the last one with history.
    fn point(name: &str, milliseconds: f64, of_means: &[f64], has_history: bool) -> Point {
        let truth = Truth::new([vec![[1.0; 3]], vec![[1.0; 3]]], &[vec![], vec![]], 4);
        let chain = Chain {
            observed: Observed {
                relmse: of_means[if has_history { of_means.len() - 1 } else { 0 }],
                median: 1.0,
                mean: [1.0; 3],
            },
            of_means: of_means.to_vec(),
            milliseconds,
        };
        let mut candidate = candidates::all(Purpose::Mean)
            .unwrap()
            .remove(usize::from(has_history));
        candidate.name = name.to_owned();
        Point {
            has_history,
            ..Point::of(&candidate, &[chain.clone(), chain], &truth)
        }
    }

    fn front(purpose: Purpose, points: Vec<Point>) -> Front {
        Front {
            purpose,
            size: (1, 1),
            wanted_size: (1, 1),
            reference_samples: 4,
            verdict: Verdict::Better,
            finalists: points,
            race: Vec::new(),
            seconds: 1.0,
            compilation_seconds: 0.0,
        }
    }

    #[test]
    fn frames_follow_from_the_error_of_their_mean() {
        let independent = point("a", 10.0, &[0.4, 0.2, 0.1], false);
        assert!((independent.relmse_after(3.0) - 0.4 / 3.0).abs() < 1e-9);
        assert!((independent.relmse_after(40.0) - 0.01).abs() < 1e-9);
        // The product of relMSE and frames goes from 0.1 to 0.15 and 0.18, and so on to at most 0.216.
        let correlated = point("b", 10.0, &[0.1, 0.075, 0.045], true);
        assert!((correlated.relmse_after(4.0) - 0.045).abs() < 1e-9);
        let product = 4096.0 * correlated.relmse_after(4096.0);
        assert!((0.215..0.216).contains(&product), "{product}");

        let front = front(Purpose::Mean, vec![independent, correlated]);
        let of = |relmse, frames| choose(&front, Need::RelMse(relmse), frames, |_| true).unwrap();
        // One frame of the second one is enough, and two of it for the next.
        assert_eq!(
            (
                of(0.1001, None).candidate.name.as_str(),
                of(0.1001, None).frames
            ),
            ("b", 1)
        );
        // 40 and 22 frames.
        let long = of(0.01, None);
        assert!(
            long.is_met && long.accumulates && long.candidate.name == "b",
            "{long:?}"
        );
        assert!(
            long.relmse <= 0.01 && (20..23).contains(&long.frames),
            "{long:?}"
        );
        let bound = of(0.01, Some(2));
        assert!(
            !bound.is_met && bound.frames == 2 && bound.candidate.name == "b",
            "{bound:?}"
        );
    }

    #[test]
    fn the_least_error_within_a_time_is_chosen() {
        let front = front(
            Purpose::Steady,
            vec![
                point("quick", 10.0, &[0.4, 0.2, 0.1], false),
                point("good", 25.0, &[0.1], true),
            ],
        );
        let of = |ms, frames| choose(&front, Need::Milliseconds(ms), frames, |_| true).unwrap();
        assert_eq!(of(30.0, None).candidate.name, "good");
        assert_eq!(
            (of(30.0, None).frames, of(30.0, None).accumulates),
            (16, false)
        );
        // In the time of one frame, two independent frames share it.
        let two = of(24.0, None);
        assert_eq!(
            (two.candidate.name.as_str(), two.frames, two.accumulates),
            ("quick", 2, true)
        );
        assert!(two.is_met && (two.relmse - 0.2).abs() < 1e-9, "{two:?}");
        assert_eq!(of(24.0, Some(5)).frames, 5);
        let unmet = of(1.0, None);
        assert!(
            !unmet.is_met && unmet.candidate.name == "quick",
            "{unmet:?}"
        );
        let bound = choose(&front, Need::Milliseconds(30.5), None, |c| {
            c.name == "quick"
        })
        .unwrap();
        assert_eq!((bound.candidate.name.as_str(), bound.frames), ("quick", 3));
    }

    /// Small frames can take longer than their share, so the first measured time of a large frame corrects the others.
    #[test]
    fn a_measured_time_corrects_those_that_are_not_measured() {
        let mut points = vec![
            point("cheap", 40.0, &[0.4], true),
            point("good", 100.0, &[0.1], true),
        ];
        points[1].candidate = candidates::all(Purpose::Mean).unwrap().remove(2);
        for point in &mut points {
            point.is_timed = false;
        }
        let cheap = points[0].candidate.clone();
        let mut front = front(Purpose::Steady, points);
        let of = |front: &Front| choose(front, Need::Milliseconds(60.0), None, |_| true).unwrap();
        assert_eq!(of(&front).candidate, cheap);
        front.set_times(&[(&cheap, 20.0)]);
        let choice = of(&front);
        assert!((choice.milliseconds - 50.0).abs() < 1e-9, "{choice:?}");
        // A time that is measured stays.
        front.set_times(&[(&choice.candidate, 70.0)]);
        assert_eq!(of(&front).candidate, cheap);
        assert_eq!(of(&front).milliseconds, 20.0);
    }

    #[test]
    fn errors_are_carried_over_with_as_many_frames_as_the_time_allows() {
        let mut point = point("a", 100.0, &[0.4, 0.2, 0.1], false);
        let frames =
            |purpose, wanted, seconds| sizing::frames_for(&point, purpose, wanted, seconds);
        assert_eq!(frames(Purpose::Mean, 5, 10.0), 4);
        assert_eq!(frames(Purpose::Mean, 100, 1.0), 4);
        assert_eq!(frames(Purpose::Mean, 5, 0.1), 0);
        assert_eq!(frames(Purpose::Steady, 16, 3.0), 0);
        assert_eq!(frames(Purpose::Steady, 16, 3.3), 16);
        // A second factor replaces the first one.
        for factor in [4.0, 0.25] {
            point.carry_over(factor, 4);
            assert!((point.relmse_after(2.0) - 0.2 * factor).abs() < 1e-9);
            let error = 0.4f64.sqrt() * factor.sqrt();
            assert!(
                (point.error.value - error).abs() < 1e-9,
                "{:?}",
                point.error
            );
        }
    }
}
