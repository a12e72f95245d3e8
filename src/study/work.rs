//! The work of a study on one scene: the runs that are missing, more where the bias is not yet known
//! well enough, and what they say.

use super::bias::{self, Bias, CONFIRMING_SEEDS, Confirmation, WIDEST, WIDEST_REFERENCE};
use super::block_bias::BlockBias;
use super::plan::{Expect, Plan, Resolved};
use super::planned_scene::PlannedScene;
use super::reference::References;
use super::results::Row;
use super::store::Store;
use super::subject::Subject;
use crate::{Error, Result};
use std::ops::Range;

/// First seed of controls, and of the runs that decide after an alarm: far from all others.
const CONTROL_SEED: u32 = 1 << 20;
const CONFIRMING_SEED: u32 = 1 << 21;

/// Who waits for a study.
pub trait Watcher {
    /// `done` of `total` steps, called `unit`, are done; an error ends the study there.
    ///
    /// # Errors
    /// Those of whoever wants it to end.
    fn at(&self, unit: &'static str, done: u32, total: u32) -> Result<()>;
}

/// A plan's work on one scene.
pub struct Work<'a> {
    /// What is to be done.
    plan: &'a Plan,
    /// Samples a pixel of its references.
    reference_spp: u32,
    /// The scene.
    subject: Subject,
    /// Where finished runs are kept.
    store: &'a mut Store,
    /// Who waits.
    watcher: &'a dyn Watcher,
}

impl<'a> Work<'a> {
    /// The plan's work on one of its scenes, which `subject` shows. Finished runs are kept in `store`.
    pub fn new(
        plan: &'a Plan,
        planned: &PlannedScene,
        subject: Subject,
        store: &'a mut Store,
        watcher: &'a dyn Watcher,
    ) -> Self {
        Self {
            plan,
            reference_spp: planned.reference_spp.unwrap_or(plan.reference_spp),
            subject,
            store,
            watcher,
        }
    }

    /// Renders what is missing, and sums up each configuration in a row.
    ///
    /// # Errors
    /// The device or the disk fails, or the watcher ends it.
    pub fn rows(&mut self, configurations: &[&Resolved]) -> Result<Vec<Row>> {
        // Configurations take turns, so that what disturbs the machine disturbs all alike.
        self.run(configurations, 0..self.plan.seeds)?;
        let seeds = self.extend(configurations)?;
        (configurations.iter())
            .map(|configuration| self.row(configuration, seeds, configurations.len()))
            .collect()
    }

    /// Makes the references of `claims`, which are to be shown unbiased, and refuses those that leave the
    /// runs too little room in the interval that the bias check asks for.
    ///
    /// # Errors
    /// There is one, or those of [`Self::rows`].
    pub fn check_references(&mut self, claims: &[&Resolved]) -> Result<()> {
        let spp = self.reference_spp;
        for configuration in claims {
            let references = self.references(configuration)?;
            let reference = references.last();
            let width = reference.half_width();
            if width > WIDEST_REFERENCE {
                let needed = reference.samples_for(WIDEST_REFERENCE);
                return Err(Error::input(format!(
                    "scene {}: its reference of {spp} samples a pixel knows the mean to ±{:.2} % only; give it a reference_spp of about {:.0}",
                    self.subject.name,
                    100.0 * width,
                    needed.ceil()
                )));
            }
        }
        Ok(())
    }

    /// Renders further seeds of what is to be shown unbiased until its intervals are narrow. Returns
    /// how many seeds there may be.
    fn extend(&mut self, configurations: &[&Resolved]) -> Result<u32> {
        let mut seeds = self.plan.seeds;
        while seeds < self.plan.most_seeds() {
            let mut wide = Vec::new();
            for configuration in configurations {
                if configuration.expect == Expect::Unbiased
                    && self.bias(configuration, seeds)?.widest() > WIDEST
                {
                    wide.push(*configuration);
                }
            }
            if wide.is_empty() {
                break;
            }
            let more = (seeds + self.plan.seeds).min(self.plan.most_seeds());
            self.run(&wide, seeds..more)?;
            seeds = more;
        }
        Ok(seeds)
    }

    /// What one of `all` configurations came to with the seeds that there are.
    fn row(&mut self, configuration: &Resolved, seeds: u32, all: usize) -> Result<Row> {
        let key = self.subject.key(configuration)?;
        let bias = self.bias(configuration, seeds)?;
        let blocks_p_value = match configuration.expect {
            Expect::Unbiased => self.blocks_p_value(configuration)?,
            Expect::Biased => 1.0,
        };
        let references = self.references(configuration)?;
        let runs = self.store.of(&key, 0..seeds);
        let block_bias = BlockBias::measure(&runs, references.last());
        let name = &self.subject.name;
        let mut row = Row::new(name, configuration, &runs, bias, block_bias, blocks_p_value)?;
        if configuration.expect == Expect::Unbiased && row.alarms(all) {
            // Fewer could not see what the first ones saw.
            let count = CONFIRMING_SEEDS.max(row.bias.seeds as u32);
            let fresh = CONFIRMING_SEED..CONFIRMING_SEED + count;
            self.run(&[configuration], fresh.clone())?;
            let fresh = self.store.of(&key, fresh);
            row.rejected += fresh.iter().map(|run| u64::from(run.rejected)).sum::<u64>();
            row.confirmation = Some(Confirmation::measure(
                &self.store.of(&key, 0..seeds),
                &fresh,
                references.last(),
            ));
        }
        if let Some(first) = self.store.find(&key, 0) {
            let again = self.subject.repeat(configuration, 0, &references)?;
            row.replays = again.same_as(first);
            if configuration.count {
                row.counts = self.subject.counts(configuration, 0, &references)?;
            }
        }
        Ok(row)
    }

    /// Renders what is missing of some configurations' runs.
    fn run(&mut self, configurations: &[&Resolved], seeds: Range<u32>) -> Result<()> {
        let total = (seeds.len() * configurations.len()) as u32;
        let mut done = 0;
        for seed in seeds {
            for configuration in configurations {
                self.watcher.at("runs", done, total)?;
                let references = self.references(configuration)?;
                self.subject
                    .run(configuration, seed, &references, self.store)?;
                done += 1;
            }
        }
        self.watcher.at("runs", done, total)
    }

    fn references(&mut self, configuration: &Resolved) -> Result<References> {
        let (watcher, samples) = (self.watcher, self.reference_spp);
        self.subject.references(configuration, samples, &|done| {
            watcher.at("samples of the reference", done, samples)
        })
    }

    fn bias(&mut self, configuration: &Resolved, seeds: u32) -> Result<Bias> {
        let references = self.references(configuration)?;
        let key = self.subject.key(configuration)?;
        Ok(Bias::measure(
            &self.store.of(&key, 0..seeds),
            references.last(),
        ))
    }

    /// Compares the blocks with those of an unbiased control, of as many runs and of like noise.
    fn blocks_p_value(&mut self, configuration: &Resolved) -> Result<f64> {
        let seeds = self.plan.seeds;
        let own = self.subject.key(configuration)?;
        let control_seeds = CONTROL_SEED..CONTROL_SEED + self.plan.seeds;
        let single = bias::control(configuration, 1);
        self.run(&[&single], control_seeds.clone())?;
        let single = self.subject.key(&single)?;
        let samples = bias::control_samples(
            &self.store.of(&own, 0..seeds),
            &self.store.of(&single, control_seeds.clone()),
        );
        let control = bias::control(configuration, samples);
        self.run(&[&control], control_seeds.clone())?;
        let control = self.subject.key(&control)?;
        let references = self.references(configuration)?;
        Ok(bias::blocks_p_value(
            &self.store.of(&own, 0..seeds),
            &self.store.of(&control, control_seeds),
            references.last(),
        ))
    }
}
