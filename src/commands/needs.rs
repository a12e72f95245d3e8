//! `render --budget-ms` and `render --target-relmse`: measures the scene on the device before the first
//! frame, and chooses by this measurement the settings, the number of frames, and whether the picture is
//! their mean.

use super::arguments::{Aov, SceneArgs};
use super::choices::TonemapArg;
use super::interrupt::Interrupt;
use super::measuring::{check_measurable, course};
use super::progress::Progress;
use super::session::{OpenedScene, Purpose as SessionPurpose, Shown, camera_text};
use super::{NOTHING_WRITTEN, notice, repetition, say};
use crate::advice::cache::Place;
use crate::advice::chain::Purpose;
use crate::advice::need::{self, Choice, MOST_FRAMES, Need};
use crate::advice::race;
use crate::advice::sizing;
use crate::advice::timing;
use crate::advice::track::{Time, Track};
use crate::advice::{Candidate, Front, candidates};
use crate::base::short_hash::short;
use crate::render::presets::{self, Preset};
use crate::render::settings::{IndirectMode, Integrator, flatten};
use crate::render::{Clock, Lighting, Settings};
use crate::{Error, Result};
use clap::ValueEnum;
use serde_json::{Map, Value, json};
use std::num::NonZero;

/// Options of `render` with which the user states a need, a limit for the time of a frame or for the error of
/// the picture. The program then chooses the settings by measurement.
#[derive(clap::Args)]
pub struct NeedArgs {
    /// Choose the settings with the least error of those whose frames take at most this time on the device,
    /// in milliseconds. The scene is measured first, in about 30 s, once for each view and device. --preset,
    /// --set, --frames and --accumulate limit the choice
    #[arg(
        long,
        value_name = "MS",
        group = "need",
        conflicts_with = "capture",
        allow_negative_numbers = true
    )]
    budget_ms: Option<f64>,
    /// Choose the settings and the number of frames with which a picture with at most this relMSE takes the
    /// least time; the scene is measured, and other options limit the choice, as with --budget-ms
    #[arg(
        long,
        value_name = "ERROR",
        group = "need",
        conflicts_with = "capture",
        allow_negative_numbers = true
    )]
    target_relmse: Option<f64>,
    /// The time to load and measure a scene for --budget-ms or --target-relmse, in seconds, without the compilation of
    /// shaders
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 30.0,
        requires = "need",
        allow_negative_numbers = true
    )]
    pub measure_time: f64,
}

impl NeedArgs {
    /// The need that `--budget-ms` (milliseconds per frame) or `--target-relmse` states; `None` if neither
    /// option is given, so that nothing is measured.
    ///
    /// # Errors
    /// The number of the option, or of `--measure-time`, is not positive and finite.
    pub fn need(&self) -> Result<Option<Need>> {
        let (option, number, need) = match (self.budget_ms, self.target_relmse) {
            (Some(ms), _) => ("--budget-ms", ms, Need::Milliseconds(ms)),
            (_, Some(relmse)) => ("--target-relmse", relmse, Need::RelMse(relmse)),
            _ => return Ok(None),
        };
        for (option, number) in [(option, number), ("--measure-time", self.measure_time)] {
            if !(number > 0.0 && number.is_finite()) {
                return Err(Error::input(format!(
                    "{option} {number}: it is a number above 0"
                )));
            }
        }
        Ok(Some(need))
    }
}

/// The largest fraction of `--measure-time` that one measurement of an error in pictures of the wanted size
/// may take.
const SIZING_PART: f64 = 0.25;
/// The maximum number of measurements of an error in pictures of the wanted size. After these, a candidate is
/// chosen by its error in smaller pictures.
const MOST_SIZED: u32 = 4;

/// The arguments of `render` that restrict the choice of settings and frames for a need.
pub struct Bounds<'a> {
    /// The options of the scene, its view and its settings, as the user gave them.
    pub scene: &'a SceneArgs,
    /// The settings that result from `--preset`, `--config` and `--set`.
    pub settings: &'a Settings,
    /// The dotted keys, such as `direct.mode`, that `--config` and `--set` change. All candidates get the
    /// user's values of these settings.
    pub changed: &'a [String],
    /// The value of `--frames`; with `None`, the number of frames is chosen.
    pub frames: Option<u32>,
    /// True if `--accumulate` is given, so that the picture must be the mean of all frames.
    pub accumulates: bool,
    /// The clock of the run, which gives for the index of a frame the time in the scene.
    pub clock: Clock,
    /// The value of `--measure-time`: the time to load and measure the scene, in seconds, without the
    /// compilation of shaders.
    pub measure_time: f64,
}

/// Opens the scene, measures the candidates unless a stored measurement with the same conditions exists, and
/// chooses settings and frames for the need. Prints the choice, and the command that renders the picture
/// again without measuring. Returns the open scene and the choice.
///
/// # Errors
/// Wrong arguments or input, a scene without light, an error that no permitted number of frames reaches, no
/// usable device, a device that fails, or a signal.
pub fn choose(
    need: Need,
    bounds: &Bounds<'_>,
    interrupt: &Interrupt,
) -> Result<(OpenedScene, Choice)> {
    let time = Time::of(bounds.measure_time);
    let view = &bounds.scene.view;
    let clock = bounds.clock;
    check_comparable(need, bounds)?;
    let shown = Shown {
        scatters: true,
        environment: bounds.settings.environment,
        clock,
        clock_is_given: true,
        // Those that are measured in a scene that moves, and those that the user wants.
        frames: 0..bounds.frames.unwrap_or(1).max(Purpose::Motion.frames()),
    };
    let scene = OpenedScene::open(view, &shown, SessionPurpose::Pictures, interrupt)?;
    check_measurable(&scene, &view.scene)?;
    let moves = scene.clock.is_some_and(|clock| clock.fps.is_some());
    let purpose = match need {
        _ if moves && bounds.frames == Some(1) => Purpose::Still,
        _ if moves => Purpose::Motion,
        Need::RelMse(_) => Purpose::Mean,
        Need::Milliseconds(_) if bounds.accumulates => Purpose::Mean,
        Need::Milliseconds(_) if bounds.frames == Some(1) => Purpose::Still,
        Need::Milliseconds(_) => Purpose::Steady,
    };
    if moves && bounds.accumulates {
        return Err(Error::input(format!(
            "with {}, --accumulate needs a scene at rest; leave out --fps",
            option(need)
        )));
    }
    let course = course(purpose, &scene, clock.time(purpose.frames() - 1), false)?;
    let track = Track {
        device: &scene.device,
        scene: &scene.gpu_scene,
        view: &scene.view,
        course: &course,
        keeps_all: true,
    };
    let candidates = bound_candidates(bounds, purpose)?;
    let place = Place::of(conditions(&scene, purpose, clock, &candidates)?);
    let known = place.load();
    // A longer measurement than the known one is wanted for its precision.
    let known = known.filter(|front| front.seconds > 0.5 * bounds.measure_time);
    let mut is_new = known.is_none();
    let mut front = match known {
        Some(front) => front,
        None => {
            say(format_args!(
                "measuring the scene for {}, in about {} s and the time to compile shaders; later runs know the result{}",
                option(need),
                bounds.measure_time,
                place
                    .file()
                    .map_or(String::new(), |file| format!(" ({})", file.display()))
            ));
            measure(&track, &candidates, time, interrupt)?
        }
    };
    let yardstick = &candidates[0];
    let is_bound = bounds.scene.preset.is_some();
    let aovs = &bounds.scene.aov;
    let shown: Vec<Lighting> = aovs.iter().filter_map(|aov| aov.reservoirs_of()).collect();
    let is_allowed = |candidate: &Candidate| {
        let has_reservoirs = shown.is_empty()
            || candidate.settings().is_ok_and(|settings| {
                let mut shown = shown.iter();
                shown.all(|lighting| settings.has_reservoirs(*lighting, view.bounces))
            });
        has_reservoirs && (!is_bound || candidate != yardstick || candidates.len() == 1)
    };
    let is_small = front.size != front.wanted_size;
    let seconds = SIZING_PART * bounds.measure_time;
    let mut sized = 0;
    let choice = loop {
        let choice = need::choose(&front, need, bounds.frames, is_allowed)?;
        let size = front.size;
        let Some(point) = front.point_of(&choice.candidate) else {
            break choice;
        };
        // The times of small frames say little about those of large ones, and neither do the errors.
        if !point.is_timed && matches!(need, Need::Milliseconds(_)) {
            timing::measure(&mut front, std::slice::from_ref(&choice.candidate), &track)?;
        } else {
            let frames = sizing::frames_for(point, purpose, choice.frames, seconds);
            if is_small && frames != 0 && frames != point.sized_frames && sized < MOST_SIZED {
                sized += 1;
                let check = &mut || interrupt.check(NOTHING_WRITTEN);
                sizing::carry_over(point, &track, size, frames, seconds, check)?;
            } else {
                break choice;
            }
        }
        is_new = true;
    };
    let (small, wanted) = (front.size, front.wanted_size);
    let point = front.point_of(&choice.candidate);
    if is_small && point.is_some_and(|point| point.sized_frames == 0) {
        notice(&format!(
            "the error was measured in pictures of {} × {}, because those of {} × {} take too long; a longer --measure-time can measure them",
            small.0, small.1, wanted.0, wanted.1
        ));
    }
    if let (Need::RelMse(wanted), false) = (need, choice.is_met)
        && choice.frames == MOST_FRAMES
    {
        return Err(Error::input(format!(
            "--target-relmse {wanted}: even {MOST_FRAMES} frames ({:.0} hours) are not enough; choose a larger error",
            choice.milliseconds * f64::from(MOST_FRAMES) / 3.6e6
        )));
    }
    if is_new && let Err(error) = place.store(&front) {
        notice(&format!("the measurements are not kept: {error}"));
    }
    announce(&choice, bounds, moves.then_some(clock.fps).flatten())?;
    Ok((scene, choice))
}

/// The name of the command-line option that states this need, for messages.
fn option(need: Need) -> &'static str {
    match need {
        Need::Milliseconds(_) => "--budget-ms",
        Need::RelMse(_) => "--target-relmse",
    }
}

/// Checks that path tracing shows the same light as the candidates, so that it can be their reference.
/// Returns an error if there are no bounces, if indirect light is off, or if the user has set the integrator.
fn check_comparable(need: Need, bounds: &Bounds<'_>) -> Result<()> {
    let option = option(need);
    if bounds.scene.view.bounces == 0 {
        return Err(Error::input(format!(
            "{option} with --bounces 0: such pictures show only emitters, and have no error"
        )));
    }
    let key = match bounds.settings.indirect.mode {
        _ if bounds.changed.iter().any(|key| key == "integrator") => "integrator",
        IndirectMode::Off => "indirect.mode=off",
        IndirectMode::Path | IndirectMode::Restir => return Ok(()),
    };
    Err(Error::input(format!(
        "{option} does not work with the setting {key}, because candidates are compared with path tracing of all light; leave it out, or choose --bounces"
    )))
}

/// Measures the time and the error of all candidates in about `time`, and shows the progress on stderr.
fn measure(
    track: &Track<'_>,
    candidates: &[Candidate],
    time: Time,
    interrupt: &Interrupt,
) -> Result<Front> {
    let progress = Progress::of_whole("the measurement");
    let front = race::run(track, candidates, time, None, &mut |fraction| {
        progress.at(fraction);
        interrupt.check(NOTHING_WRITTEN)
    })?;
    progress.finish();
    Ok(front)
}

/// The candidates for the choice, path tracing first, because all are compared with it. With `--preset`, this
/// preset is the only other candidate. The changes of `--config` and `--set` are applied to all; candidates
/// that become equal are listed once.
fn bound_candidates(bounds: &Bounds<'_>, purpose: Purpose) -> Result<Vec<Candidate>> {
    let mut all = candidates::all(purpose)?;
    if let Some(preset) = &bounds.scene.preset {
        all.truncate(1);
        if Preset::named(preset)?.settings()?.integrator != Integrator::PathTracing {
            all.push(Candidate {
                name: preset.clone(),
                preset: preset.clone(),
                set: Map::new(),
                purpose: None,
            });
        }
    }
    let mut values = Vec::new();
    flatten("", &bounds.settings.to_value()?, &mut values);
    let mut bound: Vec<Candidate> = Vec::new();
    let mut known = Vec::new();
    for mut candidate in all {
        for (key, value) in values
            .iter()
            .filter(|(key, _)| bounds.changed.contains(key))
        {
            candidate.set.insert(key.clone(), value.clone());
        }
        let settings = candidate.settings()?;
        // Changes can make two candidates equal.
        if !known.contains(&settings) {
            known.push(settings);
            bound.push(candidate);
        }
    }
    Ok(bound)
}

/// A JSON object with all conditions that the measurements depend on, such as the program, the scene, the
/// device and the view. Measurements are stored under it; a later run uses them only if its object is equal.
fn conditions(
    scene: &OpenedScene,
    purpose: Purpose,
    clock: Clock,
    candidates: &[Candidate],
) -> Result<Value> {
    let variant = scene.selection.variant;
    let candidates: Result<Vec<Value>> = candidates
        .iter()
        .map(|candidate| candidate.settings()?.to_value())
        .collect();
    // Two builds of one commit can differ, and CPUs of one driver in the number of their cores.
    let program = std::env::current_exe().and_then(std::fs::read);
    let program = program.map(|bytes| short(&blake3::hash(&bytes)));
    let cores = std::thread::available_parallelism().map_or(0, NonZero::get);
    Ok(json!({
        "version": 2,
        "program": program.unwrap_or(env!("HEADWATER_COMMIT").to_owned()),
        "cores": cores,
        "shaders": scene.edited_shaders,
        "scene": scene.scene_hash,
        "device": scene.device.info.name,
        "driver": scene.device.info.driver,
        "variant": [
            variant.tracer.name(),
            variant.geometry.name(),
            variant.fetch.name(),
            variant.textures.name(),
        ],
        "camera": camera_text(&scene.view.camera),
        "size": [scene.view.width, scene.view.height],
        "bounces": scene.view.bounces,
        "jitter": scene.view.jitter,
        "start_time": clock.start_time,
        "fps": clock.fps,
        "purpose": crate::base::json::value_of("the purpose", &purpose)?,
        "candidates": candidates?,
    }))
}

/// Prints notes on stderr: the choice with its time and error, and the command that renders the picture again
/// without measuring. `fps` is the number of frames per second in this command; `None` leaves it out.
fn announce(choice: &Choice, bounds: &Bounds<'_>, fps: Option<f64>) -> Result<()> {
    let view = &bounds.scene.view;
    if !choice.candidate.settings()?.is_unbiased() {
        notice(&format!(
            "the settings of --preset {} or --set are biased; the choice is bound to them",
            bounds.scene.preset.as_deref().unwrap_or(presets::DEFAULT)
        ));
    }
    let (frames, is_mean) = (choice.frames, choice.accumulates);
    notice(&format!(
        "chosen: `{}`, {}, {:.2} ms per frame, relMSE about {:.3e}",
        choice.candidate.name,
        match (frames, is_mean) {
            (1, _) => "one frame".to_owned(),
            (_, true) => format!("the mean of {frames} frames"),
            (_, false) => format!("the last one of {frames} frames"),
        },
        choice.milliseconds_per_frame(),
        choice.relmse
    ));
    let mut command = repetition::of_view(view, &choice.candidate.options(), fps);
    command += &format!(" --seed {} --frames {frames}", view.seed);
    if is_mean {
        command += " --accumulate";
    }
    let aovs = bounds.scene.aov.iter().filter_map(Aov::to_possible_value);
    let aovs: Vec<String> = aovs.map(|aov| aov.get_name().to_owned()).collect();
    if !aovs.is_empty() {
        command += &format!(" --aov {}", aovs.join(","));
    }
    if bounds.scene.exposure != 0.0 {
        command += &format!(" --exposure {}", bounds.scene.exposure);
    }
    if bounds.scene.tonemap == TonemapArg::None {
        command += " --tonemap none";
    }
    notice(&format!("again: {command} -o picture.exr"));
    Ok(())
}

/// Checks that the need is met. The command calls it after it has written the picture `file`, so that the
/// user gets the best picture and an error.
///
/// # Errors
/// According to the measurements, no permitted choice meets the need.
pub fn check(need: Need, choice: &Choice, file: &str) -> Result<()> {
    if choice.is_met {
        return Ok(());
    }
    let name = &choice.candidate.name;
    Err(Error::failed(match need {
        Need::Milliseconds(most) => format!(
            "--budget-ms {most}: nothing is as fast; the cheapest, `{name}`, takes {:.2} ms per frame, and {file} was written with it",
            choice.milliseconds
        ),
        Need::RelMse(most) => format!(
            "--target-relmse {most}: nothing comes so far with these frames; the best, `{name}`, has about {:.3e}, and {file} was written with it",
            choice.relmse
        ),
    }))
}
