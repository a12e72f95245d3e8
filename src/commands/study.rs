//! `study`: configurations × scenes × seeds × frames against references.

use super::arguments::size_for;
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::{open_scene, print};
use crate::files::write_atomically;
use crate::gpu::{Device, Instance};
use crate::render::{Renderer, View};
use crate::scene::camera::framing_camera;
use crate::study::bias;
use crate::study::plan::{Plan, Resolved};
use crate::study::reference::Reference;
use crate::study::results::{self, Row};
use crate::study::run::{self, Run};
use crate::tracing::GpuScene;
use crate::tracing::selection::{self, TracerChoice};
use crate::{Error, Result};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Arguments of `study`.
#[derive(clap::Args)]
pub struct Args {
    /// Scenes instead of the plan's
    scenes: Vec<String>,
    /// The folder for results, references and finished runs; a study goes on with what it finds there
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// What to render
    #[arg(long, value_name = "FILE.toml")]
    plan: PathBuf,
    /// A fourth of the seeds and of the references' samples: a first look, no proof
    #[arg(long)]
    quick: bool,
    /// The device, by name or index
    #[arg(long, value_name = "NAME|INDEX", env = "HEADWATER_DEVICE")]
    device: Option<String>,
    /// How rays are traced
    #[arg(long, value_enum, default_value_t = TracerChoice::Auto)]
    tracer: TracerChoice,
}

/// Renders what is missing, judges all, writes and prints.
///
/// # Errors
/// Wrong arguments or a wrong plan, a device or disk that fails, a signal, or a configuration that
/// should be unbiased and is not shown to be.
pub fn run(args: &Args) -> Result<()> {
    let origin = args.plan.display().to_string();
    let text = std::fs::read_to_string(&args.plan).map_err(|e| Error::reading(&args.plan, e))?;
    let mut plan = Plan::parse(&origin, &text)?;
    if !args.scenes.is_empty() {
        plan.scenes.clone_from(&args.scenes);
    }
    if args.quick {
        plan.seeds = (plan.seeds / 4).max(2);
        plan.reference_spp = (plan.reference_spp / 4).max(2);
    }
    let configurations = plan.resolve()?;
    std::fs::create_dir_all(args.output.join("references"))
        .map_err(|e| Error::writing(&args.output, e))?;
    let interrupt = Interrupt::watch()?;
    let instance =
        Instance::new(std::env::var_os("HEADWATER_VALIDATION").is_some_and(|v| v != "0"))?;
    let (info, _) = instance.choose(args.device.as_deref())?;
    let selection = selection::select(&info, args.tracer)?;
    let device = Device::open(&instance, info, selection.features())?;
    let mut store = Store::open(&args.output.join("runs.jsonl"))?;

    let mut rows = Vec::new();
    for name in &plan.scenes {
        let scene = open_scene(name)?;
        let camera = scene
            .cameras
            .first()
            .cloned()
            .unwrap_or_else(|| framing_camera(&scene));
        let (width, height) = size_for(&camera, Some(plan.width), None)?;
        let view = View {
            camera,
            width,
            height,
            seed: 0,
            bounces: plan.bounces,
            jitter: false,
        };
        let origin = view.camera.camera_to_world.translation;
        let uploaded = Arc::new(GpuScene::new(&device, &scene, origin, selection.variant)?);
        let hash = scene.content_hash();
        for configuration in &configurations {
            let progress = Progress::new(
                Some(u64::from(plan.reference_spp)),
                "samples of the reference",
            );
            let reference = Reference::obtain(
                &args.output.join("references"),
                &hash,
                &device,
                &uploaded,
                &view,
                &configuration.settings,
                plan.reference_spp,
                &|done| progress.at(u64::from(done)),
            )?;
            progress.finish();
            let key = key(
                &hash,
                &view,
                configuration,
                plan.frames,
                &device.info.driver,
            )?;
            let mut renderer = None;
            let progress = Progress::new(Some(u64::from(plan.seeds)), "seeds");
            for seed in 0..plan.seeds {
                if store.find(&key, seed).is_some() {
                    continue;
                }
                if let Some(signal) = interrupt.pending() {
                    let kept = format!(
                        "{} keeps the finished runs; the same command goes on",
                        args.output.display()
                    );
                    return Err(Error::Interrupted { signal, kept });
                }
                let renderer = match &mut renderer {
                    Some(renderer) => renderer,
                    none => none.insert(Renderer::new(
                        &device,
                        uploaded.clone(),
                        &view,
                        &configuration.settings,
                    )?),
                };
                let mut run = run::measure(renderer, plan.frames, seed, &reference)?;
                run.scene.clone_from(name);
                run.configuration.clone_from(&configuration.name);
                run.key.clone_from(&key);
                store.add(run)?;
                progress.at(u64::from(seed) + 1);
            }
            progress.finish();
            let runs: Vec<&Run> = (0..plan.seeds)
                .filter_map(|seed| store.find(&key, seed))
                .collect();
            let measured = bias::measure(&runs, &reference, None);
            rows.push(Row::new(
                &runs,
                configuration.settings.to_value()?,
                measured,
                configuration.expect,
            ));
        }
    }
    results::judge(&mut rows);
    let json = results::json(&rows, &device.info.name, &device.info.driver)?;
    write_atomically(&args.output.join("results.json"), |file| {
        writeln!(file, "{json:#}")
    })?;
    write_atomically(&args.output.join("results.csv"), |file| {
        write!(file, "{}", results::csv(&rows))
    })?;
    print(results::table(&rows).trim_end())?;
    let rejected: u64 = rows.iter().map(|r| r.rejected).sum();
    if rejected > 0 {
        return Err(Error::failed(format!(
            "{rejected} values were refused; see results.json"
        )));
    }
    let failed: Vec<String> = rows
        .iter()
        .filter(|row| !row.holds())
        .map(|row| format!("{} on {}", row.configuration, row.scene))
        .collect();
    if failed.is_empty() {
        Ok(())
    } else {
        Err(Error::failed(format!(
            "not shown to be unbiased: {}",
            failed.join(", ")
        )))
    }
}

/// What a run depends on beside its seed, hashed.
fn key(
    scene: &str,
    view: &View,
    configuration: &Resolved,
    frames: u32,
    driver: &str,
) -> Result<String> {
    let settings = configuration.settings.to_value()?;
    let shaders = std::env::var("HEADWATER_GLSL").unwrap_or_default();
    let text = format!(
        "{scene} {view:?} {settings} {frames} {driver} {shaders} {}",
        env!("HEADWATER_COMMIT")
    );
    Ok(blake3::hash(text.as_bytes()).to_hex()[..16].to_owned())
}

/// Finished runs, a line each; what a crash cut short is left out.
struct Store {
    path: PathBuf,
    runs: Vec<Run>,
}

impl Store {
    fn open(path: &Path) -> Result<Self> {
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(e) => return Err(Error::reading(path, e)),
        };
        Ok(Self {
            path: path.to_owned(),
            runs: text
                .lines()
                .filter_map(|line| serde_json::from_str(line).ok())
                .collect(),
        })
    }

    fn find(&self, key: &str, seed: u32) -> Option<&Run> {
        self.runs
            .iter()
            .find(|run| run.seed == seed && run.key == key)
    }

    fn add(&mut self, run: Run) -> Result<()> {
        let line = serde_json::to_string(&run)
            .map_err(|e| Error::failed(format!("a run as JSON: {e}")))?;
        let mut file = std::fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(&self.path)
            .map_err(|e| Error::writing(&self.path, e))?;
        // A line that a crash cut short must not swallow this one.
        writeln!(file, "\n{line}").map_err(|e| Error::writing(&self.path, e))?;
        self.runs.push(run);
        Ok(())
    }
}
