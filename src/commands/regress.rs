//! `regress`: compares what a driver renders with golden frames (stored pictures and hashes of a trusted driver), to
//! find errors of the driver or of a change of the program, or makes golden frames.

use super::arguments::check_files;
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::render;
use super::session::{Purpose, Session};
use super::{NOTHING_WRITTEN, notice, open_vulkan, print, print_part};
use crate::base::files::{check_writable, write_atomically};
use crate::base::printable::printable;
use crate::device_scene::selection::Request;
use crate::gpu::{DeviceInfo, InstanceOptions};
use crate::image::{Image, png};
use crate::metrics::flip::flip;
use crate::regress::{
    Blessing, Case, Goldens, Rendered, SEEDS, Step, Verdict, cases, judge_exactly, judge_loosely,
    level, report,
};
use crate::shader_interface::{GeometryAccess, Textures, Tracer};
use crate::{Error, Result};
use clap::Parser;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The command-line arguments of `headwater regress`, which choose the folder of golden frames, the test
/// cases, and the outputs.
#[derive(clap::Args)]
pub struct Args {
    /// The folder of all golden frames; it contains one folder for each device and driver
    folder: PathBuf,
    /// Store what this driver renders as its golden frames, instead of comparing; this replaces all older ones of the same
    /// driver, or with --only just those of the selected cases
    #[arg(long)]
    bless: bool,
    /// Load the Vulkan validation layers with synchronization validation; a case in which they send a message fails
    #[arg(long)]
    validate: bool,
    /// Require equal bits even if the golden frames were made with another driver, such as another build of the same source;
    /// without it, pictures may then differ by rounding
    #[arg(long, conflicts_with = "bless")]
    exact: bool,
    /// Run only the test cases whose names contain this text; without it, all cases are run
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Write the results of all cases to this file as JUnit XML, which CI systems read
    #[arg(long, value_name = "FILE.xml", conflicts_with = "bless")]
    junit: Option<PathBuf>,
    /// For each case that fails, write the picture, the golden picture and their difference to this folder; it is created
    /// when the first case fails
    #[arg(short, long, value_name = "FOLDER", default_value = "regress-failures")]
    output: PathBuf,
    /// The Vulkan device to use: its name, a part of its name, or its index in 'headwater info'; without it, the best
    /// one: discrete GPUs first, CPUs last
    #[arg(long, value_name = "NAME|INDEX", env = "HEADWATER_DEVICE")]
    device: Option<String>,
}

/// The parser of a test case, which is written like the arguments of the command `render`. It yields the scene, the settings
/// and the number of frames with which the case is rendered.
#[derive(Parser)]
#[command(name = "render")]
struct Line {
    #[command(flatten)]
    args: render::Args,
}

/// Renders the test cases that `--only` selects, and either stores them as golden frames or compares them with the stored
/// ones.
///
/// # Errors
/// Wrong arguments or golden frames, a case that fails, a device or disk that fails, or a signal.
pub fn run(args: &Args) -> Result<()> {
    let wanted = |case: &Case| {
        args.only
            .as_ref()
            .is_none_or(|text| case.name.contains(text))
    };
    let cases: Vec<Case> = cases()?.into_iter().filter(wanted).collect();
    if cases.is_empty() {
        return Err(Error::input(format!(
            "no case has '{}' in its name",
            args.only.as_deref().unwrap_or_default()
        )));
    }
    let interrupt = Interrupt::watch()?;
    check_files(args.junit.as_deref().map(|path| ("--junit", path)), [])?;
    // The device is chosen once, for its name and what it lacks; each case opens it anew. The instance stays until the end:
    // NVIDIA's driver cannot be loaded again after about thirty times, and without an instance it is unloaded.
    let instance = open_vulkan(InstanceOptions {
        validation: args.validate,
        ..InstanceOptions::default()
    })?;
    let (device, _) = instance.choose(args.device.as_deref())?;
    match args.bless {
        true => bless(args, &cases, &device, &interrupt),
        false => compare(args, &cases, &device, &interrupt),
    }
}

/// Renders the cases and stores them as golden frames of the driver. A case that needs a feature which the device lacks
/// is skipped and counted.
fn bless(args: &Args, cases: &[Case], device: &DeviceInfo, interrupt: &Interrupt) -> Result<()> {
    check_folder(&args.folder)?;
    let mut blessing = Blessing::new(&args.folder, device);
    // Damage is found before minutes of work.
    if args.only.is_some() {
        blessing.add_older()?;
    }
    let progress = Progress::new(Some(cases.len() as u64), "cases");
    let mut skipped = 0;
    for (index, case) in cases.iter().enumerate() {
        progress.at(index as f64);
        let rendered = OpenCase::with(args, case, device, interrupt, OpenCase::render)?;
        let levels = OpenCase::with(args, case, device, interrupt, OpenCase::levels)?;
        match (rendered, levels) {
            (Ok(rendered), Ok(levels)) => blessing.add(case, Rendered { levels, ..rendered }),
            _ => skipped += 1,
        }
    }
    progress.finish();
    let folder = blessing.finish()?;
    print(format_args!(
        "{} golden frames of {} in {}; {skipped} skipped, which need what the device lacks",
        cases.len() - skipped,
        device.driver,
        folder.display()
    ))
}

/// Renders the cases, compares each with its golden frame, prints one line per case, and writes the JUnit file. Returns
/// an error if a case failed, or if no case was compared.
fn compare(args: &Args, cases: &[Case], device: &DeviceInfo, interrupt: &Interrupt) -> Result<()> {
    let began = Instant::now();
    let (goldens, own) = Goldens::find(&args.folder, device)?;
    let exact = own || args.exact;
    check_folder(&args.output)?;
    // Damage is found before minutes of work.
    for case in cases {
        goldens.case(case)?;
    }
    if let Some(revision) = goldens.other_revision() {
        notice(&format!(
            "revision {revision} of Headwater made these golden frames, and this is another one: differences may be changes of Headwater"
        ));
    }
    print(format_args!(
        "golden frames of {} driver, {} ({}): {}",
        if own { "this" } else { "another" },
        printable(&goldens.driver),
        printable(&goldens.device),
        match exact {
            true => "every bit must be the same",
            false => "pictures must agree except for rounding",
        }
    ))?;
    let mut results = Vec::new();
    let write_report = |results: &[_], running: Option<&str>| match &args.junit {
        Some(path) => {
            let xml = report(&device.driver, results, running)?;
            write_atomically(path, |file| writeln!(file, "{xml}"))
        }
        None => Ok(()),
    };
    for case in cases {
        write_report(&results, Some(&case.name))?;
        let start = Instant::now();
        // First, so that it is known which case a driver crashes in.
        print_part(&case.name)?;
        let verdict = compare_case(args, case, device, (&goldens, own, exact), interrupt)?;
        let (word, why) = match &verdict {
            Verdict::Passed(found) => ("ok", found),
            Verdict::Failed(why) => ("FAIL", why),
            Verdict::Skipped(why) => ("skip", why),
        };
        let colon = if why.is_empty() { "" } else { ": " };
        print(format_args!(" {word}{colon}{}", printable(why)))?;
        results.push((case.name.clone(), verdict, start.elapsed()));
    }
    write_report(&results, None)?;
    summarise(&results, began.elapsed())
}

/// Checks, before minutes of work, that files can be written to the folder at this path, or that the folder can be
/// created. It creates neither.
fn check_folder(folder: &Path) -> Result<()> {
    let there = folder.ancestors().find(|path| path.exists());
    if let Some(file) = there.filter(|path| !path.is_dir()) {
        return Err(Error::writing(file, "it is a file; name a folder"));
    }
    // A relative path begins in this folder.
    check_writable(&there.unwrap_or(Path::new(".")).join(".headwater"))
}

/// Prints the last line, which counts the passed, skipped and failed cases and shows the total `time`. `results` has
/// one entry per case: its name, its verdict and its duration. Returns an error if a case failed, or if all cases were
/// skipped, because then nothing was tested.
fn summarise(results: &[(String, Verdict, Duration)], time: Duration) -> Result<()> {
    let names = |is: fn(&Verdict) -> bool| -> Vec<&str> {
        let found = results.iter().filter(|(_, verdict, _)| is(verdict));
        found.map(|(name, ..)| name.as_str()).collect()
    };
    let failed = names(|verdict| matches!(verdict, Verdict::Failed(_)));
    let skipped = names(|verdict| matches!(verdict, Verdict::Skipped(_))).len();
    print(format_args!(
        "{} cases in {:.0} s: {} ok, {skipped} skipped, {} failed",
        results.len(),
        time.as_secs_f64(),
        results.len() - skipped - failed.len(),
        failed.len()
    ))?;
    if skipped == results.len() {
        return Err(Error::failed("no case was compared"));
    }
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Error::failed(format!("failed: {}", failed.join(", ")))),
    }
}

/// Renders a case and compares it with its golden frame. If `exact` is true, every bit must be equal; otherwise the pictures
/// may differ by rounding. `own` is true if the golden frames were made with this driver; only then does a case without a
/// golden frame fail. If the driver fails, the case counts as failed, so that the other cases still run.
fn compare_case(
    args: &Args,
    case: &Case,
    device: &DeviceInfo,
    (goldens, own, exact): (&Goldens, bool, bool),
    interrupt: &Interrupt,
) -> Result<Verdict> {
    let rendered = OpenCase::with(args, case, device, interrupt, OpenCase::render);
    let mut rendered = match rendered {
        Ok(Ok(rendered)) => rendered,
        Ok(Err(lacks)) if exact && goldens.cases.contains_key(&case.name) => {
            return Ok(Verdict::Failed(format!(
                "{lacks}, which the driver of the golden frame had"
            )));
        }
        Ok(Err(lacks)) => return Ok(Verdict::Skipped(lacks)),
        // What the driver does wrong concerns this case; the others are still to be seen.
        Err(Error::Failed(why)) => {
            return Ok(Verdict::Failed(format!("{why}; {}", again(args, case))));
        }
        Err(error) => return Err(error),
    };
    let Some((golden, picture)) = goldens.case(case)? else {
        return Ok(match own {
            true => Verdict::Failed("it has no golden frame; --bless makes one".into()),
            false => Verdict::Skipped("the other driver has no golden frame of it".into()),
        });
    };
    let mut verdict = match exact {
        true => judge_exactly(&rendered, golden, &picture),
        false => judge_loosely(&rendered, golden, &picture)?,
    };
    // Only further seeds can tell a wrong level from noise. They take longer, and most cases do not need them.
    if !exact && matches!(verdict, Verdict::Failed(_)) {
        match OpenCase::with(args, case, device, interrupt, OpenCase::levels) {
            Ok(Ok(levels)) => {
                rendered.levels = levels;
                verdict = judge_loosely(&rendered, golden, &picture)?;
            }
            // The driver fails now and then: the first verdict holds.
            Ok(Err(_)) | Err(Error::Failed(_)) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(match verdict {
        Verdict::Failed(why) => {
            keep_pictures(&args.output, case, &rendered.image, &picture)?;
            let folder = args.output.display();
            Verdict::Failed(format!(
                "{why}; pictures in {folder}; {}",
                again(args, case)
            ))
        }
        verdict => verdict,
    })
}

/// The shell command with which the user can render a case again, for the message about its failure.
fn again(args: &Args, case: &Case) -> String {
    let validation = if args.validate {
        "HEADWATER_VALIDATION=1 "
    } else {
        ""
    };
    let device = (args.device.as_ref()).map(|device| format!(" --device '{device}'"));
    format!(
        "again: {validation}headwater render {}{} -o {}.exr",
        case.command(),
        device.unwrap_or_default(),
        case.name
    )
}

/// A case whose scene is loaded and whose renderer is built, before its first frame.
struct OpenCase<'a> {
    session: Session,
    args: render::Args,
    interrupt: &'a Interrupt,
}

impl<'a> OpenCase<'a> {
    /// Opens a case, and returns the result of `work` with it. If the device lacks a feature that the case requests, the
    /// result is `Ok(Err(text))`, where the text is a sentence that names the feature.
    fn with<T>(
        args: &Args,
        case: &Case,
        device: &DeviceInfo,
        interrupt: &'a Interrupt,
        work: impl FnOnce(Self) -> Result<T>,
    ) -> Result<std::result::Result<T, String>> {
        interrupt.check(NOTHING_WRITTEN)?;
        let arguments = case.command();
        let words = ["render", "--output", "picture.exr"]
            .into_iter()
            .chain(arguments.split_whitespace());
        let line = Line::try_parse_from(words)
            .map_err(|e| Error::failed(format!("case {}: {e}", case.name)))?;
        let mut render = line.args;
        let scene = &mut render.scene;
        scene.view.device = args.device.clone();
        if let Some(lacks) = lacks(device, &scene.view.variant.request()) {
            return Ok(Err(lacks));
        }
        let (settings, _) = scene.settings()?;
        let clock = scene.view.clock(render.fps)?;
        let purpose = Purpose::Regression {
            validate: args.validate,
        };
        let frames = 0..render.frames.unwrap_or(1);
        let session = Session::open(scene, settings, clock, purpose, frames, interrupt)?;
        work(Self {
            session,
            args: render,
            interrupt,
        })
        .map(Ok)
    }

    /// Renders all frames of the case, in order. After each frame, calls `after` with the session and the
    /// index of the frame.
    fn frames(&mut self, mut after: impl FnMut(&mut Session, u32)) -> Result<()> {
        for index in 0..self.args.frames.unwrap_or(1) {
            self.interrupt.check(NOTHING_WRITTEN)?;
            self.session.frame(index, self.args.accumulate)?;
            after(&mut self.session, index);
        }
        Ok(())
    }

    /// Renders all frames of the case as the command `render` does, and returns the picture: the last frame,
    /// or the mean of all frames if the case has `--accumulate`.
    fn picture(&mut self) -> Result<Image> {
        self.frames(|_, _| ())?;
        let samples = match self.args.accumulate {
            true => self.args.frames.unwrap_or(1),
            false => {
                self.session.renderer.keep_single_frame()?;
                1
            }
        };
        let sums = self.session.renderer.sums()?;
        self.session.picture(&sums, samples, &self.args.scene.aov)
    }

    /// Renders the case first as usual, to get the picture, and then pass by pass, to hash each buffer that a pass may
    /// write. No other frames may have run: passes leave parts of some buffers as earlier frames wrote them.
    fn render(mut self) -> Result<Rendered> {
        let image = self.picture()?;
        self.session.restart_with_hashes()?;
        let mut steps = Vec::new();
        self.frames(|session, index| {
            let outputs = session.device.records.take_outputs().into_iter();
            steps.extend(outputs.map(|output| Step::of(index, output)));
        })?;
        self.session.finish()?;
        Ok(Rendered {
            levels: vec![level(&image)?],
            image,
            steps,
        })
    }

    /// Renders the case with [`SEEDS`] consecutive seeds, beginning with its own one, and returns the level
    /// (the mean of R + G + B) of each picture. Their spread shows whether a difference of levels is only
    /// noise.
    fn levels(mut self) -> Result<Vec<f64>> {
        let first = self.session.view.seed;
        let seeds = (0..SEEDS).map(|further| {
            self.session.renderer.restart(first.wrapping_add(further))?;
            level(&self.picture()?)
        });
        let levels = seeds.collect::<Result<_>>()?;
        self.session.finish()?;
        Ok(levels)
    }
}

/// A sentence about the first feature that the arguments of a case request and the device lacks; such a case cannot be
/// rendered. `None` if the device lacks none.
fn lacks(device: &DeviceInfo, request: &Request) -> Option<String> {
    let lacking = [
        (
            request.tracer == Some(Tracer::RayQuery) && !device.ray_query,
            "ray query",
        ),
        (
            request.geometry == Some(GeometryAccess::BufferAddresses) && !device.buffer_addresses,
            "buffer addresses",
        ),
        (
            request.textures == Some(Textures::Images) && !device.image_arrays,
            "arrays of images",
        ),
    ];
    let found = lacking.into_iter().find(|(lacks, _)| *lacks);
    found.map(|(_, what)| format!("the device has no {what}"))
}

/// Writes three files to `folder`, so that the user can see what is wrong: the picture of a failed case, the golden
/// picture, and a map of their FLIP difference (as a viewer perceives it). The map is left out if the sizes differ or a
/// value of the picture is not finite.
fn keep_pictures(folder: &Path, case: &Case, picture: &Image, golden: &Image) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::writing(folder, e))?;
    let file = |what: &str| folder.join(format!("{}{what}", case.name));
    picture.write(&file(".exr"), 0.0)?;
    golden.write(&file("-golden.exr"), 0.0)?;
    let size = (picture.width, picture.height);
    let (now, before) = (picture.rgb()?, golden.rgb()?);
    if size == (golden.width, golden.height) && now.iter().flatten().all(|v| v.is_finite()) {
        let difference = flip(&now, &before, size, 0.0);
        png::write_bytes(&file("-difference.png"), size, &difference.map)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::choices::JitterArg;

    #[test]
    fn every_case_is_a_command() {
        for case in cases().unwrap() {
            let arguments = case.command();
            let words = ["render", "--output", "a.exr"]
                .into_iter()
                .chain(arguments.split_whitespace());
            let line = Line::try_parse_from(words).unwrap_or_else(|e| panic!("{}: {e}", case.name));
            let settings = line.args.scene.settings();
            settings.unwrap_or_else(|e| panic!("{}: {e}", case.name));
            let jitters = line.args.scene.view.jitter == JitterArg::On;
            assert_eq!(
                jitters,
                case.arguments.contains("--jitter"),
                "{}",
                case.name
            );
        }
    }
}
