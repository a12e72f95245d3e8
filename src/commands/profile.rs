//! `profile`: measures each pass of a frame: its time, the numbers of rays and other work, and its memory traffic. With
//! an earlier profile, it finds out whether a change made the program slower.

use super::arguments::{SceneArgs, check_files};
use super::choices::TonemapArg;
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::session::{Purpose, Session};
use super::{NOTHING_WRITTEN, ignored, notice, print};
use crate::base::files::write_atomically;
use crate::base::input_files;
use crate::profile::{self, Frame, Limits, Plan, Profile, check_comparable};
use crate::render::settings::Integrator;
use crate::{Error, Result};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The command-line arguments of `headwater profile`, which choose the scene, the settings, the numbers of
/// frames, and the outputs.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Number of frames that are timed, after the warm-up
    #[arg(long, default_value_t = 16, allow_negative_numbers = true)]
    frames: u32,
    /// Number of frames before the timed ones; they compile the shaders, and fill the history that later frames reuse
    #[arg(long, default_value_t = 3, allow_negative_numbers = true)]
    warm_up: u32,
    /// Maximum number of frames that are submitted but not finished. With 1, the host waits for each frame. With more, the
    /// device has no gaps while the host records, and the time from submission to fence is not measured; no bit of a picture
    /// changes
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    in_flight: u32,
    /// Number of frames per second of the scene's time; without it, all frames show the scene at --start-time
    #[arg(long, allow_hyphen_values = true)]
    fps: Option<f64>,
    /// Print the profile as one JSON object instead of text
    #[arg(long)]
    json: bool,
    /// Write the profile as JSON to this file; a later run can read it with --against
    #[arg(short, long, value_name = "FILE.json")]
    output: Option<PathBuf>,
    /// Write the time line of all passes of all frames as JSON, which Perfetto and chrome://tracing show
    #[arg(long, value_name = "FILE.json")]
    trace: Option<PathBuf>,
    /// An earlier profile of the same scene, camera, size and device: also print the differences, and fail if this
    /// profile is worse than --max-slowdown or --max-growth allows; without it, nothing is compared
    #[arg(long, value_name = "FILE.json")]
    against: Option<PathBuf>,
    /// With --against: largest allowed increase of the times of the frame and of its passes, as a fraction of the earlier
    /// times
    #[arg(
        long,
        value_name = "PART",
        default_value_t = 0.1,
        allow_negative_numbers = true
    )]
    max_slowdown: f64,
    /// With --against: largest allowed increase of the memory on the device, as a fraction of the earlier size
    #[arg(
        long,
        value_name = "PART",
        default_value_t = 0.02,
        allow_negative_numbers = true
    )]
    max_growth: f64,
}

/// Renders and times the frames that the arguments ask for. Then prints the profile, writes it to the files of `--output`
/// and `--trace`, and compares it with that of `--against`.
///
/// # Errors
/// Wrong arguments or input, an earlier profile that cannot be compared, a device or disk that fails, a profile that is
/// worse than the limits, or a signal.
pub fn run(args: &Args) -> Result<()> {
    check(args)?;
    let (settings, changed) = args.scene.settings()?;
    let clock = args.scene.view.clock(args.fps)?;
    let interrupt = Interrupt::watch()?;
    check_outputs(args)?;
    let earlier = args.against.as_deref().map(read).transpose()?;
    ignored::note_for_scene(&args.scene, &changed, &[], false);
    ignored::note_for_render(&changed, &settings, args.scene.view.bounces);
    let path_traces = settings.integrator == Integrator::PathTracing;
    if args.in_flight > 1 && path_traces {
        notice("path tracing waits for each strip of a picture, so --in-flight has no effect");
    }
    let in_flight = if path_traces { 1 } else { args.in_flight };
    let plan = Plan {
        // Until so many frames are in flight, the host waits for none.
        warm_up: args.warm_up.max(in_flight - 1),
        frames: args.frames,
        in_flight,
    };
    let timed = plan.warm_up..plan.warm_up + plan.frames;
    let purpose = Purpose::Profile;
    let mut session = Session::open(&args.scene, settings, clock, purpose, timed, &interrupt)?;
    let subject = session.subject(plan)?;
    let circumstances = session.circumstances(plan);
    if let (Some(earlier), Some(path)) = (&earlier, &args.against) {
        let name = path.display().to_string();
        check_comparable(&subject, &circumstances, earlier, &name)?;
    }
    let counted = plan.warm_up + 1;
    let all = plan.warm_up + plan.frames + counted;
    let progress = Progress::new(Some(u64::from(all)), "frames");
    let mut done = 0;
    let mut watch = || {
        interrupt.check(NOTHING_WRITTEN)?;
        progress.at(f64::from(done));
        done += 1;
        Ok(())
    };
    let frames = session.profile(plan, &mut watch)?;
    let records = &session.device.records;
    let (memory, compiled) = (records.memory_use(), records.compiled());
    // Counting takes time, so it has passes of its own.
    let counts = session.counts_of(plan.warm_up, &mut watch)?;
    progress.finish();
    let (warm_up, timed) = frames.split_at(plan.warm_up as usize);
    let profile = Profile::new(
        subject,
        circumstances,
        [warm_up, timed],
        &counts,
        &compiled,
        &memory,
    );
    write(args, &profile, &frames)?;
    session.finish()?;
    match (&earlier, &args.against) {
        (Some(earlier), Some(path)) => against(args, &profile, earlier, path),
        _ => Ok(()),
    }
}

fn check(args: &Args) -> Result<()> {
    for (name, value, why) in [
        ("--frames", args.frames, "times nothing"),
        ("--in-flight", args.in_flight, "renders nothing"),
    ] {
        if value == 0 {
            return Err(Error::input(format!(
                "{name} 0 {why}; at least 1 is needed"
            )));
        }
    }
    if args.frames.saturating_add(args.warm_up) > 100_000 || args.in_flight > 16 {
        return Err(Error::input(
            "--frames and --warm-up may have 100000 frames together, --in-flight 16",
        ));
    }
    if args.in_flight > 1 && args.trace.is_some() {
        return Err(Error::input(
            "--trace shows when the host has waited for each frame, which it does not with --in-flight; leave out one of them",
        ));
    }
    let scene = &args.scene;
    if scene.report.is_some()
        || !scene.aov.is_empty()
        || scene.exposure != 0.0
        || scene.tonemap != TonemapArg::default()
    {
        return Err(Error::input(
            "profile writes no picture, so --report, --aov, --exposure and --tonemap cannot be used; -o writes the profile",
        ));
    }
    for (name, value) in [
        ("--max-slowdown", args.max_slowdown),
        ("--max-growth", args.max_growth),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(Error::input(format!(
                "{name} {value}: it is a part of the earlier value, such as 0.1, and not negative"
            )));
        }
    }
    Ok(())
}

/// Returns an error if a file of `--output` or `--trace` cannot be written, or is also the other output or an input. It
/// is called before rendering, so that no measurement is lost.
fn check_outputs(args: &Args) -> Result<()> {
    let outputs = [("--output", &args.output), ("--trace", &args.trace)];
    let outputs = outputs.into_iter();
    let outputs = outputs.filter_map(|(name, path)| Some((name, path.as_deref()?)));
    let against = args.against.as_deref().map(|path| ("--against", path));
    check_files(outputs, args.scene.inputs().chain(against))
}

/// Reads an earlier profile from the JSON file at `path`. Returns an error if the file contains no profile.
fn read(path: &Path) -> Result<Profile> {
    let text = input_files::read_text(path, input_files::MAX_JSON_BYTES)?;
    serde_json::from_str(&text).map_err(|e| {
        Error::input(format!(
            "{} is not a profile ({e}); 'headwater profile --output' writes one",
            path.display()
        ))
    })
}

/// Prints the profile as text or JSON, and writes it to the file of `--output`. Writes `frames`, the times of each frame
/// including the warm-up, to the file of `--trace`.
fn write(args: &Args, profile: &Profile, frames: &[Frame]) -> Result<()> {
    let json = serde_json::to_string_pretty(profile)
        .map_err(|e| Error::failed(format!("a profile as JSON: {e}")))?;
    if let Some(path) = &args.output {
        write_atomically(path, |file| writeln!(file, "{json}"))?;
    }
    if let Some(path) = &args.trace {
        let trace = profile::trace(frames);
        write_atomically(path, |file| writeln!(file, "{trace}"))?;
    }
    match args.json {
        true => print(json),
        false => print(profile::table(profile)),
    }
}

/// Compares the profile with an earlier one. Prints the difference, except with `--json`, where the output is one JSON
/// object alone. Returns an error if a time or the memory size exceeds the earlier one by more than the limits
/// `--max-slowdown` and `--max-growth`; `path` is the file of the earlier profile, for the message.
fn against(args: &Args, profile: &Profile, earlier: &Profile, path: &Path) -> Result<()> {
    if !args.json {
        print(profile::difference(profile, earlier))?;
    }
    let limits = Limits {
        time: args.max_slowdown,
        memory: args.max_growth,
    };
    let worse = profile::slower(profile, earlier, limits);
    if worse.is_empty() {
        return Ok(());
    }
    Err(Error::failed(format!(
        "worse than {}: {}",
        path.display(),
        worse.join("; ")
    )))
}
