//! `statistics`: prints registers, memory and occupancy of every pass, as the driver's compiler reports them, to show
//! whether a change of shaders made them worse. No shader runs, and some drivers can compile shaders without their GPU.

use super::arguments::check_files;
use super::choices::{LoadArgs, TracerArg};
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::{NOTHING_WRITTEN, check_messages, notice, open_scene, open_vulkan, print};
use crate::base::files::write_atomically;
use crate::gpu::InstanceOptions;
use crate::procedural;
use crate::profile::statistics::{self, CONFIGURATIONS, Compiler, Pipeline};
use crate::scene_files::{check_name, file_of};
use crate::{Error, Result};
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The command-line arguments of `headwater statistics`, which choose the scenes, the device, and the
/// outputs.
#[derive(clap::Args)]
pub struct Args {
    /// The scenes for which passes are compiled: procedural scenes by name, or files, .gltf, .glb or .obj [default: every
    /// procedural scene]
    scenes: Vec<String>,
    /// Options for loading the scene: missing files, files outside of its folder, and the variant of its materials
    #[command(flatten)]
    load: LoadArgs,
    /// The method that traces rays; with auto, the passes are compiled for each method that the device supports
    #[arg(long, value_enum, default_value_t)]
    tracer: TracerArg,
    /// The Vulkan device to use: its name, a part of its name, or its index in 'headwater info'; without it, the best
    /// one: discrete GPUs first, CPUs last
    #[arg(long, value_name = "NAME|INDEX", env = "HEADWATER_DEVICE")]
    device: Option<String>,
    /// Print one JSON object instead of a table; the object lists every pipeline (a pass in one compiled form), the table
    /// only the pipeline with the lowest occupancy for each tracer and pass
    #[arg(long)]
    json: bool,
    /// Write the statistics of every pipeline to this file as JSON; statistics of other devices and drivers that it
    /// contains are kept
    #[arg(short, long, value_name = "FILE.json")]
    output: Option<PathBuf>,
    /// A file that --output has written: fail if a value, such as the number of registers, is worse than in this file;
    /// without it, nothing is compared
    #[arg(long, value_name = "FILE.json")]
    against: Option<PathBuf>,
}

/// Compiles the passes for each scene, tracer and configuration (settings with a name) without running them. Prints and
/// writes the values that the driver's compiler reports, and compares them with the values of the file of `--against`.
///
/// # Errors
/// Wrong arguments or input, a driver that reports nothing or rejects a shader, a disk that fails, a signal, or a value
/// that is worse than the stored one.
pub fn run(args: &Args) -> Result<()> {
    let scenes = match args.scenes.is_empty() {
        true => procedural::list()
            .iter()
            .map(|one| one.name.to_owned())
            .collect(),
        false => args.scenes.clone(),
    };
    if let Some(path) = &args.output {
        let read = scenes
            .iter()
            .filter_map(|scene| Some(("a scene", file_of(scene)?)));
        let stored = args.against.as_deref().map(|path| ("--against", path));
        check_files([("--output", path.as_path())], read.chain(stored))?;
    }
    let stored = args.against.as_deref().map(statistics::read).transpose()?;
    let others = match args.output.as_deref().filter(|path| path.is_file()) {
        Some(path) => statistics::read(path)?,
        None => Vec::new(),
    };
    for name in &scenes {
        check_name(name)?;
    }
    let interrupt = Interrupt::watch()?;
    let instance = open_vulkan(InstanceOptions::default())?;
    let (info, reason) = instance.choose(args.device.as_deref())?;
    log::info!("device: {} ({reason})", info.name);
    let mut compiler = Compiler::open(&instance, info)?;
    let tracers = match args.tracer.tracer() {
        None => compiler.tracers(),
        Some(one) => vec![one],
    };
    let all = scenes.len() * tracers.len() * CONFIGURATIONS.len();
    let progress = Progress::new(Some(all as u64), "scenes × settings");
    let mut done = 0;
    for name in &scenes {
        let scene = open_scene(name, args.load.options(), &interrupt)?;
        for text in &scene.notices {
            notice(text);
        }
        for tracer in &tracers {
            compiler.add(name, &scene, *tracer, &mut || {
                interrupt.check(NOTHING_WRITTEN)?;
                progress.at(f64::from(done));
                done += 1;
                Ok(())
            })?;
        }
    }
    progress.finish();
    let pipelines = compiler.finish();
    check_messages(&instance.validation_messages())?;
    if let Some(path) = &args.output {
        let text = statistics::json(&merge(others, &pipelines))?;
        write_atomically(path, |file| writeln!(file, "{text}"))?;
    }
    let worse = match (&stored, &args.against) {
        (Some(stored), Some(path)) => worse(&pipelines, stored, path),
        _ => Vec::new(),
    };
    match args.json {
        true => print(format_args!(
            "{:#}",
            json!({ "pipelines": pipelines, "worse": worse })
        ))?,
        false => {
            print(statistics::table(&pipelines))?;
            worse.iter().try_for_each(print)?;
        }
    }
    match worse.len() {
        0 => Ok(()),
        count => Err(Error::failed(format!(
            "{count} values are worse than the stored ones"
        ))),
    }
}

/// Joins the pipelines of an earlier output file, `others`, with the new `pipelines`, which replace those of the same
/// device and driver; so one file keeps the values of several devices. The result is sorted by driver, then by device.
fn merge(mut others: Vec<Pipeline>, pipelines: &[Pipeline]) -> Vec<Pipeline> {
    others.retain(|old| !pipelines.iter().any(|new| is_comparable(old, new)));
    others.extend_from_slice(pipelines);
    others.sort_by(|a, b| (&a.driver, &a.device).cmp(&(&b.driver, &b.device)));
    others
}

/// True if both pipelines were compiled by the same driver for the same device, by their names and the driver's
/// version. Values of other compilers or devices differ for other reasons than a change of shaders, and are not
/// compared.
fn is_comparable(a: &Pipeline, b: &Pipeline) -> bool {
    (&a.driver, &a.device) == (&b.driver, &b.device)
}

/// One line of text for each value of a pipeline, such as its number of registers, that is worse than that of its
/// counterpart in `stored`, the pipelines of the file at `path`. A counterpart has the same device, driver, pass and
/// tracer, and both were compiled for at least one common pair of scene and settings. A note on stderr states how many
/// pipelines have no counterpart. If the file has no pipeline of this device and driver, a note says so, and there are no
/// lines.
fn worse(pipelines: &[Pipeline], stored: &[Pipeline], path: &Path) -> Vec<String> {
    let Some(first) = pipelines.first() else {
        return Vec::new();
    };
    let own: Vec<&Pipeline> = stored
        .iter()
        .filter(|old| is_comparable(old, first))
        .collect();
    if own.is_empty() {
        notice(&format!(
            "not compared: {} has nothing of device '{}' with driver '{}'",
            path.display(),
            first.device,
            first.driver
        ));
        return Vec::new();
    }
    let compared = statistics::compare(pipelines, &own);
    if compared.without > 0 {
        notice(&format!(
            "not compared: {} pipelines, since {} has none of their pass, tracer, scenes and settings",
            compared.without,
            path.display()
        ));
    }
    compared.worse
}
