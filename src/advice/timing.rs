//! Measures the times of frames of the wanted size, which replace the times of the smaller frames of a race.

use super::candidates::Candidate;
use super::chain;
use super::front::Front;
use super::track::{Time, Track};
use crate::Result;
use std::time::{Duration, Instant};

/// Number of rounds in which frames are timed. Each round times every candidate once, and the shortest time
/// of a candidate counts.
const TIMING_ROUNDS: u32 = 3;

/// Replaces the frame times of all candidates in `front`, which were measured in small pictures, by times for
/// the wanted size. They are computed in proportion to the number of pixels. The finalists are timed at this
/// size if `time` is sufficient for a few frames, and the times of the others change with theirs.
pub(super) fn scale(front: &mut Front, track: &Track<'_>, time: &mut Time) -> Result<()> {
    let pixels = |(width, height): (u32, u32)| f64::from(width) * f64::from(height);
    let factor = pixels(front.wanted_size) / pixels(front.size);
    for point in front.finalists.iter_mut().chain(&mut front.race) {
        point.set_time(factor * point.milliseconds);
        point.is_timed = false;
    }
    // Three frames of each are rendered to compile, and two in each round to time.
    let frames: f64 = front.finalists.iter().map(|p| p.milliseconds * 1e-3).sum();
    if time.is_past(1.0, f64::from(3 + 2 * TIMING_ROUNDS) * frames) {
        return Ok(());
    }
    let finalists: Vec<Candidate> = front
        .finalists
        .iter()
        .map(|point| point.candidate.clone())
        .collect();
    time.compilation += measure(front, &finalists, track)?;
    Ok(())
}

/// Measures the frame times of `candidates` at the wanted size, and stores them in `front`. The candidates are
/// timed in turns over several rounds, and the shortest time counts, so that a disturbance of the machine does
/// not look like a difference between candidates. The times that are not measured yet change by the mean factor
/// of those that are: a small frame leaves a GPU idle, so times do not grow in proportion to the number of
/// pixels. Returns the time that the compilation took.
///
/// # Errors
/// The device fails, or the scene cannot be rendered at the time of a frame.
pub fn measure(front: &mut Front, candidates: &[Candidate], track: &Track<'_>) -> Result<Duration> {
    let mut compilation = Duration::ZERO;
    let mut timed = Vec::new();
    for candidate in candidates {
        let start = Instant::now();
        let mut renderer = track.renderer(track.view, candidate)?;
        compilation += start.elapsed() + chain::warm_up(&mut renderer, track.course)?;
        timed.push((candidate, renderer, f64::INFINITY));
    }
    for _ in 0..TIMING_ROUNDS {
        for (_, renderer, least) in &mut timed {
            *least = least.min(chain::time(renderer, track.course)?);
        }
    }
    let times = timed.into_iter().map(|(candidate, _, ms)| (candidate, ms));
    front.set_times(&times.collect::<Vec<_>>());
    Ok(compilation)
}
