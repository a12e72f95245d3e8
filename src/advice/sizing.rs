//! Corrects errors that were measured in small pictures to pictures of the wanted size. A race has no time
//! for large pictures, but their errors differ: edges fill a smaller part of a large picture, and the
//! neighbours of a pixel show points that are closer to each other in the scene.

use super::chain::{Purpose, warm_up};
use super::front::Point;
use super::track::Track;
use super::truth::{Added, Picture, variance};
use crate::render::{Renderer, View};
use crate::{Error, Result};

/// Number of pairs of small pictures, and maximum number of pairs of large ones, from which the ratio of
/// their errors is computed. The two pictures of a pair have different seeds.
const PAIRS: [u32; 2] = [8, 4];
/// Number that is added to the seed of the view to get the first seed of the pictures from which the ratio of
/// the errors is computed. The seeds of a race begin elsewhere.
const SEED: u32 = 7 << 28;

/// Number of frames per picture with which [`carry_over`] can correct the errors of `point`, if the user
/// wants a picture of `frames` frames. It is smaller than `frames` if two such pictures of the wanted size
/// take more than `seconds`, and 0 if even the smallest number takes longer. It should be close to `frames`,
/// because the error of a mean falls with the number of frames at another rate in small pictures.
pub fn frames_for(point: &Point, purpose: Purpose, frames: u32, seconds: f64) -> u32 {
    let affordable = (1e3 * seconds / (2.0 * point.milliseconds)) as u32;
    match purpose {
        Purpose::Mean if affordable > 0 => 1 << frames.clamp(1, affordable).ilog2(),
        purpose if affordable >= purpose.frames() => purpose.frames(),
        _ => 0,
    }
}

/// Corrects the errors of `point`, which the race measured in pictures of `size` (width, height) in pixels,
/// to the wanted size: multiplies them by the ratio of the error in large pictures to that in small ones. The
/// relMSE at each size is half of the mean squared relative difference of two independent pictures. For
/// [`Purpose::Mean`], a picture is the mean of `frames` frames, and otherwise the last of `frames` frames.
/// The large pictures take about `seconds`. `check` is called after each frame; an error from it ends the
/// work.
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

/// Renders `frames` frames with the seed `seed`, and returns one linear RGB picture: their mean for
/// [`Purpose::Mean`], and otherwise the last frame. `check` is called after each frame; an error from it ends
/// the work.
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
