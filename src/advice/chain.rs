//! A chain: the frames that one candidate renders with one seed. Frames of a chain depend on each other, so a chain is one
//! independent observation.

use super::truth::{Added, Observed, Picture, Truth};
use crate::Result;
use crate::gpu::PassTime;
use crate::metrics::statistics::{Estimate, median};
use crate::render::{Clock, Renderer};
use crate::scene::{Camera, MovingCamera};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// The purpose of an advice, which decides which frames are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Purpose {
    /// A single frame without history
    Still,
    /// A late frame of a camera at rest
    Steady,
    /// A late frame of a camera that moves; it moves sideways where the scene's own camera does not move
    Motion,
    /// The mean of all frames of a camera at rest
    Mean,
}

impl Purpose {
    /// The number of frames of a chain, which is the frames that one candidate renders with one seed, one after the other.
    pub const fn frames(self) -> u32 {
        match self {
            Self::Still => 1,
            Self::Steady => 16,
            Self::Motion => 8,
            // Longer than the history that frames share, so that the errors of longer means follow from this one.
            Self::Mean => 64,
        }
    }

    /// The indices of the frames that are measured. Those of a camera at rest show the same, so several count.
    pub(super) fn is_measured(self, frame: u32) -> bool {
        match self {
            Self::Still | Self::Motion => frame + 1 == self.frames(),
            Self::Steady => frame >= self.frames() / 2,
            Self::Mean => true,
        }
    }
}

/// The number of frames that a candidate without history renders for [`Purpose::Mean`]: its frames are independent, so the
/// error of their mean follows from that of one.
const INDEPENDENT_FRAMES: u32 = 8;

/// The motion of the camera and of the scene in the frames of a chain.
pub struct Course {
    /// The purpose of the advice.
    pub purpose: Purpose,
    /// The clock of the scene, if something in it moves and the purpose is motion.
    pub clock: Option<Clock>,
    /// The camera of the scene, if it moves by itself.
    pub camera: Option<MovingCamera>,
    /// The camera of the view, and the distance in scene units by which it moves to its right in each frame; it arrives at the
    /// view in the last frame. The distance is 0 if it does not move.
    pub view: (Camera, f64),
}

impl Course {
    /// Sets the time and the camera of a frame.
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

/// The measurements of one chain.
#[derive(Clone, Debug)]
pub struct Chain {
    /// The mean over the measured frames (of the relMSE: the geometric mean) or, for [`Purpose::Mean`], the measurements of the
    /// mean of all frames.
    pub observed: Observed,
    /// The relMSE of the mean of the first 1, 2, 4 … measured frames, for [`Purpose::Mean`] and for candidates without history.
    /// Otherwise empty.
    pub of_means: Vec<f64>,
    /// The median time of a frame on the device, in milliseconds.
    pub milliseconds: f64,
}

/// Receives the frames of chains.
pub trait Observer {
    /// Receives the frame with the index `index`: the times of its passes, and its linear RGB radiance, row by row.
    fn frame(&mut self, index: u32, passes: &[PassTime], picture: &[[f32; 3]], truth: &Truth);
}

/// Renders one chain, and returns it with the mean of its measured frames. A renderer without history renders these frames
/// alone. All passes must have run before ([`warm_up`]), so that no time contains compilation.
/// The observer also receives frames that are not measured.
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

/// Renders the first frames of a chain, so that all passes are compiled. Returns the time that the compilation took.
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

/// The seed of frames that only compile. No chain has it.
const WARM_UP_SEED: u32 = u32::MAX;

/// The time of a late frame on the device, in milliseconds: the smaller one of two. All passes must have run before.
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

/// The logarithms of several measurements of one relMSE. The noise of the references can make one of them almost zero, or
/// negative, if the picture is almost perfect. It then counts as a tenth of the median. A picture with a value that is not a
/// number is infinitely wrong.
pub fn logarithms(relmse: &[f64]) -> Vec<f64> {
    let least = (0.1 * median(relmse.iter().copied())).max(1e-12);
    let logarithm = |value: &f64| match value.is_nan() {
        true => f64::INFINITY,
        false => value.max(least).ln(),
    };
    relmse.iter().map(logarithm).collect()
}
