//! `reference`: renders a reference by path tracing with multiple importance sampling (MIS), and the standard error of
//! each pixel. Other pictures are compared with it. The work can be stopped and resumed.

mod resume;

use super::NOTHING_WRITTEN;
use super::arguments::{Aov, SceneArgs};
use super::ignored;
use super::interrupt::Interrupt;
use super::print;
use super::progress::Progress;
use super::render::write_report;
use super::session::{Purpose, Session};
use crate::base::input_files;
use crate::image::Format;
use crate::render::outputs::Sums;
use crate::shader_interface::PixelSums;
use crate::{Error, Result};
use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use glam::Vec3;
use resume::resume;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The number of seconds between two saves of a reference that is being rendered, so that a crash loses at most the work
/// of this time. The environment variable `HEADWATER_SAVE_SECONDS` sets another number.
const SAVE_SECONDS: u64 = 20;

/// The number of samples per pixel at which the error is first compared with `--target-error`. With fewer samples, the
/// fireflies (single very bright samples) that dominate the error may not have occurred yet, and the run would stop too
/// early.
const MIN_SAMPLES: u32 = 64;

/// The command-line arguments of `headwater reference`, which choose the scene, the number of samples per
/// pixel, and the output files.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output files, .exr or .png; the first must be an .exr, from which --resume continues; may be given several times
    #[arg(short, long, value_name = "FILE.exr", required = true)]
    output: Vec<PathBuf>,
    /// Number of samples per pixel [default: 256, or no limit with --target-error or --time]
    #[arg(long, allow_negative_numbers = true)]
    spp: Option<u32>,
    /// Stop when the root mean square of the standard errors of all pixels is at most this fraction of the picture's mean
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    target_error: Option<f64>,
    /// Stop rendering after this many seconds of this run, but not before one sample per pixel
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    time: Option<f64>,
    /// Add samples to those that an earlier run has stored in the first output file; --spp then limits the sum of both
    #[arg(long)]
    resume: bool,
}

/// Changes the definition of the command `reference` where the options that several commands share do not fit it. Hides
/// `--preset`, because presets differ only in resampling. Refuses the AOVs (additional channels) of reservoirs and motion,
/// because a reference has neither reservoirs nor a previous frame. Replaces the help of `--start-time`.
pub fn shown(command: clap::Command) -> clap::Command {
    let shown = Aov::value_variants()
        .iter()
        .filter(|aov| aov.reservoirs_of().is_none() && **aov != Aov::Motion)
        .filter_map(Aov::to_possible_value);
    let aovs = PossibleValuesParser::new(shown).try_map(|name: String| Aov::from_str(&name, false));
    command
        .mut_arg("preset", |preset| preset.hide(true))
        .mut_arg("start_time", |time| {
            time.help("Time in seconds at which the scene is shown")
        })
        .mut_arg("aov", |aov| aov.value_parser(aovs))
}

/// Renders the samples, saves all output files at intervals, and writes them at the end.
///
/// # Errors
/// Wrong arguments or input, a device or disk that fails, or a signal, after which the first output file holds all complete
/// samples.
pub fn run(args: &Args) -> Result<()> {
    let limit = sample_limit(args)?;
    let interrupt = Interrupt::watch()?;
    let (settings, changed) = args.scene.settings()?;
    let settings = settings.of_path_tracing();
    let clock = args.scene.view.clock(None)?;
    // What is resumed is read before it is written.
    let resumed = args.output.iter().find(|path| args.resume && path.exists());
    resumed.map_or(Ok(()), |path| input_files::check(path))?;
    args.scene.check_outputs(&args.output)?;
    ignored::note_for_scene(&args.scene, &changed, &args.output, false);
    ignored::note_for_reference(&args.scene, &changed);
    let purpose = Purpose::Pictures;
    let mut session = Session::open(&args.scene, settings, clock, purpose, 0..1, &interrupt)?;
    let mut done = if args.resume {
        resume(args, &mut session)?
    } else {
        0
    };
    let save_every = std::env::var("HEADWATER_SAVE_SECONDS")
        .ok()
        .and_then(|s| s.parse().ok());
    let save_every = Duration::from_secs(save_every.unwrap_or(SAVE_SECONDS));
    let started = Instant::now();
    let mut saved = Instant::now();
    let mut in_file = done;
    let known = (limit < u32::MAX).then_some(u64::from(limit));
    let mut progress = Progress::new(known, "samples per pixel");
    if args.time.is_some() || args.target_error.is_some() {
        progress = progress.that_may_end_sooner();
    }
    while done < limit {
        if interrupt.pending().is_some() {
            if done > in_file {
                save(args, &mut session, done)?;
            }
            interrupt.check(&kept(args, done))?;
        }
        if args
            .time
            .is_some_and(|seconds| done > 0 && started.elapsed().as_secs_f64() >= seconds)
        {
            break;
        }
        if let Some(target) = args.target_error
            && checks_error(done)
            && relative_error(&session.renderer.sums()?, done).is_some_and(|e| e <= target)
        {
            break;
        }
        let until = match args.target_error {
            Some(_) => next_check(done).min(limit),
            None => limit,
        };
        done += session.add_samples(done, until - done, &mut |samples| {
            progress.at(f64::from(done) + samples);
            // What is under way is given up only where the file has all that went before. That is
            // soon the case: samples that take longer than the time between saves are all saved.
            if in_file == done {
                interrupt.check(&kept(args, in_file))?;
            }
            Ok(())
        })?;
        progress.at(f64::from(done));
        if saved.elapsed() >= save_every {
            save(args, &mut session, done)?;
            (in_file, saved) = (done, Instant::now());
        }
    }
    progress.finish();
    let sums = save(args, &mut session, done)?;
    match relative_error(&sums, done) {
        Some(error) => print(format_args!(
            "{done} samples per pixel, relative standard error {error:.4}"
        ))?,
        None => print(format_args!(
            "1 sample per pixel; the standard error needs at least 2"
        ))?,
    }
    write_report(&session, done, args.scene.report.as_ref())?;
    session.finish()
}

/// A clause for the message after a signal: it states that the first output file keeps `samples` samples per pixel, or,
/// if `samples` is 0, that nothing was written.
fn kept(args: &Args, samples: u32) -> String {
    match samples {
        0 => NOTHING_WRITTEN.into(),
        _ => format!(
            "{} keeps {samples} samples per pixel, --resume continues",
            args.output[0].display()
        ),
    }
}

/// The first number of samples per pixel, larger than `done`, at which the error is compared with `--target-error`. The
/// numbers are 64, 80, 100 and so on, each a fourth larger than the one before; `u32::MAX` if none is left. They are
/// fixed, so that the last sample of a run depends neither on its speed nor on interruptions.
fn next_check(done: u32) -> u32 {
    let mut check = MIN_SAMPLES;
    while check <= done {
        // Where it can grow no more, no limit is left to reach either.
        match (check / 4).checked_add(check) {
            Some(larger) => check = larger,
            None => return u32::MAX,
        }
    }
    check
}

/// True if the run compares its error with `--target-error` after `done` samples per pixel. It stops then if the error is
/// small enough.
fn checks_error(done: u32) -> bool {
    done > 0 && next_check(done - 1) == done
}

/// The number of samples per pixel after which the run stops; `u32::MAX` if only `--target-error` or `--time` limits it.
/// Returns an error if one of these options has a wrong value, or if the first output is not an EXR file.
fn sample_limit(args: &Args) -> Result<u32> {
    let positive = |value: Option<f64>, name: &str| match value {
        Some(v) if !(v > 0.0 && v.is_finite()) => Err(Error::input(format!(
            "--{name} {v}: it takes a positive number"
        ))),
        _ => Ok(()),
    };
    positive(args.target_error, "target-error")?;
    positive(args.time, "time")?;
    if args.output.first().map(|p| Format::of(p)).transpose()? != Some(Format::Exr) {
        return Err(Error::input(
            "a reference's first output is an .exr: only that keeps its standard error",
        ));
    }
    match args.spp {
        Some(0) => Err(Error::input("--spp 0 renders nothing; samples begin at 1")),
        Some(spp) => Ok(spp),
        None if args.target_error.is_some() || args.time.is_some() => Ok(u32::MAX),
        None => Ok(256),
    }
}

/// Writes every output file: the mean of the `samples` samples per pixel whose radiance the renderer has added up. An EXR
/// file also gets the channels that `--resume` reads and, from two samples on, the standard error of each pixel. Returns the
/// renderer's sums, from which the caller computes the relative error.
fn save(args: &Args, session: &mut Session, samples: u32) -> Result<Sums> {
    let sums = session.renderer.sums()?;
    let mut image = session.picture(&sums, samples, &args.scene.aov)?;
    let rgb = ["R", "G", "B"];
    // One sample has no spread; a standard error of 0 would call it exact.
    if samples > 1 {
        let errors = sums.standard_error(samples);
        let errors: Vec<[f32; 3]> = errors.iter().map(|e| e.as_vec3().to_array()).collect();
        image.set_vectors("stderr.", rgb, &errors);
    }
    for (name, part) in PARTS {
        let values: Vec<[f32; 3]> = sums.pixels.iter().map(|p| part(p).to_array()).collect();
        image.set_vectors(&format!("resume.{name}."), rgb, &values);
    }
    for path in &args.output {
        image.write(path, args.scene.look())?;
    }
    Ok(sums)
}

/// A function that returns one of the four RGB values in a pixel's accumulated sums, which [`PARTS`] lists with their
/// names. Saving calls it for every pixel to fill EXR channels, and resuming to check the sums that it has read.
type Part = fn(&PixelSums) -> Vec3;

/// The four RGB values of which the accumulated sums of a pixel consist, each with its name: the sum of the samples'
/// radiance, the sum of the squares of their radiance, and the rounding error of each of these two sums. The names are parts
/// of the names of the EXR channels that `--resume` reads: `sum` is stored in `resume.sum.R`, `resume.sum.G` and
/// `resume.sum.B`.
const PARTS: [(&str, Part); 4] = [
    ("sum", |p| p.sum),
    ("sum_low", |p| p.sum_low),
    ("square", |p| p.square),
    ("square_low", |p| p.square_low),
];

/// The relative standard error of a picture, which is compared with `--target-error`: the root mean square of the
/// standard errors, divided by the mean, both over all pixels and the channels red, green and blue. It is 0 for a black
/// picture, and `None` for fewer than two samples per pixel, whose standard error is unknown.
fn relative_error(sums: &Sums, samples: u32) -> Option<f64> {
    if samples < 2 {
        return None;
    }
    let count = sums.pixels.len() as f64 * 3.0;
    let errors = sums.standard_error(samples);
    let error: f64 = errors.iter().map(|e| e.length_squared()).sum();
    let total: f64 = sums.mean(samples).iter().map(|m| m.element_sum()).sum();
    let mean = total / count;
    Some(if mean > 0.0 {
        (error / count).sqrt() / mean
    } else {
        0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_looked_at_at_the_same_counts_wherever_a_run_begins() {
        let mut counts = vec![next_check(0)];
        while counts[counts.len() - 1] < u32::MAX {
            counts.push(next_check(counts[counts.len() - 1]));
        }
        assert_eq!(counts[..4], [64, 80, 100, 125]);
        assert!(counts.len() < 100);
        for done in 0..200 {
            assert_eq!(checks_error(done), counts.contains(&done), "{done}");
            assert_eq!(Some(&next_check(done)), counts.iter().find(|c| **c > done));
        }
    }
}
