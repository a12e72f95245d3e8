//! The work of a study on one scene: renders the missing runs and the missing blocks of references. The work
//! has stages. In the first stage, each configuration gets a few runs and a coarse reference, so that all
//! rows have a first result soon.

use super::bias::{Bias, MAX_HALF_WIDTH, MAX_REFERENCE_HALF_WIDTH};
use super::cell::Cell;
use super::forecast::{Effort, Task};
use super::ledger::{Ledger, OnStep};
use super::library::BlockFile;
use super::pictures::PICTURED_SEED;
use super::plan::{Expect, Plan, Resolved};
use super::planned_scene::PlannedScene;
use super::reference::{MEASURING_BLOCKS, References, SampleBlocks};
use super::shard::Shard;
use super::subject::{Subject, path_tracing};
use crate::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::time::Instant;

/// The number of samples per pixel that the forecast of the study's duration assumes for controls, which are path tracing
/// for comparison with the blocks of a configuration. The real number is known only later, from the measured noise. This
/// constant changes no result.
const LIKELY_CONTROL_SAMPLES: u32 = 8;

/// A stage of a study. After it, each scene has at least the stated number of runs of each configuration, and
/// of blocks of references. The results become more precise from stage to stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// The number of runs of each configuration on each scene; their seeds are 0 to `seeds` − 1.
    pub seeds: u32,
    /// The fraction of the blocks of each reference, in [0, 1]. The first blocks, with which the errors of
    /// runs are measured, always belong to it.
    pub blocks: f64,
}

impl Stage {
    /// The stages of a plan, in their order: the first with two seeds, the second with a quarter of the
    /// plan's seeds, and the last with all. A stage without additional seeds is merged with the one before
    /// it.
    pub fn of(plan: &Plan) -> Vec<Self> {
        let mut stages: Vec<Self> = [(2, 0.0), (plan.seeds.div_ceil(4), 0.25), (plan.seeds, 1.0)]
            .map(|(seeds, blocks)| Self {
                seeds: seeds.min(plan.seeds),
                blocks,
            })
            .into();
        stages.dedup_by(|later, earlier| {
            let same = later.seeds <= earlier.seeds;
            if same {
                earlier.blocks = later.blocks;
            }
            same
        });
        stages
    }

    fn blocks_of(self, blocks: SampleBlocks) -> u32 {
        let part = (f64::from(blocks.count) * self.blocks).ceil() as u32;
        part.max(MEASURING_BLOCKS)
    }
}

/// One scene of a study, with the configurations that are rendered on it and the part of the work that this
/// process does.
#[derive(Clone, Copy)]
pub struct Site<'a> {
    /// The plan of the study, which states the numbers of seeds, frames and samples.
    pub plan: &'a Plan,
    /// The index of the scene in the plan, from 0. It takes part in the assignment of work to shards.
    pub index: u64,
    /// The scene with its camera and environment, as the plan describes it.
    pub planned: &'a PlannedScene,
    /// The configurations that are rendered on the scene, in the order of the plan.
    pub configurations: &'a [&'a Resolved],
    /// The shard that decides which runs and blocks of references this process renders.
    pub shard: Shard,
}

impl Site<'_> {
    /// The division of the samples of the scene's references into blocks: their size and their number, from
    /// the plan.
    fn blocks(&self) -> SampleBlocks {
        self.plan.blocks(self.planned)
    }

    fn task(&self, effort: Effort, configuration: &str) -> Task {
        Task {
            scene: self.planned.name.clone(),
            effort,
            configuration: configuration.to_owned(),
        }
    }

    /// Sets in the forecast the number of steps of all work on the scene, before any work begins, so that the first report
    /// of progress covers the whole study.
    pub fn forecast(&self, ledger: &mut Ledger) {
        let owned = |index: usize| {
            let seeds = 0..u64::from(self.plan.seeds);
            seeds.filter(|seed| self.owns(index, *seed)).count() as u64
        };
        for (index, configuration) in self.configurations.iter().enumerate() {
            let frames = u64::from(configuration.frames);
            let mut set = |effort, steps| {
                let task = self.task(effort, &configuration.name);
                ledger.forecast.set_to_come(task, steps);
            };
            set(Effort::Runs, owned(index) * frames);
            if self.owns(index, 0) {
                set(
                    Effort::Repeats,
                    (1 + u64::from(configuration.count)) * frames,
                );
            }
            if self.shard.is_whole() && configuration.expect == Expect::Unbiased {
                let samples = u64::from(1 + LIKELY_CONTROL_SAMPLES);
                set(Effort::Controls, samples * u64::from(self.plan.seeds));
            }
        }
        let blocks = self.blocks();
        let own = self.owned_blocks(blocks.count).len() as u64;
        // If nothing moves in the scene, all frames have the same one: then too many are expected until it is made.
        let others = self.plan.fps.map_or(0, |_| u64::from(self.plan.frames) - 1);
        let all = own + others * u64::from(MEASURING_BLOCKS);
        let samples = all * u64::from(blocks.size);
        (ledger.forecast).set_to_come(self.task(Effort::References, ""), samples);
    }

    /// True if this process renders the run with the seed `seed` of the configuration with the index `configuration`.
    fn owns(&self, configuration: usize, seed: u64) -> bool {
        self.shard.owns(&[self.index, configuration as u64, seed])
    }

    /// The indices, below `count`, of the blocks of a reference that this process renders: those of its
    /// shard, and the first blocks, which every shard needs to measure the errors of its runs.
    fn owned_blocks(&self, count: u32) -> Vec<u32> {
        let is_owned = |block: &u32| {
            *block < MEASURING_BLOCKS || self.shard.owns(&[self.index, u64::from(*block)])
        };
        (0..count).filter(is_owned).collect()
    }
}

/// The work on one scene of a study, with all that it needs: the scene on the device, the finished runs and
/// references, and the callback that reports progress.
pub struct Work<'a> {
    site: Site<'a>,
    subject: &'a mut Subject,
    ledger: &'a mut Ledger,
    on_step: &'a mut OnStep<'a>,
}

impl<'a> Work<'a> {
    /// Prepares the work on the scene `site`; `subject` is this scene on the device. Finished runs are taken from the store
    /// of `ledger`, and new ones are added to it.
    pub fn new(
        site: Site<'a>,
        subject: &'a mut Subject,
        ledger: &'a mut Ledger,
        on_step: &'a mut OnStep<'a>,
    ) -> Self {
        Self {
            site,
            subject,
            ledger,
            on_step,
        }
    }

    fn cell<'c>(site: Site<'c>, subject: &'c Subject, configuration: &'c Resolved) -> Cell<'c> {
        Cell {
            plan: site.plan,
            planned: site.planned,
            configuration,
            identity: &subject.identity,
        }
    }

    /// Corrects the forecast: sets the steps that are still to come to those of the missing runs and the
    /// missing blocks of references.
    fn correct_forecast(&mut self) -> Result<()> {
        let site = self.site;
        for (index, configuration) in site.configurations.iter().enumerate() {
            let cell = Self::cell(site, self.subject, configuration);
            let seeds = 0..site.plan.seeds;
            let done = cell.runs(&self.ledger.store, configuration, seeds.clone())?;
            let done: BTreeSet<u32> = done.iter().map(|run| run.seed).collect();
            let missing = seeds.filter(|s| site.owns(index, u64::from(*s)) && !done.contains(s));
            let steps = missing.count() as u64 * u64::from(configuration.frames);
            let task = site.task(Effort::Runs, &configuration.name);
            self.ledger.forecast.set_to_come(task, steps);
        }
        let mut samples = BTreeMap::new();
        let all = site.owned_blocks(site.blocks().count);
        for configuration in site.configurations {
            for (_, files) in self.reference_files(configuration, &all)? {
                let missing = files.into_iter().filter(|(path, _)| !path.exists());
                samples.extend(missing.map(|(path, samples)| (path, samples.len() as u64)));
            }
        }
        let task = site.task(Effort::References, "");
        (self.ledger.forecast).set_to_come(task, samples.values().sum());
        Ok(())
    }

    /// Renders the missing runs and the missing blocks of references of a stage. The configurations take
    /// turns, seed by seed.
    ///
    /// # Errors
    /// The device or the disk fails, a reference cannot be made or read, the scene cannot be rendered at the time of a
    /// frame, or the callback returns an error.
    pub fn stage(&mut self, stage: Stage) -> Result<()> {
        self.correct_forecast()?;
        let site = self.site;
        let blocks = site.owned_blocks(stage.blocks_of(site.blocks()));
        for configuration in site.configurations {
            self.references(configuration, &blocks)?;
        }
        let indexed: Vec<(usize, &Resolved)> =
            site.configurations.iter().copied().enumerate().collect();
        // Configurations take turns, so that a disturbance of the machine affects all of them.
        for seed in 0..stage.seeds {
            for (index, configuration) in &indexed {
                if site.owns(*index, u64::from(seed)) {
                    self.run(Effort::Runs, configuration, seed)?;
                }
            }
        }
        Ok(())
    }

    /// Renders what depends on the results of the stages: repetitions; more samples of references and more
    /// seeds, if the interval of a bias is too wide for a verdict; controls; and fresh seeds after an alarm.
    /// A shard renders only the repetitions, because it does not have the results of the other shards.
    ///
    /// # Errors
    /// As for [`Self::stage`].
    pub fn finish(&mut self) -> Result<()> {
        let site = self.site;
        for (index, configuration) in site.configurations.iter().enumerate() {
            if site.owns(index, 0) {
                self.repeat(configuration)?;
            }
        }
        let claims = site.configurations.iter().copied();
        let claims: Vec<&Resolved> = claims
            .filter(|c| site.shard.is_whole() && c.expect == Expect::Unbiased)
            .collect();
        for configuration in &claims {
            self.improve_reference(configuration)?;
        }
        self.extend(&claims)?;
        for configuration in &claims {
            self.control(configuration)?;
            self.confirm(configuration)?;
        }
        Ok(())
    }

    /// Renders the run with seed 0 again, to find data races. If the plan requests counts, renders it once
    /// more to count rays.
    fn repeat(&mut self, configuration: &Resolved) -> Result<()> {
        let cell = Self::cell(self.site, self.subject, configuration);
        let keys = cell.repeats()?;
        for (key, counts) in keys.into_iter().zip([false, true]) {
            if counts && !configuration.count || self.ledger.store.find(&key, 0).is_some() {
                continue;
            }
            self.measure(Effort::Repeats, configuration, 0, key, counts)?;
        }
        let task = self.site.task(Effort::Repeats, &configuration.name);
        self.ledger.forecast.set_to_come(task, 0);
        Ok(())
    }

    /// Adds samples to the reference of a configuration until its mean is known well enough for a verdict, or
    /// the reference has the plan's maximum number of samples.
    fn improve_reference(&mut self, configuration: &Resolved) -> Result<()> {
        let most = self.site.plan.most_blocks(self.site.blocks());
        let SampleBlocks { size, mut count } = self.site.blocks();
        loop {
            let references = self.known(configuration)?;
            let reference = references.last();
            // A study that was stopped in between ends with as many blocks as one that was not.
            let is_between = reference.samples > size * count;
            let is_enough = reference.half_width() <= MAX_REFERENCE_HALF_WIDTH;
            if count >= most || (is_enough && !is_between) {
                return Ok(());
            }
            count = (2 * count).min(most);
            let all: Vec<u32> = (0..count).collect();
            self.references(configuration, &all)?;
        }
    }

    /// Renders runs with further seeds of each configuration whose interval is too wide, until its half-width
    /// is at most [`MAX_HALF_WIDTH`] or the plan's maximum number of seeds is reached. A wider interval
    /// proves nothing.
    fn extend(&mut self, configurations: &[&Resolved]) -> Result<()> {
        let plan = self.site.plan;
        let mut seeds = plan.seeds;
        while seeds < plan.most_seeds() {
            let mut wide = Vec::new();
            for configuration in configurations {
                let references = self.known(configuration)?;
                let cell = Self::cell(self.site, self.subject, configuration);
                let runs = cell.runs(&self.ledger.store, configuration, 0..seeds)?;
                let bias = Bias::measure(&runs, references.last());
                if bias.largest_half_width() > MAX_HALF_WIDTH {
                    wide.push(*configuration);
                }
            }
            if wide.is_empty() {
                break;
            }
            let more = (seeds + plan.seeds).min(plan.most_seeds());
            self.turns(Effort::Runs, &wide, seeds..more)?;
            seeds = more;
        }
        Ok(())
    }

    /// Renders the controls of a configuration: first with one sample per pixel, then with as many samples as
    /// give the noise of the configuration.
    fn control(&mut self, configuration: &Resolved) -> Result<()> {
        let cell = Self::cell(self.site, self.subject, configuration);
        // The names of controls are their own.
        let task = self.site.task(Effort::Controls, &configuration.name);
        self.ledger.forecast.set_to_come(task, 0);
        let seeds = cell.control_seeds();
        let single = cell.controls(&self.ledger.store)?.single;
        self.turns(Effort::Controls, &[&single], seeds.clone())?;
        let cell = Self::cell(self.site, self.subject, configuration);
        if let Some(control) = cell.controls(&self.ledger.store)?.matching {
            self.turns(Effort::Controls, &[&control], seeds)?;
        }
        Ok(())
    }

    /// If the first runs of a configuration raise an alarm (a sign of bias), renders runs with fresh seeds, which then
    /// decide.
    fn confirm(&mut self, configuration: &Resolved) -> Result<()> {
        let all = self.site.configurations.len();
        let cell = Self::cell(self.site, self.subject, configuration);
        let row = cell.row(self.ledger, all)?;
        if row.alarms(all) && row.confirmation.is_none() {
            let fresh = Cell::confirming_seeds(row.seeds);
            self.turns(Effort::Runs, &[configuration], fresh)?;
        }
        Ok(())
    }

    /// Renders one run for each of the configurations and each seed in `seeds`, unless the store already has this run. For
    /// each seed, the configurations take turns, so that a disturbance of the machine affects the times of all of them.
    fn turns(
        &mut self,
        effort: Effort,
        configurations: &[&Resolved],
        seeds: Range<u32>,
    ) -> Result<()> {
        for configuration in configurations {
            let cell = Self::cell(self.site, self.subject, configuration);
            let done = cell.runs(&self.ledger.store, configuration, seeds.clone())?;
            let missing = seeds.len().saturating_sub(done.len());
            let steps = missing as u64 * u64::from(configuration.frames);
            let task = self.site.task(effort, &configuration.name);
            self.ledger.forecast.set_to_come(task, steps);
        }
        for seed in seeds {
            for configuration in configurations {
                self.run(effort, configuration, seed)?;
            }
        }
        Ok(())
    }

    /// Renders the run of a configuration with one seed, unless the store already has it.
    fn run(&mut self, effort: Effort, configuration: &Resolved, seed: u32) -> Result<()> {
        let cell = Self::cell(self.site, self.subject, configuration);
        let key = cell.key(configuration)?;
        if !cell
            .runs(&self.ledger.store, configuration, seed..seed + 1)?
            .is_empty()
        {
            return Ok(());
        }
        self.measure(effort, configuration, seed, key, false)
    }

    fn measure(
        &mut self,
        effort: Effort,
        configuration: &Resolved,
        seed: u32,
        key: String,
        counts: bool,
    ) -> Result<()> {
        let references = self.known(configuration)?;
        let start = Instant::now();
        let (run, frames) = (self.subject).run(configuration, seed, &references, counts)?;
        let cell = Self::cell(self.site, self.subject, configuration);
        let (own, size) = (cell.key(configuration)?, cell.identity.size);
        // Counting changes the shaders. A repetition makes only pictures that a study of an older version lacks.
        let has_picture = || key != own && self.ledger.pictures.read(&own, size).is_some();
        if seed == PICTURED_SEED && !counts && !has_picture() {
            self.ledger.pictures.write(&own, size, &frames)?;
        }
        self.ledger.store.add(super::run::Run { key, ..run })?;
        let task = self.site.task(effort, &configuration.name);
        let frames = u64::from(configuration.frames);
        self.ledger.forecast.done(task, frames, start.elapsed());
        (self.on_step)(self.ledger)
    }

    /// The references of a configuration, from the blocks that have files. Returns an error if files were
    /// removed during the study.
    fn known(&mut self, configuration: &Resolved) -> Result<References> {
        let cell = Self::cell(self.site, self.subject, configuration);
        cell.references(self.ledger)?.ok_or_else(|| {
            Error::failed(format!(
                "the references of scene {} were removed while the study was running",
                self.site.planned.name
            ))
        })
    }

    /// The times in the scene, in seconds, of the references of a configuration. Each has a list of the files
    /// of its blocks: for the last frame, the blocks with the indices `last`; for the other frames, only the
    /// first [`MEASURING_BLOCKS`].
    fn reference_files(
        &self,
        configuration: &Resolved,
        last: &[u32],
    ) -> Result<Vec<(f64, Vec<BlockFile>)>> {
        let blocks = self.site.blocks();
        let settings = path_tracing(&configuration.settings);
        let identity = &self.subject.identity;
        let times = identity.times(configuration);
        let others: Vec<u32> = (0..MEASURING_BLOCKS).collect();
        let files = times.iter().enumerate().map(|(index, time)| {
            let wanted = if index + 1 == times.len() {
                last
            } else {
                &others
            };
            let key = identity.reference_key(&settings, *time, blocks)?;
            let files = (self.ledger.library).files(&key, blocks, wanted.iter().copied());
            Ok((*time, files))
        });
        files.collect()
    }

    /// Renders the blocks of the references of a configuration that have no file yet. `last` has the indices
    /// of the blocks for the last frame; the other frames get only the first [`MEASURING_BLOCKS`].
    fn references(&mut self, configuration: &Resolved, last: &[u32]) -> Result<()> {
        let task = self.site.task(Effort::References, "");
        for (time, files) in self.reference_files(configuration, last)? {
            let (mut heard, mut before) = (Instant::now(), 0.0);
            let Self {
                subject,
                ledger,
                on_step,
                ..
            } = self;
            subject.render_reference(configuration, time, &files, &mut |samples| {
                let more = (samples - before).max(0.0).floor();
                if more > 0.0 {
                    let task = task.clone();
                    ledger.forecast.done(task, more as u64, heard.elapsed());
                    (heard, before) = (Instant::now(), before + more);
                }
                on_step(ledger)
            })?;
        }
        Ok(())
    }
}
