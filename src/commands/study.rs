//! `study`: renders configurations (settings with a name) on scenes, with several seeds and frames, and compares the
//! frames with references, to measure their errors and to find out whether a configuration is biased.

mod list;
mod machine;
mod merge;

use super::arguments::check_files;
use super::choices::{LoadArgs, TracerArg};
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::{NOTHING_WRITTEN, check_messages, notice, open_vulkan, print};
use crate::scene::Environment;
use crate::scene_files::check_name;
use crate::study::folder::Folder;
use crate::study::forecast::Forecast;
use crate::study::ledger::Ledger;
use crate::study::library::Library;
use crate::study::manifest::{Manifest, Request};
use crate::study::outputs::{Outputs, Results};
use crate::study::pages::Pages;
use crate::study::pictures::Pictures;
use crate::study::plan::{Plan, Resolved, rendered_on};
use crate::study::results::Row;
use crate::study::results_text;
use crate::study::shard::Shard;
use crate::study::store::Store;
use crate::study::subject::Subject;
use crate::study::work::{Site, Stage, Work};
use crate::{Error, Result};
use machine::{Machine, camera_override};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The interval between two writes of the result files while a study is running.
const WRITE_EVERY: Duration = Duration::from_secs(5);

/// The largest part of the time that a study spends on writing its result files while it is running, as a fraction.
const WRITING_FRACTION: f64 = 0.05;

/// The largest part of the device's memory that the scenes of a study fill together, as a fraction. Scenes beyond it are
/// loaded again at each stage.
const MEMORY_FRACTION: f64 = 0.25;

/// The command-line arguments of `headwater study`, which choose the plan, the part of its work, and the
/// folder for the results.
#[derive(clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    disable_help_subcommand = true
)]
pub struct Args {
    #[command(subcommand)]
    action: Option<Action>,
    /// The scenes to study, by name or file, instead of the scenes of the plan; without them, all scenes of the plan
    /// are studied
    scenes: Vec<String>,
    /// The folder for results, pages (index.html), references and finished runs; a study continues with the finished runs in it
    #[arg(short, long, value_name = "DIR", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// The plan, which lists configurations and scenes: the name of one that comes with the program (see --list), or a
    /// TOML file
    #[arg(long, value_name = "NAME|FILE.toml", default_value = "presets")]
    plan: String,
    /// Print the plans that come with the program: the question of each, its numbers of scenes, configurations and runs,
    /// and a rough time
    #[arg(long)]
    list: bool,
    /// Do only the part K of N of the work, with K from 1 to N; each part needs a folder of its own, and 'headwater study
    /// merge' joins the folders
    #[arg(long, value_name = "K/N", allow_hyphen_values = true)]
    shard: Option<String>,
    /// Options for loading the scene: missing files, files outside of its folder, and the variant of its materials
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
    #[command(flatten)]
    device: DeviceArgs,
}

/// The arguments that choose the device, and how it traces rays.
#[derive(Clone, Debug, clap::Args)]
struct DeviceArgs {
    /// The Vulkan device to use: its name, a part of its name, or its index in 'headwater info'; without it, the best
    /// one: discrete GPUs first, CPUs last
    #[arg(long, value_name = "NAME|INDEX", env = "HEADWATER_DEVICE")]
    device: Option<String>,
    /// The method that traces rays
    #[arg(long, value_enum, default_value_t = TracerArg::Auto)]
    tracer: TracerArg,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Join the folders of the shards of a study to one folder with the results of the whole study
    Merge(merge::Args),
}

/// Renders the runs that the folder of `--output` does not contain yet. A run is one configuration on one
/// scene with one seed, over all its frames. Then judges the results of all runs, writes them to the folder,
/// and prints them. With `merge` or `--list`, joins shards or lists the plans instead.
///
/// # Errors
/// Wrong arguments or a wrong plan; a device or disk that fails; a signal; or a configuration that is biased although the
/// plan expects it to be unbiased, whose shaders rejected values such as NaN, or that gives another picture when a seed is
/// repeated.
pub fn run(args: &Args) -> Result<()> {
    if let Some(Action::Merge(merge)) = &args.action {
        return merge::run(merge);
    }
    if args.list {
        return list::run();
    }
    let Some(folder) = &args.output else {
        return Err(Error::input("study needs --output DIR"));
    };
    let shard = args
        .shard
        .as_deref()
        .map_or(Ok(Shard::WHOLE), Shard::parse)?;
    let request = Request {
        plan: args.plan.clone(),
        text: Plan::read(&args.plan)?,
        scenes: args.scenes.clone(),
        environment: args.environment.clone(),
        bounces: args.bounces,
        quick: args.quick,
    };
    conduct(folder, request, shard, &args.load, &args.device, None)
}

/// Renders the part `shard` of the study that `request` describes, and writes its results to `folder`.
/// `merged` describes the shards that were joined in the folder; it is `None` for a study without a merge.
/// Returns an error if the shards were rendered under other conditions, for example by another device or
/// driver.
fn conduct(
    folder: &Path,
    request: Request,
    shard: Shard,
    load: &LoadArgs,
    device: &DeviceArgs,
    merged: Option<&Manifest>,
) -> Result<()> {
    let interrupt = Interrupt::watch()?;
    let (plan, configurations) = request.plan()?;
    // What may be wrong is found before hours of work on the scenes before it.
    for planned in &plan.scenes {
        check_name(&planned.name)?;
        (planned.environment.as_deref()).map_or(Ok(()), Environment::check_name)?;
        camera_override(planned)?;
    }
    let instance = open_vulkan(crate::gpu::InstanceOptions::default())?;
    let (info, _) = instance.choose(device.device.as_deref())?;
    let folder = Folder::open(folder)?;
    let mut manifest = Manifest::new(request, &info.name, &info.driver, shard);
    if let Some(why) = merged.and_then(|merged| merged.difference(&manifest)) {
        return Err(Error::input(format!(
            "the shards were merged, but what depends on all results cannot be rendered here: {why}; --no-render leaves it out",
        )));
    }
    let old = check_folder(&folder, &manifest)?;
    if let Some(old) = old.filter(|old| old.renders_like(&manifest)) {
        manifest.scenes = old.scenes;
    }
    let outputs = Outputs::new(folder.path());
    let pages = Pages::new(folder.path(), &plan);
    let files: Vec<PathBuf> = (outputs.files().into_iter()).chain(pages.files()).collect();
    let is_new = files
        .iter()
        .chain([&folder.manifest()])
        .all(|file| !file.exists());
    check_files(files.iter().map(|file| ("a result", file.as_path())), [])?;
    let mut ledger = Ledger {
        store: Store::open(&folder.runs())?,
        library: Library::new(folder.references()),
        pictures: Pictures::new(folder.pictures()),
        forecast: Forecast::default(),
    };
    let mut study = Study {
        plan: &plan,
        configurations: &configurations,
        manifest,
        folder: &folder,
        outputs,
        pages,
        interrupt: &interrupt,
        progress: Progress::of_whole("the study"),
        is_merged: merged.is_some(),
        written: None,
        pages_written: None,
    };
    let own: Vec<Vec<&Resolved>> = (plan.scenes.iter())
        .map(|planned| rendered_on(&configurations, &planned.name).collect())
        .collect();
    let sites: Vec<Site<'_>> = (0..)
        .zip(plan.scenes.iter().zip(&own))
        .map(|(index, (planned, configurations))| Site {
            plan: &plan,
            index,
            planned,
            configurations,
            shard,
        })
        .collect();
    for site in &sites {
        site.forecast(&mut ledger);
    }
    let machine = Machine {
        folder: &folder,
        instance: &instance,
        info: &info,
        load,
        tracer: device.tracer,
    };
    let rendered = study.render(&mut ledger, &sites, &machine);
    if rendered.is_err() && is_new && !folder.holds_results() {
        // Tables without a single result would keep the folder.
        study.remove();
    }
    rendered?;
    study.progress.finish();
    let results = study.results(&mut ledger)?;
    study.write_pages(&results, &mut ledger)?;
    report(&results, shard)?;
    check_messages(&instance.validation_messages())
}

/// Prints the results. For a whole study, returns an error if a row has a fault, such as a bias that the plan
/// does not expect. A shard has no verdicts, because these depend on the runs of all shards.
fn report(results: &Results, shard: Shard) -> Result<()> {
    let Results { rows, costs } = results;
    print(results_text::table(rows).trim_end())?;
    print(results_text::costs(costs, rows).trim_end())?;
    if shard.is_whole() {
        return verdict(rows);
    }
    notice(&format!(
        "this is shard {} of {}; 'headwater study merge' joins the folders of all",
        shard.index + 1,
        shard.count
    ));
    Ok(())
}

/// Reads the description of the study that the folder already has; `None` if it has none. Returns an error if
/// that study has no row in common with the one of `manifest`, or is another shard, because its results would
/// be overwritten.
fn check_folder(folder: &Folder, manifest: &Manifest) -> Result<Option<Manifest>> {
    let Some(old) = Manifest::read(&folder.manifest())? else {
        return Ok(None);
    };
    let path = folder.path().display();
    if old.shard != manifest.shard {
        return Err(Error::input(format!(
            "{path} has the shard {}/{} of a study; name another folder with --output",
            old.shard.index + 1,
            old.shard.count
        )));
    }
    let names = |manifest: &Manifest| -> Vec<(String, String)> {
        let Ok((plan, configurations)) = manifest.request.plan() else {
            return Vec::new();
        };
        let cells = plan.scenes.iter().flat_map(|scene| {
            let own = rendered_on(&configurations, &scene.name);
            own.map(|c| (scene.name.clone(), c.name.clone()))
        });
        cells.collect()
    };
    let (before, now) = (names(&old), names(manifest));
    if before.is_empty() || before.iter().any(|cell| now.contains(cell)) {
        return Ok(Some(old));
    }
    Err(Error::input(format!(
        "{path} has the results of other scenes or configurations (plan {}), which would be replaced; name another folder with --output",
        old.request.plan
    )))
}

/// A study that is running: its plan and configurations, its folder, and the writers of its result files and
/// pages.
struct Study<'a> {
    plan: &'a Plan,
    configurations: &'a [Resolved],
    manifest: Manifest,
    folder: &'a Folder,
    outputs: Outputs,
    pages: Pages,
    interrupt: &'a Interrupt,
    progress: Progress,
    /// True if the runs come from shards, which other machines may have rendered. Then a scene that differs
    /// on this machine is an error.
    is_merged: bool,
    /// The time at which the result files were last written, and the duration of this write; `None` before
    /// the first write. They decide when the files are written again.
    written: Option<(Instant, Duration)>,
    /// The time at which the pages were last written, and the duration of this write; `None` before the first
    /// write. Pages take longer than the result files, so they have their own interval.
    pages_written: Option<(Instant, Duration)>,
}

impl Study<'_> {
    /// Renders all missing runs and references: stage by stage, and within a stage scene by scene. At the
    /// end, does the work that depends on the results of all stages.
    fn render(
        &mut self,
        ledger: &mut Ledger,
        sites: &[Site<'_>],
        machine: &Machine<'_>,
    ) -> Result<()> {
        let most = (machine.info.device_memory as f64 * MEMORY_FRACTION) as u64;
        let mut kept: Vec<Option<Subject>> = sites.iter().map(|_| None).collect();
        let mut noted = vec![false; sites.len()];
        let stages = Stage::of(self.plan);
        self.manifest.write(&self.folder.manifest())?;
        // The last turn does what depends on the results of the stages.
        for stage in stages.into_iter().map(Some).chain([None]) {
            for (index, site) in sites.iter().enumerate() {
                let mut subject = match kept[index].take() {
                    Some(subject) => subject,
                    None => {
                        let is_first = !std::mem::replace(&mut noted[index], true);
                        machine.subject(self.plan, site, self.interrupt, is_first)?
                    }
                };
                if self.manifest.remember(&subject.identity) {
                    if self.is_merged {
                        return Err(Error::input(format!(
                            "scene {} or its shaders differ here from those that the shards rendered; --no-render leaves out what depends on all results",
                            site.planned.name
                        )));
                    }
                    self.manifest.write(&self.folder.manifest())?;
                    let results = self.results(ledger)?;
                    if self.pages_written.is_none() {
                        self.write_pages(&results, ledger)?;
                    }
                }
                let mut on_step = |ledger: &mut Ledger| self.step(ledger);
                let mut work = Work::new(*site, &mut subject, ledger, &mut on_step);
                match stage {
                    Some(stage) => work.stage(stage)?,
                    None => work.finish()?,
                }
                let others: u64 = kept.iter().flatten().map(Subject::memory).sum();
                if others + subject.memory() <= most {
                    kept[index] = Some(subject);
                }
            }
        }
        Ok(())
    }

    /// Called after each step of work: reports the progress, writes the result files if the last write is
    /// long ago, and returns an error after a signal, so that the study ends.
    fn step(&mut self, ledger: &mut Ledger) -> Result<()> {
        self.progress.at(ledger.forecast.fraction());
        if self.interrupt.pending().is_some() {
            let results = self.results(ledger)?;
            self.write_pages(&results, ledger)?;
            return self.interrupt.check(&kept(self.folder));
        }
        let is_due = |written: Option<(Instant, Duration)>| {
            written.is_none_or(|(at, took)| {
                at.elapsed() > WRITE_EVERY.max(took.div_f64(WRITING_FRACTION))
            })
        };
        if is_due(self.written) {
            let results = self.results(ledger)?;
            if is_due(self.pages_written) {
                self.write_pages(&results, ledger)?;
            }
        }
        Ok(())
    }

    /// Computes the results from the runs and references that are finished, writes the result files, and
    /// returns the results.
    fn results(&mut self, ledger: &mut Ledger) -> Result<Results> {
        let began = Instant::now();
        let work = (self.plan, self.configurations);
        let results = self.outputs.write(work, &self.manifest, ledger)?;
        self.written = Some((Instant::now(), began.elapsed()));
        Ok(results)
    }

    /// Writes the pages with `results`, which must be the newest results.
    fn write_pages(&mut self, results: &Results, ledger: &mut Ledger) -> Result<()> {
        let began = Instant::now();
        let work = (self.plan, self.configurations);
        self.pages.write(work, &self.manifest, results, ledger)?;
        self.pages_written = Some((Instant::now(), began.elapsed()));
        Ok(())
    }

    /// Removes the result files, the pages and the description of the study, when a new study ends without
    /// any result.
    fn remove(&self) {
        let files = self.outputs.files().into_iter().chain(self.pages.files());
        for file in files.chain([self.folder.manifest()]) {
            // What is not there need not be removed.
            let _ = std::fs::remove_file(file);
        }
    }
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
