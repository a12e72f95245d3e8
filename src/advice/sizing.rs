//! Carries errors that were measured in small pictures over to pictures of the wanted size. The race has no time for large
//! pictures, but their errors differ: edges fill a smaller part of them, and the neighbours of a pixel are nearer in the scene.

use super::chain::{Purpose, warm_up};
use super::front::Point;
use super::track::Track;
use super::truth::{Added, Picture, variance};
use crate::render::{Renderer, View};
use crate::{Error, Result};

/// The number of pairs of small pictures, and the largest number of pairs of large ones.
const PAIRS: [u32; 2] = [8, 4];
/// The number that is added to the seed of the view for these pictures. The race has no such seeds.
const SEED: u32 = 7 << 28;

/// The number of frames with which the errors of `point` can be carried over, if a picture of `frames` frames is wanted: fewer
/// if two such pictures of the wanted size take more than `seconds`, and 0 if even the least number takes longer. The errors
/// of means fall in another way in small pictures, so the number should be near the wanted one.
pub fn frames_for(point: &Point, purpose: Purpose, frames: u32, seconds: f64) -> u32 {
    let affordable = (1e3 * seconds / (2.0 * point.milliseconds)) as u32;
    match purpose {
        Purpose::Mean if affordable > 0 => 1 << frames.clamp(1, affordable).ilog2(),
        purpose if affordable >= purpose.frames() => purpose.frames(),
        _ => 0,
    }
}

/// Multiplies the errors of `point` by the ratio of its error in pictures of the wanted size to that in pictures of `size`, in
/// which the race measured it. Both are measured alike: half of the squared difference of two independent pictures. These are
/// means of `frames` frames or, if the purpose is no mean, the last one of so many. The pictures of the wanted size take about
/// `seconds`. `check` is called after each frame; an error from it ends the work.
///
/// # Errors
/// The device fails, the scene cannot be rendered at the time of a frame, or `check` returns an error.
pub fn carry_over(
    point: &mut Point,
    track: &Track<'_>,
    size: (u32, u32),
    frames: u32,
    seconds: f64,
    check: &mut dyn FnMut() -> Result<()>,
) -> Result<()> {
    let small = View {
        width: size.0,
        height: size.1,
        ..track.view.clone()
    };
    let affordable = 1e3 * seconds / (2.0 * point.milliseconds * f64::from(frames));
    let pairs = [PAIRS[0], (affordable as u32).clamp(1, PAIRS[1])];
    let mut logs = [0.0; 2];
    for ((view, pairs), log) in [&small, track.view].into_iter().zip(pairs).zip(&mut logs) {
        let mut renderer = track.renderer(view, &point.candidate)?;
        warm_up(&mut renderer, track.course)?;
        for pair in 0..pairs {
            let mut picture = |half| {
                let seed = view.seed.wrapping_add(SEED + 2 * pair + half);
                picture(&mut renderer, track, seed, frames, check)
            };
            let pair = [picture(0)?, picture(1)?];
            *log += variance(&pair, &pair).max(1e-12).ln() / f64::from(pairs);
        }
    }
    point.carry_over((logs[1] - logs[0]).exp(), frames);
    Ok(())
}

/// The mean of the first `frames` frames or, if the purpose is no mean, the last one of them.
fn picture(
    renderer: &mut Renderer,
    track: &Track<'_>,
    seed: u32,
    frames: u32,
    check: &mut dyn FnMut() -> Result<()>,
) -> Result<Picture> {
    renderer.restart(seed)?;
    let is_mean = track.course.purpose == Purpose::Mean;
    let mut pictures = Added::default();
    for frame in 0..frames {
        track.course.set(renderer, frame)?;
        renderer.single_frame(frame)?;
        if is_mean || frame + 1 == frames {
            pictures.add(&renderer.frame_radiance()?);
        }
        check()?;
    }
    let mean = pictures.mean();
    mean.ok_or_else(|| Error::failed("no frame was rendered"))
}
