//! The race: within a given time, references are rendered, then all candidates race, the worse half is left out, then the
//! worse half of the rest, and the final measures the best ones anew with seeds that the race did not use.

use super::candidates::Candidate;
use super::chain::{self, Chain, Course};
use super::choice::{Verdict, compare, decide};
use super::front::{Front, Point};
use super::truth::Truth;
use crate::base::progress::Watch;
use crate::device_scene::GpuScene;
use crate::gpu::Device;
use crate::render::{Renderer, View};
use crate::{Error, Result};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The part of the time until the references end, then the first and the second round of the race, as fractions. The final
/// has the rest, except for what [`TIMING_PART`] takes.
const ENDS: [f64; 3] = [0.25, 0.45, 0.6];
/// The largest part of the time that is spent on timing frames of the wanted size.
const TIMING_PART: f64 = 0.15;
/// The number of chains of each candidate in the first round, as far as the time permits.
const FIRST_CHAINS: u32 = 2;
/// The number of finalists beside path tracing.
const FINALISTS: usize = 3;
/// The numbers that are added to the first seed: for the final, and for the two references. The race has the seeds before.
const FINAL_SEED: u32 = 1 << 16;
const TRUTH_SEEDS: [u32; 2] = [0x5EED_1000, 0x5EED_2000];
/// The factor that spreads the seed of the view, so that races with different seeds have no seed in common.
const SPREAD: u32 = 0x9E37_79B9;
/// The number of frames of all chains, in units of path-traced frames, that a race of useful length renders. The size of the
/// pictures is chosen by it.
const USEFUL_FRAMES: f64 = 2000.0;
/// The width of the smallest pictures that a race renders, in pixels.
const LEAST_WIDTH: u32 = 48;

/// What a race needs: the scene on the device, the view, and how the camera moves.
pub struct Track<'a> {
    /// The device.
    pub device: &'a Arc<Device>,
    /// The scene on the device.
    pub scene: &'a Arc<GpuScene>,
    /// The view at the size that the user wants.
    pub view: &'a View,
    /// How the camera and the scene move.
    pub course: &'a Course,
}

/// The time that a race may take. Compilation of shaders does not count.
pub struct Time {
    started: Instant,
    seconds: f64,
    compilation: Duration,
}

impl Time {
    /// Begins to count now.
    pub fn of(seconds: f64) -> Self {
        Self {
            started: Instant::now(),
            seconds,
            compilation: Duration::ZERO,
        }
    }

    /// The seconds that have passed, without compilation.
    fn passed(&self) -> f64 {
        (self.started.elapsed().saturating_sub(self.compilation)).as_secs_f64()
    }

    /// True if the fraction `end` of the time will have passed after work of `more` seconds.
    fn is_past(&self, end: f64, more: f64) -> bool {
        self.passed() + more > end * self.seconds
    }
}

/// A candidate in the race, with its renderer and the chains that it has run.
struct Contestant {
    candidate: Candidate,
    renderer: Renderer,
    chains: Vec<Chain>,
    /// The time of its last chain, in seconds.
    took: f64,
}

impl Contestant {
    fn run(&mut self, course: &Course, seed: u32, truth: &Truth) -> Result<()> {
        let start = Instant::now();
        let chain = chain::render(&mut self.renderer, course, seed, truth)?;
        self.chains.push(chain);
        self.took = start.elapsed().as_secs_f64();
        Ok(())
    }

    fn point(&self, truth: &Truth) -> Point {
        Point::of(&self.candidate, &self.chains, truth)
    }
}

/// Measures the candidates, of which the first one is path tracing, within the time `time`. `watch` is called with the
/// fraction of the time that has passed; an error from it ends the race.
///
/// # Errors
/// The device fails, the scene cannot be rendered at the time of a frame, or `watch` returns an error.
pub fn run(
    track: &Track<'_>,
    candidates: &[Candidate],
    mut time: Time,
    watch: &mut Watch<'_>,
) -> Result<(Front, Verdict)> {
    let course = track.course;
    let view = small_view(track, candidates, &mut time)?;
    let compiling = Instant::now();
    let make = |candidate: &Candidate, seed: u32| -> Result<Renderer> {
        let view = View {
            seed,
            ..view.clone()
        };
        Renderer::new(
            track.device,
            track.scene.clone(),
            &view,
            &candidate.settings()?,
        )
    };
    let Some(path_tracing) = candidates.first() else {
        return Err(Error::failed("the race has no candidates"));
    };
    let first_seed = track.view.seed.wrapping_mul(SPREAD);
    let truth_seeds = TRUTH_SEEDS.map(|seed| first_seed.wrapping_add(seed));
    let mut references = truth_seeds.map(|seed| make(path_tracing, seed));
    let mut contestants = Vec::new();
    for candidate in candidates {
        contestants.push(Contestant {
            candidate: candidate.clone(),
            renderer: make(candidate, 0)?,
            chains: Vec::new(),
            took: 0.0,
        });
    }
    for contestant in &mut contestants {
        contestant.took =
            chain::warm_up(&mut contestant.renderer, course)? * f64::from(course.purpose.frames());
        watch(0.0)?;
    }
    time.compilation += compiling.elapsed();

    let [first, second] = &mut references;
    let mut both = [
        first.as_mut().map_err(clone)?,
        second.as_mut().map_err(clone)?,
    ];
    let (truth, reference_samples) = truth(&mut both, truth_seeds, course, &time, watch)?;
    let progress =
        |time: &Time, watch: &mut Watch<'_>| watch((time.passed() / time.seconds).min(1.0));

    let mut seed = first_seed;
    let mut remaining: Vec<usize> = (0..contestants.len()).collect();
    for end in &ENDS[1..] {
        let mut turns = 0;
        loop {
            let turn: f64 = remaining.iter().map(|i| contestants[*i].took).sum();
            let enough = turns >= FIRST_CHAINS || contestants[remaining[0]].chains.len() > 1;
            if enough && time.is_past(*end, turn) || turns > 0 && time.is_past(1.0, turn) {
                break;
            }
            for index in &remaining {
                contestants[*index].run(course, seed, &truth)?;
                progress(&time, watch)?;
            }
            (turns, seed) = (turns + 1, seed.wrapping_add(1));
        }
        // Path tracing is the yardstick, and so stays.
        let points: Vec<Point> = contestants.iter().map(|c| c.point(&truth)).collect();
        let mut others: Vec<usize> = remaining.iter().copied().filter(|i| *i > 0).collect();
        others.sort_by(|a, b| compare(&points[*a], &points[*b], &points[0]));
        others.truncate(others.len().div_ceil(2).max(FINALISTS.min(others.len())));
        remaining = std::iter::once(0).chain(others).collect();
    }
    let race: Vec<Point> = contestants.iter().map(|c| c.point(&truth)).collect();
    remaining.truncate(1 + FINALISTS);

    for index in &remaining {
        contestants[*index].chains.clear();
    }
    let mut turns = 0;
    loop {
        let seed = first_seed.wrapping_add(FINAL_SEED + turns);
        let turn: f64 = remaining.iter().map(|i| contestants[*i].took).sum();
        if turns >= FIRST_CHAINS && time.is_past(1.0 - TIMING_PART, turn) {
            break;
        }
        for index in &remaining {
            contestants[*index].run(course, seed, &truth)?;
            progress(&time, watch)?;
        }
        turns += 1;
    }
    let mut finalists: Vec<Point> = (remaining.iter())
        .map(|i| contestants[*i].point(&truth))
        .collect();
    let yardstick = finalists[0].clone();
    let verdict = decide(&mut finalists, &yardstick);
    drop((contestants, references));
    let mut front = Front {
        purpose: course.purpose,
        size: (view.width, view.height),
        wanted_size: (track.view.width, track.view.height),
        timed_at_wanted_size: true,
        reference_samples,
        finalists,
        race,
        seconds: 0.0,
        compilation_seconds: 0.0,
    };
    if front.size != front.wanted_size {
        scale_times(&mut front, track, &mut time)?;
    }
    watch(1.0)?;
    front.seconds = time.passed();
    front.compilation_seconds = time.compilation.as_secs_f64();
    Ok((front, verdict))
}

fn clone(error: &mut Error) -> Error {
    Error::failed(error.to_string())
}

/// The view at the largest size at which a race of useful length fits into the time, at most the wanted size.
fn small_view(track: &Track<'_>, candidates: &[Candidate], time: &mut Time) -> Result<View> {
    let wanted = track.view;
    let sized = |width: u32| {
        let height = f64::from(width) * f64::from(wanted.height) / f64::from(wanted.width);
        View {
            width,
            height: (height.round() as u32).max(1),
            ..wanted.clone()
        }
    };
    let least = sized(LEAST_WIDTH.min(wanted.width));
    let Some(path_tracing) = candidates.first() else {
        return Ok(least);
    };
    let compiling = Instant::now();
    let settings = path_tracing.settings()?;
    let mut renderer = Renderer::new(track.device, track.scene.clone(), &least, &settings)?;
    let frame = chain::warm_up(&mut renderer, track.course)?;
    time.compilation += compiling.elapsed();
    let pixels = f64::from(least.width) * f64::from(least.height);
    let frames = USEFUL_FRAMES * f64::from(track.course.purpose.frames()) / 16.0;
    let affordable = time.seconds * pixels / (frames * frame.max(1e-9));
    let aspect = f64::from(wanted.width) / f64::from(wanted.height);
    let width = ((affordable * aspect).sqrt() as u32).clamp(least.width, wanted.width);
    Ok(sized(width))
}

/// Renders the two references until their part of the time has passed, in turns, so that both have as many samples.
fn truth(
    references: &mut [&mut Renderer; 2],
    seeds: [u32; 2],
    course: &Course,
    time: &Time,
    watch: &mut Watch<'_>,
) -> Result<(Truth, u32)> {
    let last = course.purpose.frames() - 1;
    let (mut samples, mut turn) = (0, 0.0);
    let mut at_once = 2;
    loop {
        let start = Instant::now();
        for (reference, seed) in references.iter_mut().zip(seeds) {
            if samples == 0 {
                reference.restart(seed)?;
            }
            course.set(reference, last)?;
            reference.add_samples(samples, at_once)?;
        }
        samples += at_once;
        turn = f64::max(turn, start.elapsed().as_secs_f64());
        watch((time.passed() / time.seconds).min(1.0))?;
        if samples >= 8 && time.is_past(ENDS[0], turn) {
            break;
        }
        // Long submissions would overrun the time.
        if turn < 0.02 * time.seconds {
            at_once = (2 * at_once).min(64);
            turn *= 2.0;
        }
    }
    let in_f32 = |values: Vec<glam::DVec3>| -> Vec<[f32; 3]> {
        values.iter().map(|v| v.as_vec3().to_array()).collect()
    };
    let [first, second] = [&references[0], &references[1]].map(|r| r.sums());
    let (first, second) = (first?, second?);
    let halves = [&first, &second].map(|sums| in_f32(sums.mean(samples)));
    let errors = [&first, &second].map(|sums| in_f32(sums.standard_error(samples)));
    Ok((Truth::new(halves, &errors, samples), samples))
}

/// Replaces the times of the finalists, which were measured at the smaller size, by times of the wanted size: measured ones
/// if there is time for a few frames, otherwise those that follow from the number of pixels.
fn scale_times(front: &mut Front, track: &Track<'_>, time: &mut Time) -> Result<()> {
    let pixels = |(width, height): (u32, u32)| f64::from(width) * f64::from(height);
    let factor = pixels(front.wanted_size) / pixels(front.size);
    for point in front.finalists.iter_mut().chain(&mut front.race) {
        point.milliseconds *= factor;
    }
    // Path tracing and the advised one: three frames of each to compile, and two to time.
    let measured: f64 = front.finalists.iter().map(|p| p.milliseconds * 1e-3).sum();
    if time.passed() + 5.0 * measured > time.seconds {
        front.timed_at_wanted_size = false;
        return Ok(());
    }
    for point in &mut front.finalists {
        let compiling = Instant::now();
        let settings = point.candidate.settings()?;
        let mut renderer = Renderer::new(track.device, track.scene.clone(), track.view, &settings)?;
        let frame = chain::warm_up(&mut renderer, track.course)?;
        let rendering = Duration::try_from_secs_f64(3.0 * frame).unwrap_or_default();
        time.compilation += compiling.elapsed().saturating_sub(rendering);
        point.milliseconds = chain::time(&mut renderer, track.course)?;
    }
    Ok(())
}
