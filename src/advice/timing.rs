//! The times of frames of the wanted size, which replace those of the smaller frames of a race.

use super::candidates::Candidate;
use super::chain;
use super::front::Front;
use super::track::{Time, Track};
use crate::Result;
use std::time::{Duration, Instant};

/// The number of rounds in which frames are timed.
const TIMING_ROUNDS: u32 = 3;

/// Replaces the times, which were measured at the smaller size, by times of the wanted size. They follow from the number of
/// pixels. Those of the finalists are measured if there is time for a few frames.
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

/// Measures the times of frames of the wanted size: the least one of each candidate, in rounds, so that a disturbance of the
/// machine is not taken for a difference. The times that are not measured yet change by the mean factor of those that are:
/// small frames leave a GPU idle, so times do not grow with the number of pixels. Returns the time that the compilation took.
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
