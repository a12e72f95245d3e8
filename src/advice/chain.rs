//! Chains. A chain is the sequence of frames that one candidate renders with one seed. These frames can
//! depend on each other, because a frame reuses data of earlier ones, so a chain counts as one independent
//! observation.

use super::truth::{Added, Observed, Picture, Truth};
use crate::Result;
use crate::gpu::PassTime;
use crate::metrics::statistics::{Estimate, median};
use crate::render::{Clock, Renderer};
use crate::scene::{Camera, MovingCamera};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// Purpose of an advice: the kind of picture that the user wants. It decides how many frames a candidate
/// renders with each seed, and which of them are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Purpose {
    /// A single frame without history: a candidate renders and measures only frame 0 with each seed.
    Still,
    /// A late frame of a camera at rest: the second half of the frames is measured.
    Steady,
    /// A late frame of a moving camera or scene: only the last frame is measured. If the scene's own camera
    /// does not move, the camera of the view can move sideways instead ([`Course::view`]).
    Motion,
    /// The mean of all frames of a camera at rest: this one picture is measured.
    Mean,
}

impl Purpose {
    /// Number of frames in a chain, which is the sequence of frames that one candidate renders with one seed.
    pub const fn frames(self) -> u32 {
        match self {
            Self::Still => 1,
            Self::Steady => 16,
            Self::Motion => 8,
            // Longer than the history that frames share, so that the errors of longer means follow from this one.
            Self::Mean => 64,
        }
    }

    /// True if the frame with the index `frame`, counted from 0 for each seed, is measured. If the camera is
    /// at rest, all frames show the same picture, so several of them are measured.
    pub(super) fn is_measured(self, frame: u32) -> bool {
        match self {
            Self::Still | Self::Motion => frame + 1 == self.frames(),
            Self::Steady => frame >= self.frames() / 2,
            Self::Mean => true,
        }
    }
}

/// Number of frames that a candidate without history renders with each seed for [`Purpose::Mean`]. Its frames
/// are independent, so the relMSE of the mean of [`Purpose::frames`] frames is computed from the relMSE of
/// this shorter mean.
const INDEPENDENT_FRAMES: u32 = 8;

/// The motion of the camera and of the scene in the frames that a candidate renders with one seed, and the
/// purpose of the advice, which decides the number of these frames.
pub struct Course {
    /// Purpose of the advice, which decides how many frames a candidate renders with each seed.
    pub purpose: Purpose,
    /// Time in the scene that each frame shows. `None` if nothing in the scene moves, or if the purpose is
    /// not [`Purpose::Motion`]; the time then does not change.
    pub clock: Option<Clock>,
    /// The animated camera of the scene, which is evaluated at the time of each frame. `None` if the purpose
    /// is not [`Purpose::Motion`], or if this camera does not move during the rendered frames.
    pub camera: Option<MovingCamera>,
    /// The camera of the view, and the distance, in scene units, by which it moves to its right in each
    /// frame. It reaches the position of the view in the last frame. A distance of 0 means that it does not
    /// move sideways.
    pub view: (Camera, f64),
}

impl Course {
    /// Sets the time and the camera of `renderer` to those of the frame with the index `frame`, counted from
    /// 0 for each seed.
    ///
    /// # Errors
    /// The camera of the scene has no direction at that time.
    pub fn set(&self, renderer: &mut Renderer, frame: u32) -> Result<()> {
        if let Some(clock) = self.clock {
            renderer.set_moment(clock.time(frame), self.camera.as_ref())?;
        }
        let (camera, step) = &self.view;
        if *step != 0.0 {
            let mut camera = camera.clone();
            let before = f64::from(self.purpose.frames() - 1 - frame);
            let right = camera.camera_to_world.matrix3.x_axis.normalize_or_zero();
            camera.camera_to_world.translation -= right * (*step * before);
            renderer.set_camera(&camera);
        }
        Ok(())
    }
}

/// The measurements of one chain (the sequence of frames that one candidate renders with one seed).
#[derive(Clone, Debug)]
pub struct Chain {
    /// Error, median brightness and mean radiance of the measured frames. The relMSE is the geometric mean
    /// over these frames; the other values are arithmetic means. For [`Purpose::Mean`], all values are those
    /// of one picture, the mean of all frames.
    pub observed: Observed,
    /// The relMSE of the mean of the first 1, 2, 4, … measured frames: entry `i` is for 2^i frames. Empty if
    /// the candidate has history and the purpose is not [`Purpose::Mean`].
    pub of_means: Vec<f64>,
    /// Median time of a frame on the device, in milliseconds. The first of several frames does not count,
    /// because it has no history and so less work.
    pub milliseconds: f64,
}

/// A receiver of all frames that a candidate renders for a measurement, for example to record them for a
/// page.
pub trait Observer {
    /// Receives the frame with the index `index`, counted from 0 for each seed: the times of its passes, and
    /// its linear RGB radiance, one value per pixel, row by row from the top. `truth` has the references from
    /// which its error can be computed.
    fn frame(&mut self, index: u32, passes: &[PassTime], picture: &[[f32; 3]], truth: &Truth);
}

/// Renders one chain (the sequence of frames that one candidate renders with one seed). Returns its
/// measurements, and the mean picture of its measured frames; `None` if no frame was measured. A renderer
/// without history renders only the measured frames. All passes must have run before ([`warm_up`]), so that
/// no time contains compilation. `observer` receives all rendered frames, even those that are not measured.
///
/// # Errors
/// The device fails, or the scene cannot be rendered at the time of a frame.
pub fn render(
    renderer: &mut Renderer,
    course: &Course,
    seed: u32,
    truth: &Truth,
    mut observer: Option<&mut dyn Observer>,
) -> Result<(Chain, Option<Picture>)> {
    renderer.restart(seed)?;
    let frames = course.purpose.frames();
    let has_history = renderer.has_history();
    let is_mean = course.purpose == Purpose::Mean;
    let mut of_means = Vec::new();
    let (mut observed, mut times) = (Vec::new(), Vec::new());
    let mut pictures = Added::default();
    for frame in 0..frames {
        let is_measured = course.purpose.is_measured(frame);
        if !has_history && (!is_measured || is_mean && frame >= INDEPENDENT_FRAMES) {
            continue;
        }
        course.set(renderer, frame)?;
        let passes = renderer.single_frame(frame)?;
        // The first frame has no history, and so less work than those after it.
        if frame > 0 || frames == 1 {
            times.push(passes.iter().map(|pass| pass.milliseconds).sum());
        }
        if is_measured || observer.is_some() {
            let picture = renderer.frame_radiance()?;
            if let Some(observer) = &mut observer {
                observer.frame(frame, &passes, &picture, truth);
            }
            if is_measured {
                pictures.add(&picture);
            }
            if is_measured && (is_mean || !has_history) {
                let is_due = pictures.count().is_power_of_two();
                if let Some(mean) = pictures.mean().filter(|_| is_due) {
                    let mean = truth.observe(&mean);
                    of_means.push(mean.relmse);
                    if is_mean {
                        observed = vec![mean];
                    }
                }
            }
            if is_measured && !is_mean {
                observed.push(truth.observe(&picture));
            }
        }
    }
    let relmse: Vec<f64> = observed.iter().map(|observed| observed.relmse).collect();
    let mut observed = Observed::mean_of(&observed);
    if !is_mean {
        observed.relmse = Estimate::of(&logarithms(&relmse)).mean.exp();
    }
    if is_mean && !has_history {
        // Independent errors fall with the number of frames.
        observed.relmse *= f64::from(INDEPENDENT_FRAMES) / f64::from(frames);
    }
    let chain = Chain {
        observed,
        of_means,
        milliseconds: median(times.into_iter()),
    };
    Ok((chain, pictures.mean()))
}

/// Renders the first frames of a measurement (at most 3), so that all passes are compiled. Returns an
/// estimate of the time on the host that the compilation took, without the time for rendering.
///
/// # Errors
/// As for [`render`].
pub fn warm_up(renderer: &mut Renderer, course: &Course) -> Result<Duration> {
    renderer.restart(WARM_UP_SEED)?;
    // History is read from the second frame on; the third one has nothing left to compile.
    let frames = course.purpose.frames().min(3);
    let mut times = Vec::new();
    for frame in 0..frames {
        course.set(renderer, frame)?;
        let start = Instant::now();
        renderer.single_frame(frame)?;
        times.push(start.elapsed());
    }
    let (all, last) = (times.iter().sum::<Duration>(), times.last().copied());
    let rendering = last.filter(|_| frames > 1).unwrap_or_default() * frames;
    Ok(all.saturating_sub(rendering))
}

/// Seed of frames that are rendered only to compile or to time passes. No error is measured with this seed.
const WARM_UP_SEED: u32 = u32::MAX;

/// Time on the device of the last frame that a candidate renders with one seed, in milliseconds: the smaller
/// one of two measurements. All passes must have run before, so that the time contains no compilation.
///
/// # Errors
/// As for [`render`].
pub fn time(renderer: &mut Renderer, course: &Course) -> Result<f64> {
    let last = course.purpose.frames() - 1;
    let mut least = f64::INFINITY;
    for _ in 0..2 {
        if last == 0 {
            // A first frame has no history, and runs other passes.
            renderer.restart(WARM_UP_SEED)?;
        }
        course.set(renderer, last)?;
        let passes = renderer.single_frame(last)?;
        least = least.min(passes.iter().map(|pass| pass.milliseconds).sum());
    }
    Ok(least)
}

/// Natural logarithms of several measurements of one relMSE, in the same order. If a picture is almost
/// perfect, the noise of the references can make its relMSE almost 0 or even negative. So a value below a
/// tenth of the median counts as a tenth of the median. A NaN counts as infinity, so that a picture with
/// invalid values is the worst.
pub fn logarithms(relmse: &[f64]) -> Vec<f64> {
    let least = (0.1 * median(relmse.iter().copied())).max(1e-12);
    let logarithm = |value: &f64| match value.is_nan() {
        true => f64::INFINITY,
        false => value.max(least).ln(),
    };
    relmse.iter().map(logarithm).collect()
}
