//! The race measures candidates within a given time. First, two references are rendered. Then all candidates
//! run chains of frames. The worse half is left out, and after a second round all but the best few. The final
//! measures these with seeds that the race did not use.

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

/// Fractions of the total time at which the references, the first round and the second round end. The final
/// has the rest, without the parts for [`TIMING_PART`] and [`EXHIBITS_PART`].
const ENDS: [f64; 3] = [0.15, 0.35, 0.5];
/// Largest fraction of the total time that is spent on timing frames of the wanted size, if the race renders
/// smaller pictures.
const TIMING_PART: f64 = 0.15;
/// Fraction of the total time that is spent on exhibits (pictures and further numbers for a page), if they
/// are wanted. The final is shorter by this time.
const EXHIBITS_PART: f64 = 0.1;
/// Minimum number of chains (sequences of frames with one seed) that each candidate runs in the first round
/// of the race, even if this exceeds the time.
const LEAST_CHAINS: u32 = 2;
/// Minimum number of chains (sequences of frames with one seed) that each finalist runs in the final, even if
/// this exceeds the time. With only two chains, a confidence interval is wider than the error itself or, by
/// chance, far too narrow, because the errors of single chains have a skewed distribution where bright pixels
/// are rare.
const LEAST_FINAL_CHAINS: u32 = 4;
/// Number of candidates, in addition to path tracing, that come into the final because they have the smallest
/// error at equal time.
const FINALISTS: usize = 2;
/// A candidate also comes into the final, however slow it is, if its error is below this fraction of the
/// smallest error of the other finalists.
const MUCH_LESS: f64 = 0.85;
/// Numbers that are added to the first seed of the race, so that the final (`FINAL_SEED`), the exhibits and
/// the two references have other seeds than the race.
const FINAL_SEED: u32 = 1 << 30;
const EXHIBITS_SEED: u32 = 3 << 29;
const TRUTH_SEEDS: [u32; 2] = [0x5EED_1000, 0x5EED_2000];
/// Factor by which the seed of the view is multiplied to get the first seed of a race. It is large, so that
/// races whose view seeds differ by little have no seed in common.
const SPREAD: u32 = 0x9E37_79B9;
/// Time that a useful race needs for rendering, in units of the time of a path-traced frame, if each
/// candidate renders 16 frames per seed. The size of the pictures is chosen so that this time is available.
const USEFUL_FRAMES: f64 = 2000.0;
/// Minimum number of pixels of the pictures that a race renders, unless the user wants smaller ones.
const LEAST_PIXELS: f64 = 1300.0;

impl Track<'_> {
    /// Measures which fraction of the neighbouring pixels share a sample in the reservoirs of direct and of
    /// indirect light. The list is empty if the candidate has no reservoirs. `None` if no renderer can be
    /// made that also stores the origins of samples, because its reservoirs are larger.
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

/// A candidate in the race, with its renderer and the measurements that were made with it so far, one per
/// seed.
struct Contestant {
    candidate: Candidate,
    renderer: Renderer,
    chains: Vec<Chain>,
    /// Sums of the pictures of the candidate: of every second seed, and of the other seeds. Their means are
    /// two independent pictures, which are added to the references.
    pictures: [Added; 2],
    /// Records the frames for the pictures and numbers that a page shows; `None` if no page is wanted.
    recorder: Option<Recorder>,
    /// Time on the host that the candidate's last measurement took, in seconds; 0 before the first one. From
    /// it, the race estimates whether another turn fits into the time.
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

    /// Two independent pictures of the view, which are added to the references: the means over every second
    /// seed, and over the other seeds. `None` if fewer than two seeds were rendered.
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

/// Measures `candidates` in a race that takes the time `time`, and returns their measurements. The first
/// candidate must be path tracing. `gallery`, if it is given, receives the exhibits (pictures and further
/// numbers for a page). `watch` is called with the fraction of the time that has passed, in [0, 1]; an error
/// from it ends the race.
///
/// # Errors
/// There are no candidates, the camera sees no light, the device fails, the scene cannot be rendered at the
/// time of a frame, or `watch` returns an error.
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

/// The candidates of a race with their renderers (contestants), and the selection of those that run in one round or in the
/// final.
struct Chosen<'a> {
    contestants: &'a mut [Contestant],
    /// Indices into `contestants` of those that run in this round.
    chosen: &'a [usize],
}

impl Chosen<'_> {
    /// Lets the selected contestants run chains in turns until the fraction `end` of the time has passed, but
    /// at least `least` chains each. In a turn, each contestant runs one chain, all with the same seed. The
    /// first turn has the seed `seed`, and each further turn the next one. Returns the seed after the last
    /// turn.
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

/// Index of a contestant that comes into the final in addition to `remaining`: the one with the smallest
/// error, if this error is below [`MUCH_LESS`] times the errors of all remaining ones. It is measured however
/// slow it is, because the user may want such a small error. `None` if there is no such contestant.
fn much_better(race: &[Point], remaining: &[usize]) -> Option<usize> {
    let error = |index: &usize| race[*index].error.value;
    let best = remaining.iter().map(error).fold(f64::INFINITY, f64::min);
    let others = (0..race.len()).filter(|index| !remaining.contains(index));
    others
        .filter(|index| error(index) < MUCH_LESS * best && !race[*index].is_empty(&race[0]))
        .min_by(|a, b| error(a).total_cmp(&error(b)))
}

/// The view that the race renders: the wanted view at the largest picture size with which a useful race
/// ([`USEFUL_FRAMES`]) fits into the time, but at most at the wanted size. Path-traced frames are timed to
/// find this size.
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

/// Renders the two references in turns, so that both have the same number of samples per pixel, until their
/// part of the time ([`ENDS`]) has passed. Returns the references and this number of samples, which is at
/// least 8.
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
