//! `render`: renders a number of frames of a scene, and writes the last frame or the mean of all.

use super::arguments::SceneArgs;
use super::capture::{self, FrameRange};
use super::ignored;
use super::interrupt::Interrupt;
use super::needs::{self, Bounds, NeedArgs};
use super::sequence::{file_of_frame, frame_of, is_sequence};
use super::session::{Purpose, Session};
use super::{NOTHING_WRITTEN, notice};
use crate::base::files::write_atomically;
use crate::{Error, Result};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;

/// The command-line arguments of `headwater render`, which choose the scene, the settings, the frames, and
/// the output files.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    /// Output file for the picture, .exr or .png; may be given several times. A name with %d or %04d writes one file per frame
    /// with the index of the frame in its name, from 0 on; with --accumulate, the mean of the frames so far
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
    /// Number of frames to render; the last one is written, or the mean of all with --accumulate [default: 1, or what
    /// --budget-ms or --target-relmse chooses]
    #[arg(long, allow_negative_numbers = true)]
    pub(super) frames: Option<u32>,
    /// Write the mean of all frames instead of the last frame
    #[arg(long)]
    pub(super) accumulate: bool,
    /// Have RenderDoc or GFXReconstruct, whichever is loaded, capture frames N to M, both included; every frame is then
    /// rendered and ends with a presented picture; tools/capture starts Headwater with one of the tools
    #[arg(long, value_name = "N..M", allow_hyphen_values = true)]
    capture: Option<FrameRange>,
    /// With --capture: write the presented pictures of the captured frames to this folder, which must exist, as PNG files
    #[arg(long, value_name = "FOLDER", requires = "capture")]
    presented: Option<PathBuf>,
    /// Number of frames per second of the scene's time; without it, all frames show the scene at --start-time
    #[arg(long, allow_hyphen_values = true)]
    pub(super) fps: Option<f64>,
    #[command(flatten)]
    needs: NeedArgs,
}

/// Renders the frames, and writes the pictures of `--output` and the report of `--report`.
///
/// # Errors
/// Wrong arguments or input, a device or disk that fails, or a signal, after which `--accumulate` has written the mean of
/// the complete frames.
pub fn run(args: &Args) -> Result<()> {
    if args.frames == Some(0) {
        return Err(Error::input(
            "--frames 0 renders nothing; frames begin at 1",
        ));
    }
    let need = args.needs.need()?;
    let mut frames = args.frames.unwrap_or(1);
    let mut accumulates = args.accumulate;
    let writes_all = args.output.iter().any(|path| is_sequence(path));
    if let Some(range) = &args.capture {
        range.check(frames)?;
        if writes_all {
            return Err(Error::input(
                "--capture writes no sequence of pictures; --presented FOLDER writes the captured frames",
            ));
        }
    }
    let interrupt = Interrupt::watch()?;
    let (settings, changed) = args.scene.settings()?;
    let clock = args.scene.view.clock(args.fps)?;
    args.scene.check_outputs(&outputs(args))?;
    if let Some(folder) = &args.presented {
        crate::base::files::check_writable(&folder.join("frame_0000.png"))?;
    }
    ignored::note_for_scene(&args.scene, &changed, &args.output, args.capture.is_some());
    ignored::note_for_render(&changed, &settings, args.scene.view.bounces);
    let purpose = match args.capture {
        Some(_) => Purpose::Capture,
        None => Purpose::Pictures,
    };
    let chosen = match need {
        Some(need) => {
            let bounds = Bounds {
                scene: &args.scene,
                settings: &settings,
                changed: &changed,
                frames: args.frames,
                accumulates,
                clock,
                measure_time: args.needs.measure_time,
            };
            let (scene, choice) = needs::choose(need, &bounds, &interrupt)?;
            (frames, accumulates) = (choice.frames, choice.accumulates);
            Some((scene, need, choice))
        }
        None => None,
    };
    // Without accumulation only the last frame is shown; those before it are made where it needs
    // them as history.
    let first = if accumulates || writes_all {
        0
    } else {
        frames - 1
    };
    let (mut session, met) = match chosen {
        Some((scene, need, choice)) => {
            let settings = choice.candidate.settings()?;
            let session = Session::of(scene, &args.scene, settings)?;
            let file = args.output[0].display().to_string();
            (session, needs::check(need, &choice, &file))
        }
        None => {
            let shown = first..frames;
            let session = Session::open(&args.scene, settings, clock, purpose, shown, &interrupt)?;
            (session, Ok(()))
        }
    };
    if accumulates
        && frames > 1
        && let Some(clock) = session.running_clock()
    {
        notice(&format!(
            "the picture is the mean of {} moments of the scene, from {} to {} s, because --fps moves the scene between frames; leave out --fps for the mean of one moment",
            frames,
            clock.time(0),
            clock.time(frames - 1)
        ));
    }
    if let Some(range) = args.capture {
        let wanted = capture::CapturePlan {
            range,
            frames,
            accumulate: accumulates,
            exposure: args.scene.exposure,
            folder: args.presented.as_deref(),
        };
        capture::render(&mut session, &wanted, &interrupt)?;
        let samples = if accumulates { frames } else { 1 };
        write(args, &mut session, samples, frames - 1, true)?;
        return session.finish();
    }
    if writes_all {
        write_all(args, &mut session, frames, accumulates, &interrupt)?;
        session.finish()?;
        return met;
    }
    let history = session.first_needed_for(first);
    let progress = super::progress::Progress::new(Some(u64::from(frames - history)), "frames");
    for index in history..first {
        interrupt.check(NOTHING_WRITTEN)?;
        session.skip_frame(index)?;
        progress.at(f64::from(index - history));
    }
    let mut done = first;
    while done < frames && interrupt.pending().is_none() {
        let before = f64::from(done - history);
        done += session.add_samples(done, frames - done, &mut |samples| {
            progress.at(before + samples);
            // Frames that are complete are worth waiting for those under way, which would spoil the sums.
            if done == first {
                interrupt.check(NOTHING_WRITTEN)?;
            }
            Ok(())
        })?;
        progress.at(f64::from(done - history));
    }
    progress.finish();
    let samples = done - first;
    if samples == 0 {
        interrupt.check(NOTHING_WRITTEN)?;
    }
    write(args, &mut session, samples, done - 1, true)?;
    session.finish()?;
    if done == frames {
        return met;
    }
    interrupt.check(&format!(
        "{} keeps the mean of the {samples} complete frames of {}",
        args.output[0].display(),
        frames
    ))
}

/// The files of `--output` that are checked before rendering. For a sequence, these are the file of frame 0, and the files of
/// frames that have the file name of an input.
fn outputs(args: &Args) -> Vec<PathBuf> {
    let most = args.frames.unwrap_or(u32::MAX);
    let of_path = |path: &PathBuf| {
        let like_inputs = (args.scene.inputs()).filter_map(|(_, input)| frame_of(path, input));
        let frames = like_inputs.filter(|index| (1..most).contains(index));
        let frames: BTreeSet<u32> = std::iter::once(0).chain(frames).collect();
        (frames.into_iter())
            .map(|index| file_of_frame(path, index))
            .collect::<Vec<_>>()
    };
    args.output.iter().flat_map(of_path).collect()
}

/// Renders `frames` frames, and writes a picture after each one: to the file of `--output` with the index of the frame in its
/// name. Other files of `--output` get the last picture. If `accumulates` is true, a picture is the mean of the frames so far.
///
/// # Errors
/// A device or disk that fails, a time at which the scene cannot be rendered, or a signal. Files that are complete stay.
fn write_all(
    args: &Args,
    session: &mut Session,
    frames: u32,
    accumulates: bool,
    interrupt: &Interrupt,
) -> Result<()> {
    let progress = super::progress::Progress::new(Some(u64::from(frames)), "frames");
    for index in 0..frames {
        interrupt.check(&match index {
            0 => NOTHING_WRITTEN.to_owned(),
            _ => format!("{index} of {frames} pictures are written"),
        })?;
        session.frame(index, accumulates)?;
        if !accumulates {
            session.renderer.keep_single_frame()?;
        }
        let samples = if accumulates { index + 1 } else { 1 };
        write(args, session, samples, index, index + 1 == frames)?;
        progress.at(f64::from(index + 1));
    }
    progress.finish();
    Ok(())
}

/// Writes the picture after frame `index` to the files of `--output` that are sequences and, if `is_last` is true, to all
/// others; the file of `--report` is then written too. The picture is the mean of the `samples` frames whose radiance the
/// renderer has added up.
fn write(
    args: &Args,
    session: &mut Session,
    samples: u32,
    index: u32,
    is_last: bool,
) -> Result<()> {
    let sums = session.renderer.sums()?;
    let image = session.picture(&sums, samples, &args.scene.aov)?;
    let due = |path: &&PathBuf| is_last || is_sequence(path);
    for path in args.output.iter().filter(due) {
        image.write(&file_of_frame(path, index), args.scene.look())?;
    }
    match is_last {
        true => write_report(session, samples, args.scene.report.as_ref()),
        false => Ok(()),
    }
}

/// Writes the JSON report of the run (settings, times, and what the program chose, such as the tracer) to `path`, the file
/// of `--report`; with `None`, writes nothing. The report states `samples`, the number of samples per pixel of the picture.
///
/// # Errors
/// The file cannot be written.
pub fn write_report(session: &Session, samples: u32, path: Option<&PathBuf>) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let report = session.report(samples)?;
    write_atomically(path, |file| writeln!(file, "{report:#}"))
}
