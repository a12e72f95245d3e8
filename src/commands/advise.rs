//! `advise`: measures which preset to use for a scene on this device, how long a frame takes, and how large
//! its error is.

mod contents;

use super::arguments::{ViewArgs, check_files};
use super::ignored;
use super::interrupt::Interrupt;
use super::measuring::{FRAMES_PER_SECOND, check_measurable, course};
use super::progress::Progress;
use super::repetition;
use super::session::{OpenedScene, Purpose as SessionPurpose, Shown};
use super::{NOTHING_WRITTEN, check_messages, print};
use crate::advice::chain::Purpose;
use crate::advice::exhibit::Gallery;
use crate::advice::front::Verdict;
use crate::advice::race;
use crate::advice::track::{Time, Track};
use crate::advice::{candidates, sentence};
use crate::base::files::write_atomically;
use crate::base::json::value_of;
use crate::render::presets::changes;
use crate::render::settings::EnvironmentSettings;
use crate::{Error, Result};
use serde_json::json;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

/// The command-line arguments of `headwater advise`, which choose the scene, the kind of frames, the time for
/// the measurement, and the outputs.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    view: ViewArgs,
    /// The kind of frames that the advice is for
    #[arg(long = "for", value_enum, default_value_t = PurposeArg::Steady)]
    purpose: PurposeArg,
    /// The time to load the scene and to measure, in seconds, without the compilation of shaders, which is reported apart
    #[arg(
        long,
        default_value_t = 120.0,
        value_name = "SECONDS",
        allow_negative_numbers = true
    )]
    time: f64,
    /// Measure all candidates until the end, to compare any two of them; without it, the worse ones are left out, so that the
    /// best ones get more of the time
    #[arg(long)]
    keep_all: bool,
    /// Write settings.toml, for --config, advice.json, and index.html, a page with plots and pictures of all candidates, to
    /// this folder, which is created if it is missing
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print the advice and all measurements as one JSON object
    #[arg(long)]
    json: bool,
}

/// The kind of frames that the advice is for, as `--for` names it. It decides which frames are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum PurposeArg {
    /// A single frame without history
    Still,
    /// A late frame of a camera at rest
    Steady,
    /// A late frame of a camera that moves; it moves sideways where the scene's own camera does not move
    Motion,
}

impl PurposeArg {
    const fn purpose(self) -> Purpose {
        match self {
            Self::Still => Purpose::Still,
            Self::Steady => Purpose::Steady,
            Self::Motion => Purpose::Motion,
        }
    }
}

/// The shortest time that `--time` accepts, in seconds. In less time, the candidates could not be compared.
const LEAST_TIME: f64 = 1.0;

/// Measures the candidates (presets, some with changes) on the scene, prints the advice, and writes the files
/// of `--output`.
///
/// # Errors
/// Wrong arguments or input, a scene without light, no usable device, a device or disk that fails, or a signal.
pub fn run(args: &Args) -> Result<()> {
    if !(args.time >= LEAST_TIME && args.time.is_finite()) {
        return Err(Error::input(format!(
            "--time {}: it is a number of seconds from {LEAST_TIME} up",
            args.time
        )));
    }
    if args.view.bounces == 0 {
        return Err(Error::input(
            "--bounces 0 shows only emitters, which have no error; it begins at 1 here",
        ));
    }
    ignored::note_for_view(&args.view);
    let interrupt = Interrupt::watch()?;
    let files = args
        .output
        .as_ref()
        .map(|folder| ["settings.toml", "advice.json", "index.html"].map(|name| folder.join(name)));
    let time = Time::of(args.time);
    let purpose = args.purpose.purpose();
    let is_motion = purpose == Purpose::Motion;
    let frames = purpose.frames();
    let clock = args.view.clock(is_motion.then_some(FRAMES_PER_SECOND))?;
    let shown = Shown {
        scatters: true,
        environment: EnvironmentSettings::default(),
        clock,
        clock_is_given: args.view.start_time != 0.0,
        frames: 0..if is_motion { frames } else { 1 },
    };
    let scene = OpenedScene::open(&args.view, &shown, SessionPurpose::Pictures, &interrupt)?;
    check_measurable(&scene, &args.view.scene)?;
    if let (Some(folder), Some(files)) = (&args.output, &files) {
        std::fs::create_dir_all(folder).map_err(|e| Error::writing(folder, e))?;
        check_files(files.iter().map(|file| ("--output", file.as_path())), [])?;
    }
    let course = course(purpose, &scene, clock.time(frames - 1), true)?;
    let candidates = candidates::all(purpose)?;
    let progress = Progress::of_whole("the measurement");
    let track = Track {
        device: &scene.device,
        scene: &scene.gpu_scene,
        view: &scene.view,
        course: &course,
        keeps_all: args.keep_all,
    };
    let mut gallery = args.output.as_ref().map(|_| Gallery::default());
    let front = race::run(
        &track,
        &candidates,
        time,
        gallery.as_mut(),
        &mut |fraction| {
            progress.at(fraction);
            interrupt.check(NOTHING_WRITTEN)
        },
    )?;
    progress.finish();
    let is_decided = !matches!(front.verdict, Verdict::Undecided(_));
    let best = front.finalists.first().filter(|_| is_decided);
    let best = best.map(|point| &point.candidate);
    let fps = scene.clock.and_then(|clock| clock.fps);
    let command = best.map(|best| command(args, &best.options(), fps, frames));
    let advice = sentence::advice(&front);
    let report = json!({
        "version": 1,
        "advice": advice,
        "command": command,
        "device": scene.device.info.name,
        "driver": scene.device.info.driver,
        "commit": env!("HEADWATER_COMMIT"),
        "scene": scene.scene_hash,
        "front": value_of("the measurements", &front)?,
    });
    // A full disk must not take the advice away.
    if args.json {
        print(format_args!("{report:#}"))?;
    } else {
        print(&advice)?;
        print(sentence::details(&front))?;
        print(sentence::table(&front))?;
        if let Some(command) = &command {
            print(command)?;
        }
    }
    if let (Some([settings_file, report_file, page_file]), Some(gallery)) = (&files, gallery) {
        let page = contents::page(args, &scene, &front, gallery, fps)?.html()?;
        match best {
            Some(best) => {
                let settings = changes(&best.settings()?)?;
                write_atomically(settings_file, |file| file.write_all(settings.as_bytes()))?;
            }
            // Those of an earlier advice would stand beside a page that gives none.
            None => match std::fs::remove_file(settings_file) {
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    return Err(Error::writing(settings_file, error));
                }
                _ => {}
            },
        }
        write_atomically(report_file, |file| writeln!(file, "{report:#}"))?;
        write_atomically(page_file, |file| file.write_all(page.as_bytes()))?;
    }
    check_messages(&scene.instance.validation_messages())
}

/// The command line of `headwater render` with which the user gets frames of the measured kind: the arguments
/// of the view, the options `settings` of a candidate, `fps` frames per second if the scene moves, and
/// `frames` frames.
fn command(args: &Args, settings: &str, fps: Option<f64>, frames: u32) -> String {
    let command = repetition::of_view(&args.view, settings, fps);
    format!("{command} --frames {frames} -o picture.exr")
}
