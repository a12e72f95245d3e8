//! Measures the times of frames of the wanted size, which replace the times of the smaller frames of a race.

use super::chain;
use super::front::{Front, Point};
use super::track::{Time, Track};
use crate::Result;
use std::time::{Duration, Instant};

/// Number of rounds in which frames are timed. Each round times every candidate once, and the shortest time
/// of a candidate counts.
const TIMING_ROUNDS: u32 = 3;

/// Replaces the frame times of all candidates in `front`, which were measured in small pictures, by times for
/// the wanted size. The finalists are timed at this size if `time` is sufficient for a few frames. All other
/// times are computed in proportion to the number of pixels.
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
    time.compilation += measure(front.finalists.iter_mut(), track)?;
    Ok(())
}

/// Measures the frame time of each candidate in `points` at the wanted size, and stores it there. The
/// candidates are timed in turns over several rounds, and the shortest time counts, so that a disturbance of
/// the machine does not look like a difference between candidates. Returns the time that the compilation
/// took.
///
/// # Errors
/// The device fails, or the scene cannot be rendered at the time of a frame.
pub fn measure<'p>(
    points: impl Iterator<Item = &'p mut Point>,
    track: &Track<'_>,
) -> Result<Duration> {
    let mut compilation = Duration::ZERO;
    let mut timed = Vec::new();
    for point in points {
        let start = Instant::now();
        let mut renderer = track.renderer(track.view, &point.candidate)?;
        compilation += start.elapsed() + chain::warm_up(&mut renderer, track.course)?;
        timed.push((point, renderer, f64::INFINITY));
    }
    for _ in 0..TIMING_ROUNDS {
        for (_, renderer, least) in &mut timed {
            *least = least.min(chain::time(renderer, track.course)?);
        }
    }
    for (point, _, least) in timed {
        point.set_time(least);
        point.is_timed = true;
    }
    Ok(compilation)
}
