//! `study`: configurations × scenes × seeds × frames against references.

use super::arguments::{parse_look_at, size_for};
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::{check_messages, notice, open_scene, open_vulkan, print};
use crate::files::write_atomically;
use crate::gpu::Device;
use crate::render::View;
use crate::scene::camera::framing_camera;
use crate::study::bias::{self, Bias, CONFIRMING_SEEDS, Confirmation, WIDEST};
use crate::study::plan::{Expect, Plan, PlannedScene, Resolved};
use crate::study::reference::Reference;
use crate::study::results::{self, Row};
use crate::study::store::Store;
use crate::study::subject::Subject;
use crate::tracing::SceneSizes;
use crate::tracing::selection::{self, TracerChoice};
use crate::{Error, Result};
use std::io::Write;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// First seed of controls, and of the runs that decide after an alarm: far from all others.
const CONTROL_SEED: u32 = 1 << 20;
const CONFIRMING_SEED: u32 = 1 << 21;

/// Arguments of `study`.
#[derive(clap::Args)]
pub struct Args {
    /// Scenes instead of the plan's
    scenes: Vec<String>,
    /// The folder for results, references and finished runs; a study goes on with what it finds there
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// What to render: a plan of the program's own, or a file
    #[arg(long, value_name = "NAME|FILE.toml", default_value = "bias-matrix")]
    plan: String,
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
    let mut plan = Plan::open(&args.plan)?;
    let configurations = plan.resolve()?;
    if !args.scenes.is_empty() {
        let wanted = |name: &String| {
            let planned = plan.scenes.iter().find(|scene| scene.name() == name);
            planned.cloned().unwrap_or(PlannedScene::Name(name.clone()))
        };
        plan.scenes = args.scenes.iter().map(wanted).collect();
    }
    if args.quick {
        plan.seeds = (plan.seeds / 4).max(2);
        plan.reference_spp = (plan.reference_spp / 4).max(2);
    }
    std::fs::create_dir_all(args.output.join("references"))
        .map_err(|e| Error::writing(&args.output, e))?;
    let instance = open_vulkan()?;
    let (info, _) = instance.choose(args.device.as_deref())?;
    let mut work = Work {
        store: Store::open(&args.output.join("runs.jsonl"))?,
        folder: args.output.clone(),
        interrupt: Interrupt::watch()?,
        plan: &plan,
    };
    let mut rows = Vec::new();
    for planned in &plan.scenes {
        let name = planned.name();
        let scene = open_scene(name, &work.interrupt)?;
        let selection = selection::select(&info, args.tracer, &SceneSizes::of(&scene))?;
        let device = Device::open(&instance, info.clone(), selection.features())?;
        let camera = match planned.look_at() {
            Some(text) => parse_look_at(text)?,
            None => (scene.cameras.first().cloned()).unwrap_or_else(|| framing_camera(&scene)),
        };
        let (width, height) = size_for(&camera, Some(plan.width), None)?;
        let view = View {
            camera,
            width,
            height,
            seed: 0,
            bounces: plan.bounces,
            jitter: false,
        };
        let references = args.output.join("references");
        let subject = Subject::new(name, &scene, view, &device, selection.variant, references)?;
        let own: Vec<&Resolved> = configurations.iter().filter(|c| c.is_for(name)).collect();
        rows.append(&mut work.study(subject, &own)?);
    }
    results::judge(&mut rows);
    let json = results::json(&rows, &info.name, &info.driver)?;
    write_atomically(&args.output.join("results.json"), |file| {
        writeln!(file, "{json:#}")
    })?;
    write_atomically(&args.output.join("results.csv"), |file| {
        write!(file, "{}", results::csv(&rows))
    })?;
    print(results::table(&rows).trim_end())?;
    verdict(&rows)?;
    check_messages(&instance.validation_messages())
}

/// An error if any row is not what it should be.
fn verdict(rows: &[Row]) -> Result<()> {
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

/// The work on one scene after another.
struct Work<'a> {
    store: Store,
    folder: PathBuf,
    interrupt: Interrupt,
    plan: &'a Plan,
}

impl Work<'_> {
    /// A row for each configuration on one scene.
    fn study(&mut self, mut subject: Subject, configurations: &[&Resolved]) -> Result<Vec<Row>> {
        if !subject.is_lit {
            notice(&format!("{}: the scene has no light", subject.name));
        }
        // Configurations take turns, so that what disturbs the machine disturbs all alike.
        self.run(&mut subject, configurations, 0..self.plan.seeds)?;
        let mut seeds = self.plan.seeds;
        while seeds < self.plan.most_seeds() {
            let mut wide = Vec::new();
            for configuration in configurations {
                if configuration.expect == Expect::Unbiased
                    && self.bias(&mut subject, configuration, 0..seeds)?.widest() > WIDEST
                {
                    wide.push(*configuration);
                }
            }
            if wide.is_empty() {
                break;
            }
            let more = (seeds + self.plan.seeds).min(self.plan.most_seeds());
            self.run(&mut subject, &wide, seeds..more)?;
            seeds = more;
        }

        let mut rows = Vec::new();
        for configuration in configurations {
            let key = subject.key(configuration)?;
            let bias = self.bias(&mut subject, configuration, 0..seeds)?;
            let blocks_p_value = match configuration.expect {
                Expect::Unbiased => self.blocks_p_value(&mut subject, configuration, 0..seeds)?,
                Expect::Biased => 1.0,
            };
            let mut row = Row::new(
                &self.store.of(&key, 0..seeds),
                configuration.settings.to_value()?,
                bias,
                blocks_p_value,
                configuration.expect,
            );
            if configuration.expect == Expect::Unbiased && row.alarms(configurations.len()) {
                let fresh = CONFIRMING_SEED..CONFIRMING_SEED + CONFIRMING_SEEDS;
                self.run(&mut subject, &[configuration], fresh.clone())?;
                let reference = self.reference(&mut subject, configuration)?;
                row.confirmation = Some(Confirmation::measure(
                    &self.store.of(&key, 0..seeds),
                    &self.store.of(&key, fresh),
                    &reference,
                ));
            }
            if let Some(first) = self.store.find(&key, 0).cloned() {
                let reference = self.reference(&mut subject, configuration)?;
                row.replays = subject.replays(configuration, &first, &reference)?;
            }
            rows.push(row);
        }
        Ok(rows)
    }

    /// Renders what is missing of some configurations' runs.
    fn run(
        &mut self,
        subject: &mut Subject,
        configurations: &[&Resolved],
        seeds: Range<u32>,
    ) -> Result<()> {
        let total = seeds.len() * configurations.len();
        let progress = Progress::new(Some(total as u64), "runs");
        let mut done = 0.0;
        for seed in seeds {
            for configuration in configurations {
                self.interrupt.check(&format!(
                    "{} keeps the finished runs; the same command goes on",
                    self.folder.display()
                ))?;
                let reference = self.reference(subject, configuration)?;
                subject.run(configuration, seed, &reference, &mut self.store)?;
                done += 1.0;
                progress.at(done);
            }
        }
        progress.finish();
        Ok(())
    }

    fn reference(&self, subject: &mut Subject, configuration: &Resolved) -> Result<Arc<Reference>> {
        let samples = self.plan.reference_spp;
        let progress = Progress::new(Some(u64::from(samples)), "samples of the reference");
        let reference = subject.reference(configuration.settings.energy, samples, &|done| {
            progress.at(f64::from(done));
        });
        progress.finish();
        reference
    }

    fn bias(
        &self,
        subject: &mut Subject,
        configuration: &Resolved,
        seeds: Range<u32>,
    ) -> Result<Bias> {
        let reference = self.reference(subject, configuration)?;
        let key = subject.key(configuration)?;
        Ok(Bias::measure(&self.store.of(&key, seeds), &reference))
    }

    /// Compares the blocks with those of an unbiased control, whose noise is made alike.
    fn blocks_p_value(
        &mut self,
        subject: &mut Subject,
        configuration: &Resolved,
        seeds: Range<u32>,
    ) -> Result<f64> {
        let own = subject.key(configuration)?;
        let control_seeds = CONTROL_SEED..CONTROL_SEED + self.plan.seeds;
        let single = bias::control(configuration, 1);
        self.run(subject, &[&single], control_seeds.clone())?;
        let single = subject.key(&single)?;
        let samples = bias::control_samples(
            &self.store.of(&own, seeds.clone()),
            &self.store.of(&single, control_seeds.clone()),
        );
        let control = bias::control(configuration, samples);
        self.run(subject, &[&control], control_seeds.clone())?;
        let control = subject.key(&control)?;
        let reference = self.reference(subject, configuration)?;
        Ok(bias::blocks_p_value(
            &self.store.of(&own, seeds),
            &self.store.of(&control, control_seeds),
            &reference,
        ))
    }
}
