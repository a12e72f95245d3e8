//! `study`: renders configurations (settings with a name) on scenes, with several seeds and frames, and compares the
//! frames with references, to measure their errors and to find out whether a configuration is biased.

use super::arguments::{check_files, parse_look_at, size_for};
use super::choices::{LoadArgs, TracerArg};
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::{NOTHING_WRITTEN, apply_clock, check_messages, notice, open_vulkan, print};
use crate::base::files::write_atomically;
use crate::device_scene::SceneSizes;
use crate::device_scene::selection::{self, Request};
use crate::gpu::Device;
use crate::render::View;
use crate::render::settings::EnvironmentSettings;
use crate::scene::camera::framing_camera;
use crate::scene::{Camera, Environment, MovingCamera, Scene};
use crate::scene_files::check_name;
use crate::study::axes;
use crate::study::folder::Folder;
use crate::study::forecast::Forecast;
use crate::study::plan::{Expect, Plan, Resolved};
use crate::study::planned_scene::PlannedScene;
use crate::study::results::{Row, judge};
use crate::study::results_text;
use crate::study::store::Store;
use crate::study::subject::Subject;
use crate::study::work::{self, Work};
use crate::{Error, Result};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

/// The command-line arguments of `headwater study`.
#[derive(clap::Args)]
pub struct Args {
    /// The scenes to study, by name or file, instead of the scenes of the plan; without them, all scenes of the plan
    /// are studied
    scenes: Vec<String>,
    /// The folder for results, references and finished runs; a study continues with the finished runs in it
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// The plan, which lists configurations and scenes: the name of one that comes with the program, or a TOML file
    #[arg(long, value_name = "NAME|FILE.toml", default_value = "bias-matrix")]
    plan: String,
    /// Options that decide whether a scene may lack image files and may name files outside of its folder
    #[command(flatten)]
    load: LoadArgs,
    /// Light from infinitely far away, for all scenes: an image file, .exr or .hdr, or a sky such as sky:sun=40;
    /// without it, the plan decides for each scene
    #[arg(long, value_name = "FILE|sky:…")]
    environment: Option<String>,
    /// Maximum number of scattering events of a path, instead of the value in the plan; without it, the plan decides
    #[arg(long, allow_negative_numbers = true)]
    bounces: Option<u32>,
    /// Use a quarter of the seeds and a quarter of the references' samples per pixel, for a quick preview, which has too
    /// few data to prove that a configuration is unbiased
    #[arg(long)]
    quick: bool,
    /// The Vulkan device to use: its name, a part of its name, or its index in 'headwater info'; without it, the best
    /// one: discrete GPUs first, CPUs last
    #[arg(long, value_name = "NAME|INDEX", env = "HEADWATER_DEVICE")]
    device: Option<String>,
    /// The method that traces rays
    #[arg(long, value_enum, default_value_t = TracerArg::Auto)]
    tracer: TracerArg,
}

/// Renders the runs that the folder of `--output` does not hold yet. A run is one configuration on one scene with one seed,
/// over all its frames. Then judges the results of all runs, writes them to the folder, and prints them.
///
/// # Errors
/// Wrong arguments or a wrong plan; a device or disk that fails; a signal; or a configuration that is biased although the
/// plan expects it to be unbiased, whose shaders rejected values such as NaN, or that gives another picture when a seed is
/// repeated.
pub fn run(args: &Args) -> Result<()> {
    let interrupt = Interrupt::watch()?;
    let mut plan = Plan::open(&args.plan)?;
    plan.bounces = args.bounces.unwrap_or(plan.bounces);
    let configurations = plan.resolve()?;
    if !args.scenes.is_empty() {
        let wanted = |name: &String| {
            let planned = plan.scenes.iter().find(|scene| scene.name == *name);
            planned
                .cloned()
                .unwrap_or_else(|| PlannedScene::named(name))
        };
        plan.scenes = args.scenes.iter().map(wanted).collect();
    }
    for planned in &mut plan.scenes {
        planned.environment = args.environment.clone().or(planned.environment.take());
    }
    if let Some(one) =
        (configurations.iter()).find(|c| c.settings.environment != EnvironmentSettings::default())
    {
        return Err(Error::input(format!(
            "plan {}: configuration '{}' changes the environment, which all configurations of a scene share; give the scene another environment",
            args.plan, one.name
        )));
    }
    // What may be wrong is found before hours of work on the scenes before it.
    for planned in &plan.scenes {
        let name = &planned.name;
        check_name(name)?;
        planned
            .environment
            .as_deref()
            .map_or(Ok(()), Environment::check_name)?;
        camera_override(planned)?;
        if !configurations.iter().any(|c| c.is_for(name)) {
            return Err(Error::input(format!(
                "plan {}: none of its configurations is for scene '{name}'; name one of those in their scenes, or write a plan",
                args.plan
            )));
        }
    }
    if args.quick {
        plan.quicken();
    }
    let instance = open_vulkan(crate::gpu::InstanceOptions::default())?;
    let (info, _) = instance.choose(args.device.as_deref())?;
    let folder = Folder::open(&args.output)?;
    let files = ["results.json", "results.csv", "axes.svg"].map(|name| args.output.join(name));
    let written = files.each_ref().map(|file| ("a result", file.as_path()));
    let [json_file, csv_file, axes_file] = &files;
    check_files(written, [])?;
    let mut store = Store::open(&folder.runs())?;
    let check = || match interrupt.pending() {
        None => Ok(()),
        Some(_) => interrupt.check(&kept(&folder)),
    };
    let progress = Progress::of_whole("the study");
    let mut watch = |fraction: f64| {
        progress.at(fraction);
        check()
    };
    let own = |planned: &PlannedScene| -> Vec<&Resolved> {
        (configurations.iter())
            .filter(|c| c.is_for(&planned.name))
            .collect()
    };
    // References may load a scene before its runs do.
    let loaded = RefCell::new(BTreeSet::new());
    let subject = |planned: &PlannedScene| -> Result<Subject> {
        let name = &planned.name;
        let mut scene = Scene::open_watched(name, args.load.options(), &mut |_, _, _| check())?;
        scene.environment = (planned.environment.as_deref().map(Environment::open)).transpose()?;
        let clock = plan.clock();
        let own = own(planned);
        // As long as the scene moves: what does not shine now may do so at another time.
        if loaded.borrow_mut().insert(name.clone()) {
            let scatters = |c: &&Resolved| c.settings.scatters_light(plan.bounces);
            let frames = own.iter().map(|c| c.frames).max().unwrap_or(1);
            let times = (0..frames).map(|frame| clock.time(frame));
            if let Some(why) = scene.why_black(own.iter().any(scatters), times) {
                notice(&format!("{name}: {why}"));
            }
        }
        apply_clock(&clock, &mut scene, &format!("{name}: "))?;
        let wanted = Request {
            tracer: args.tracer.tracer(),
            ..Request::default()
        };
        let selection = selection::select(&info, wanted, &SceneSizes::of(&scene))?;
        let device = Device::open(&instance, info.clone(), selection.features())?;
        let (camera, moving) = camera(planned, &scene, clock.start_time)?;
        let (width, height) = size_for(&camera, Some(plan.width), None)?;
        let view = View {
            camera,
            width,
            height,
            seed: 0,
            bounces: plan.bounces,
            jitter: false,
        };
        let references = folder.references();
        Subject::new(
            name,
            &scene,
            view,
            moving,
            &device,
            selection.variant,
            references,
        )
    };
    let mut forecast = Forecast::default();
    for planned in &plan.scenes {
        work::forecast_scene(&mut forecast, &plan, planned, &own(planned));
    }
    // References first: one that knows too little would else be found out after hours of work on the
    // scenes before. A first look proves nothing in any case, nor does a scene without a claim.
    for planned in plan.scenes.iter().filter(|_| !args.quick) {
        let mut claims = own(planned);
        claims.retain(|c| c.expect == Expect::Unbiased);
        if !claims.is_empty() {
            let subject = subject(planned)?;
            Work::new(
                &plan,
                planned,
                subject,
                &mut store,
                &mut forecast,
                &mut watch,
            )
            .check_references(&claims)?;
        }
    }
    let mut rows = Vec::new();
    for planned in &plan.scenes {
        let subject = subject(planned)?;
        let mut work = Work::new(
            &plan,
            planned,
            subject,
            &mut store,
            &mut forecast,
            &mut watch,
        );
        rows.append(&mut work.rows(&own(planned))?);
    }
    progress.finish();
    judge(&mut rows);
    let json = results_text::json(&rows, &info.name, &info.driver)?;
    write_atomically(json_file, |file| writeln!(file, "{json:#}"))?;
    write_atomically(csv_file, |file| {
        write!(file, "{}", results_text::csv(&rows))
    })?;
    match axes::svg(&rows)? {
        Some(figure) => write_atomically(axes_file, |file| write!(file, "{figure}"))?,
        // The figure of an earlier plan would stand beside other results.
        None => match std::fs::remove_file(axes_file) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(Error::writing(axes_file, error));
            }
            _ => {}
        },
    }
    print(results_text::table(&rows).trim_end())?;
    verdict(&rows)?;
    check_messages(&instance.validation_messages())
}

/// A clause for the message after a signal: it states that the folder keeps the finished runs, or, if it has no results,
/// that nothing was written.
fn kept(folder: &Folder) -> String {
    if !folder.holds_results() {
        return NOTHING_WRITTEN.into();
    }
    format!(
        "{} keeps the finished runs; the same command continues",
        folder.path().display()
    )
}

/// The camera that the key `look_at` of a scene in the plan (the TOML file of the study) describes; it replaces the
/// cameras of the scene. `None` if the scene has no such key. Returns an error if its text describes no camera.
fn camera_override(planned: &PlannedScene) -> Result<Option<Camera>> {
    let origin = format!("{}: look_at", planned.name);
    (planned.look_at.as_deref())
        .map(|text| parse_look_at(&origin, text))
        .transpose()
}

/// The camera of a scene at `time`, in seconds: the one that the plan gives, else the scene's first one, else one that
/// sees the whole scene. The second value is the motion of the scene's first camera; it is `None` for the other two
/// cameras, which do not move.
fn camera(
    planned: &PlannedScene,
    scene: &Scene,
    time: f64,
) -> Result<(Camera, Option<MovingCamera>)> {
    if let Some(camera) = camera_override(planned)? {
        return Ok((camera, None));
    }
    if scene.cameras.is_empty() {
        return Ok((framing_camera(scene), None));
    }
    let moving = MovingCamera::of(scene, 0);
    Ok((moving.at(time)?, Some(moving)))
}

/// Returns an error that lists the rows with a fault. A row holds the results of one configuration on one scene. Its fault
/// is that shaders rejected values such as NaN, that a repeated seed gave another picture, or that it is biased although
/// the plan expects it to be unbiased. Also prints a note on rows that have too few data to prove that they are unbiased,
/// with the key of the plan that the user should raise.
fn verdict(rows: &[Row]) -> Result<()> {
    let open: Vec<String> = (rows.iter())
        .filter_map(|row| {
            let question = row.open_question()?;
            Some(format!(
                "{} on {} ({question})",
                row.configuration, row.scene
            ))
        })
        .collect();
    if !open.is_empty() {
        notice(&format!(
            "{} of {} rows are undecided: {}",
            open.len(),
            rows.len(),
            open.join(", ")
        ));
    }
    let failed: Vec<String> = (rows.iter())
        .filter_map(|row| {
            let complaint = row.complaint()?;
            Some(format!(
                "{} on {} ({complaint})",
                row.configuration, row.scene
            ))
        })
        .collect();
    if failed.is_empty() {
        return Ok(());
    }
    Err(Error::failed(format!(
        "{} of {} rows fail: {}",
        failed.len(),
        rows.len(),
        failed.join(", ")
    )))
}
