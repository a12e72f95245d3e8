//! `render`: the real-time pipeline for a number of frames.

use super::NOTHING_WRITTEN;
use super::arguments::SceneArgs;
use super::ignored;
use super::interrupt::Interrupt;
use super::session::Session;
use crate::files::write_atomically;
use crate::{Error, Result};
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `render`.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where the picture goes: .exr or .png; may repeat
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
    /// Number of frames; they count from 0
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    frames: u32,
    /// Write the mean of all frames instead of the last
    #[arg(long)]
    accumulate: bool,
    /// Frames a second; without it time stands at --start-time
    #[arg(long, allow_hyphen_values = true)]
    fps: Option<f64>,
}

/// Renders and writes.
///
/// # Errors
/// Wrong arguments or input, a device or disk that fails, or a signal, after which `--accumulate` has written
/// the mean of the complete frames.
pub fn run(args: &Args) -> Result<()> {
    if args.frames == 0 {
        return Err(Error::input(
            "--frames 0 renders nothing; frames begin at 1",
        ));
    }
    let (settings, changed) = args.scene.settings()?;
    let clock = args.scene.clock(args.fps)?;
    args.scene.check_outputs(&args.output)?;
    ignored::note_for_scene(&args.scene, &changed, &args.output);
    ignored::note_for_render(&changed, &settings, args.scene.bounces);
    let interrupt = Interrupt::watch()?;
    let mut session = Session::open(&args.scene, settings, clock, &interrupt)?;
    // Without --accumulate only the last frame is shown; those before it are made where it needs
    // them as history.
    let first = if args.accumulate { 0 } else { args.frames - 1 };
    let history = session.first_needed_for(first);
    let progress = super::progress::Progress::new(Some(u64::from(args.frames - history)), "frames");
    for number in history..first {
        interrupt.check(NOTHING_WRITTEN)?;
        session.skip_frame(number)?;
        progress.at(f64::from(number - history));
    }
    let mut done = first;
    while done < args.frames && interrupt.pending().is_none() {
        let before = f64::from(done - history);
        done += session.add_samples(done, args.frames - done, &mut |samples| {
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
    write(args, &mut session, samples)?;
    session.finish()?;
    if done == args.frames {
        return Ok(());
    }
    interrupt.check(&format!(
        "{} keeps the mean of the {samples} complete frames of {}",
        args.output[0].display(),
        args.frames
    ))
}

/// Writes the mean of `samples` frames, and the report.
fn write(args: &Args, session: &mut Session, samples: u32) -> Result<()> {
    let sums = session.renderer.sums()?;
    let image = session.picture(&sums, samples, &args.scene.aov)?;
    for path in &args.output {
        image.write(path, args.scene.exposure)?;
    }
    write_report(session, samples, args.scene.report.as_ref())
}

/// Writes `--report`, if it was asked for.
///
/// # Errors
/// The disk does not take it.
pub fn write_report(session: &Session, samples: u32, path: Option<&PathBuf>) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let report = session.report(samples)?;
    write_atomically(path, |file| writeln!(file, "{report:#}"))
}
