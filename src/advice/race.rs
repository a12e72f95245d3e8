//! The race: within a given time, references are rendered, then all candidates race, the worse half is left out, then the
//! worse part of the rest, and the final measures the best ones with seeds that the race did not use.

use super::candidates::Candidate;
use super::chain::{self, Chain, Course, Observer};
use super::choice::{compare, decide};
use super::exhibit::{self, Gallery, Recorder};
use super::front::{Front, Point, Verdict};
use super::timing;
use super::track::{Time, Track};
use super::truth::{Added, Picture, Truth};
use crate::base::progress::Watch;
use crate::page::contents::Shared;
use crate::render::{Lighting, Renderer, ResolvedSettings, Tracking, View};
use crate::{Error, Result};
use std::time::Instant;

/// The part of the time until the references end, then the first and the second round of the race, as fractions. The final
/// has the rest, except for what [`TIMING_PART`] takes.
const ENDS: [f64; 3] = [0.15, 0.35, 0.5];
/// The largest part of the time that is spent on timing frames of the wanted size.
const TIMING_PART: f64 = 0.15;
/// The part of the time that is spent on exhibits, where they are wanted. It is taken from the final.
const EXHIBITS_PART: f64 = 0.1;
/// The least number of chains of each candidate in the first round.
const LEAST_CHAINS: u32 = 2;
/// The least number of chains of each finalist. With two, an interval is wider than the number, or by chance far too narrow:
/// the errors of single chains are skewed where bright pixels are rare.
const LEAST_FINAL_CHAINS: u32 = 4;
/// The number of candidates beside path tracing that come into the final because of their error at equal time.
const FINALISTS: usize = 2;
/// A candidate comes into the final too if its error is below this fraction of that of the best one, whatever it costs.
const MUCH_LESS: f64 = 0.85;
/// The numbers that are added to the first seed: for the final, for exhibits, and for the two references. The race has the
/// seeds before.
const FINAL_SEED: u32 = 1 << 30;
const EXHIBITS_SEED: u32 = 3 << 29;
const TRUTH_SEEDS: [u32; 2] = [0x5EED_1000, 0x5EED_2000];
/// The factor that spreads the seed of the view, so that races with different seeds have no seed in common.
const SPREAD: u32 = 0x9E37_79B9;
/// The number of frames of all chains, in units of path-traced frames, that a race of useful length renders. The size of the
/// pictures is chosen by it.
const USEFUL_FRAMES: f64 = 2000.0;
/// The number of pixels of the smallest pictures that a race renders, unless smaller ones are wanted.
const LEAST_PIXELS: f64 = 1300.0;

impl Track<'_> {
    /// Measures the samples that pixels share, with a renderer that stores their origins. `None` if there is none.
    fn shared(
        &self,
        view: &View,
        candidate: &Candidate,
        time: &mut Time,
    ) -> Result<Option<Vec<Shared>>> {
        let settings = candidate.settings()?;
        let mut kinds = vec![Lighting::Direct, Lighting::Indirect];
        kinds.retain(|lighting| settings.has_reservoirs(*lighting, view.bounces));
        if kinds.is_empty() {
            return Ok(Some(Vec::new()));
        }
        let settings = ResolvedSettings::new(&settings, self.scene, view.bounces);
        let tracking = Tracking {
            origins: true,
            ..Tracking::default()
        };
        let compiling = Instant::now();
        // Reservoirs with origins are larger, and may exceed a limit of the device.
        let Ok(mut renderer) =
            Renderer::tracking(self.device, self.scene.clone(), view, &settings, tracking)
        else {
            return Ok(None);
        };
        time.compilation += compiling.elapsed();
        time.compilation += chain::warm_up(&mut renderer, self.course)?;
        let compiling = Instant::now();
        for lighting in &kinds {
            renderer.reservoir_aovs(*lighting)?;
        }
        time.compilation += compiling.elapsed();
        let seed = view.seed.wrapping_mul(SPREAD).wrapping_add(EXHIBITS_SEED);
        exhibit::shared(&mut renderer, self.course, seed, &kinds, view.width).map(Some)
    }
}

/// A candidate in the race, with its renderer and the chains that it has run.
struct Contestant {
    candidate: Candidate,
    renderer: Renderer,
    chains: Vec<Chain>,
    /// The pictures of its chains in the race: those of even turns, and the others.
    pictures: [Added; 2],
    /// Records its chains, if exhibits are wanted.
    recorder: Option<Recorder>,
    /// The time of its last chain, in seconds.
    took: f64,
}

impl Contestant {
    fn run(&mut self, course: &Course, seed: u32, truth: &Truth) -> Result<()> {
        let start = Instant::now();
        let recorder = self.recorder.as_mut().filter(|r| r.wants_more());
        let observer = recorder.map(|r| r as &mut dyn Observer);
        let (chain, picture) = chain::render(&mut self.renderer, course, seed, truth, observer)?;
        if let Some(picture) = picture {
            self.pictures[self.chains.len() % 2].add(&picture);
        }
        self.chains.push(chain);
        self.took = start.elapsed().as_secs_f64();
        Ok(())
    }

    /// The means of the pictures of even and of odd turns.
    fn pair(&self) -> Option<[Picture; 2]> {
        let [even, odd] = &self.pictures;
        Some([even.mean()?, odd.mean()?])
    }

    fn point(&self, truth: &Truth) -> Point {
        Point {
            has_history: self.renderer.has_history(),
            ..Point::of(&self.candidate, &self.chains, truth)
        }
    }
}

/// Measures the candidates within the time `time`; the first candidate is path tracing. Fills `gallery`, if there is one, with
/// their exhibits. `watch` is called with the fraction of the time that has passed; an error from it ends the race.
///
/// # Errors
/// There are no candidates, the device fails, the scene cannot be rendered at the time of a frame, or `watch` returns an
/// error.
pub fn run(
    track: &Track<'_>,
    candidates: &[Candidate],
    mut time: Time,
    gallery: Option<&mut Gallery>,
    watch: &mut Watch<'_>,
) -> Result<Front> {
    let course = track.course;
    let Some(path_tracing) = candidates.first() else {
        return Err(Error::failed("the race has no candidates"));
    };
    let view = small_view(track, path_tracing, &mut time)?;
    let is_small = (view.width, view.height) != (track.view.width, track.view.height);
    let compiling = Instant::now();
    let [mut first, mut second] = [
        track.renderer(&view, path_tracing)?,
        track.renderer(&view, path_tracing)?,
    ];
    let mut contestants = Vec::new();
    for candidate in candidates {
        contestants.push(Contestant {
            candidate: candidate.clone(),
            renderer: track.renderer(&view, candidate)?,
            chains: Vec::new(),
            pictures: Default::default(),
            recorder: (gallery.as_ref())
                .map(|_| Recorder::new(course.purpose, (view.width, view.height))),
            took: 0.0,
        });
    }
    time.compilation += compiling.elapsed();
    for contestant in &mut contestants {
        time.compilation += chain::warm_up(&mut contestant.renderer, course)?;
        watch(0.0)?;
    }

    let first_seed = track.view.seed.wrapping_mul(SPREAD);
    let seeds = TRUTH_SEEDS.map(|seed| first_seed.wrapping_add(seed));
    let (mut truth, reference_samples) =
        truth([&mut first, &mut second], seeds, course, &time, watch)?;
    drop((first, second));
    if truth.means().iter().all(|mean| mean.mean == 0.0) {
        return Err(Error::input(
            "the camera sees no light, so there is nothing to measure; --camera or --look-at sets another",
        ));
    }

    let mut seed = first_seed;
    // Path tracing is the yardstick, and so stays.
    let mut remaining: Vec<usize> = (0..contestants.len()).collect();
    for (round, end) in ENDS[1..].iter().enumerate() {
        let least = if round == 0 { LEAST_CHAINS } else { 0 };
        let mut chosen = Chosen {
            contestants: &mut contestants,
            chosen: &remaining,
        };
        seed = chosen.run(course, seed, least, *end, (&truth, &time), watch)?;
        // Biased settings race only if the user binds the choice to them.
        let mut pairs = Vec::new();
        for contestant in &contestants {
            if contestant.candidate.settings()?.is_unbiased() {
                pairs.extend(contestant.pair());
            }
        }
        truth.join(&pairs);
        let points: Vec<Point> = contestants.iter().map(|c| c.point(&truth)).collect();
        if track.keeps_all {
            continue;
        }
        let mut others = remaining.split_off(1);
        others.sort_by(|a, b| compare(&points[*a], &points[*b], &points[0]));
        let half = others.len().div_ceil(2).max(FINALISTS);
        let kept = if round == 0 { half } else { FINALISTS };
        others.truncate(kept);
        remaining.extend(others);
    }
    let race: Vec<Point> = contestants.iter().map(|c| c.point(&truth)).collect();
    remaining.extend(much_better(&race, &remaining));
    for index in &remaining {
        contestants[*index].chains.clear();
        if let Some(recorder) = &mut contestants[*index].recorder {
            recorder.clear();
        }
    }
    let mut chosen = Chosen {
        contestants: &mut contestants,
        chosen: &remaining,
    };
    let end = if is_small { 1.0 - TIMING_PART } else { 1.0 };
    let final_end = if gallery.is_some() {
        end - EXHIBITS_PART
    } else {
        end
    };
    let seed = first_seed.wrapping_add(FINAL_SEED);
    chosen.run(
        course,
        seed,
        LEAST_FINAL_CHAINS,
        final_end,
        (&truth, &time),
        watch,
    )?;
    let finalists = remaining.iter().map(|i| contestants[*i].point(&truth));
    let mut front = Front {
        purpose: course.purpose,
        size: (view.width, view.height),
        wanted_size: (track.view.width, track.view.height),
        reference_samples,
        verdict: Verdict::Better,
        finalists: finalists.collect(),
        race,
        seconds: 0.0,
        compilation_seconds: 0.0,
    };
    if let Some(gallery) = gallery {
        gallery.reference = truth.reference();
        let others = (0..contestants.len()).filter(|index| !remaining.contains(index));
        let order: Vec<usize> = remaining.iter().copied().chain(others).collect();
        for (rank, index) in order.into_iter().enumerate() {
            let Contestant {
                candidate,
                recorder,
                took,
                ..
            } = &contestants[index];
            let Some(mut exhibit) = recorder.as_ref().and_then(Recorder::exhibit) else {
                continue;
            };
            if rank < remaining.len() || !time.is_past(end, *took) {
                exhibit.shared = track.shared(&view, candidate, &mut time)?;
            }
            gallery.exhibits.push((candidate.clone(), exhibit));
            watch(time.fraction())?;
        }
    }
    drop(contestants);
    if is_small {
        timing::scale(&mut front, track, &mut time)?;
    }
    let yardstick = front.finalists[0].clone();
    front.verdict = decide(&mut front.finalists, &yardstick);
    watch(1.0)?;
    front.seconds = time.passed();
    front.compilation_seconds = time.compilation.as_secs_f64();
    Ok(front)
}

/// The contestants of a round.
struct Chosen<'a> {
    contestants: &'a mut [Contestant],
    /// The indices of those that run.
    chosen: &'a [usize],
}

impl Chosen<'_> {
    /// Lets the contestants run chains in turns until the fraction `end` of the time has passed, but at least `least` chains
    /// each. The first chain has the seed `seed`. Returns the next seed.
    fn run(
        &mut self,
        course: &Course,
        mut seed: u32,
        least: u32,
        end: f64,
        (truth, time): (&Truth, &Time),
        watch: &mut Watch<'_>,
    ) -> Result<u32> {
        let mut turns = 0;
        loop {
            let turn: f64 = self.chosen.iter().map(|i| self.contestants[*i].took).sum();
            if turns >= least && time.is_past(end, turn) {
                return Ok(seed);
            }
            for index in self.chosen {
                self.contestants[*index].run(course, seed, truth)?;
                watch(time.fraction())?;
            }
            turns += 1;
            seed = seed.wrapping_add(1);
        }
    }
}

/// The contestant outside of `remaining` with the smallest error, if it is much smaller than the errors of those:
/// it may be wanted, whatever it costs.
fn much_better(race: &[Point], remaining: &[usize]) -> Option<usize> {
    let error = |index: &usize| race[*index].error.value;
    let best = remaining.iter().map(error).fold(f64::INFINITY, f64::min);
    let others = (0..race.len()).filter(|index| !remaining.contains(index));
    others
        .filter(|index| error(index) < MUCH_LESS * best && !race[*index].is_empty(&race[0]))
        .min_by(|a, b| error(a).total_cmp(&error(b)))
}

/// The view at the largest size at which a race of useful length fits into the time, at most the wanted size.
fn small_view(track: &Track<'_>, path_tracing: &Candidate, time: &mut Time) -> Result<View> {
    let wanted = track.view;
    let aspect = f64::from(wanted.width) / f64::from(wanted.height);
    let sized = |width: f64| {
        // A narrow picture has a width below that of the smallest ones.
        let width = (width as u32).clamp(1, wanted.width);
        let height = (f64::from(width) / aspect).round() as u32;
        View {
            width,
            height: height.clamp(1, wanted.height),
            ..wanted.clone()
        }
    };
    let pixels = |view: &View| f64::from(view.width) * f64::from(view.height);
    let frames = USEFUL_FRAMES * f64::from(track.course.purpose.frames()) / 16.0;
    let mut view = sized((LEAST_PIXELS * aspect).sqrt());
    loop {
        let compiling = Instant::now();
        let mut renderer = track.renderer(&view, path_tracing)?;
        time.compilation += compiling.elapsed();
        time.compilation += chain::warm_up(&mut renderer, track.course)?;
        let seconds = 1e-3 * chain::time(&mut renderer, track.course)?;
        let affordable = pixels(&view) * time.seconds / (frames * seconds.max(1e-9));
        let next = sized((affordable * aspect).sqrt());
        // A GPU is not busy with a small picture, so its time says little about a much larger one.
        if pixels(&next) < 4.0 * pixels(&view) {
            let is_larger = pixels(&next) > pixels(&view);
            return Ok(if is_larger { next } else { view });
        }
        view = sized((pixels(&next).min(64.0 * pixels(&view)) * aspect).sqrt());
    }
}

/// Renders the two references until their part of the time has passed, in turns, so that both have as many samples.
fn truth(
    mut references: [&mut Renderer; 2],
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
        watch(time.fraction())?;
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
