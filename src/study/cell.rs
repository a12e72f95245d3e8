//! One configuration on one scene of a study: makes the keys of its runs, and computes its row of results
//! from the finished runs and references.

use super::bias::{self, Bias, CONFIRMING_SEEDS, Confirmation};
use super::block_bias::BlockBias;
use super::identity::Identity;
use super::ledger::Ledger;
use super::plan::{Expect, Plan, Resolved};
use super::planned_scene::PlannedScene;
use super::reference::{References, SampleBlocks};
use super::results::{Findings, Row};
use super::run::Run;
use super::store::Store;
use crate::Result;
use std::ops::Range;

/// The first seed of the runs of controls. A control is path tracing with about as much noise as a configuration, and the
/// blocks of pixels of the configuration are compared with those of the control. The number is far from the seeds of other
/// runs, so that no seed has two uses.
const CONTROL_SEED: u32 = 1 << 20;
/// The first seed of the confirming runs. If the first runs raise an alarm, which is a sign of bias, the confirming runs
/// are made, and they alone decide whether the configuration is biased. Their seeds are far from all other seeds, so that
/// they are independent of the first runs.
const CONFIRMING_SEED: u32 = 1 << 21;

/// One configuration on one scene of a study. Its functions find the finished runs and references by their
/// keys, and compute the row of results from them.
#[derive(Clone, Copy)]
pub struct Cell<'a> {
    /// The plan of the study, which states the numbers of seeds.
    pub plan: &'a Plan,
    /// The scene in the plan; it can have its own number of samples per pixel for references.
    pub planned: &'a PlannedScene,
    /// The configuration, with complete settings.
    pub configuration: &'a Resolved,
    /// The hashes of everything that the runs and references of the scene depend on. The keys of stored runs
    /// and references are made from them.
    pub identity: &'a Identity,
}

/// The controls of a configuration: path tracing of the same light, which has no bias. The distribution of
/// the errors of its blocks of pixels is compared with that of the configuration.
pub struct Controls {
    /// Path tracing with one sample per pixel. From its noise, the number of samples of [`Self::matching`] is
    /// computed.
    pub single: Resolved,
    /// Path tracing with so many samples per pixel that it has about as much noise as the configuration.
    /// `None` until all runs are finished from which this number is computed.
    pub matching: Option<Resolved>,
}

impl<'a> Cell<'a> {
    /// The division of the samples of the scene's references into blocks: their size and their number, from
    /// the plan.
    pub fn blocks(&self) -> SampleBlocks {
        self.plan.blocks(self.planned)
    }

    /// The keys of the two repetitions of the run with seed 0: the first finds data races, and the second
    /// counts rays. The store has each under its key with seed 0.
    ///
    /// # Errors
    /// The settings have no JSON form, which cannot happen with finite numbers.
    pub fn repeats(&self) -> Result<[String; 2]> {
        let key = self.key(self.configuration)?;
        Ok([format!("{key}-repeat"), format!("{key}-counts")])
    }

    /// The key under which the store has the runs of `configuration`, which is that of the cell or a control
    /// of it.
    ///
    /// # Errors
    /// As for [`Self::repeats`].
    pub fn key(&self, configuration: &Resolved) -> Result<String> {
        self.identity.run_key(configuration, self.blocks())
    }

    /// The finished runs of `configuration` whose seeds are in `seeds`, in the order of their seeds. Damaged
    /// runs are left out.
    ///
    /// # Errors
    /// As for [`Self::repeats`].
    pub fn runs<'s>(
        &self,
        store: &'s Store,
        configuration: &Resolved,
        seeds: Range<u32>,
    ) -> Result<Vec<&'s Run>> {
        let (frames, blocks) = (configuration.frames as usize, self.identity.blocks());
        let mut runs = store.of(&self.key(configuration)?, seeds);
        runs.retain(|run| run.has_lengths(frames, blocks));
        Ok(runs)
    }

    /// The references with which the frames of the cell's runs are compared, from all blocks of samples that
    /// have files. `None` until the blocks exist with which the errors of runs are measured.
    ///
    /// # Errors
    /// A file cannot be read, or is not a block of these references.
    pub fn references(&self, ledger: &mut Ledger) -> Result<Option<References>> {
        let most = self.plan.most_blocks(self.blocks());
        let Ledger { library, .. } = ledger;
        library.references(self.identity, self.configuration, self.blocks(), most)
    }

    /// The seeds of the runs of each control: as many as the plan has seeds, and far from the seeds of other
    /// runs.
    pub fn control_seeds(&self) -> Range<u32> {
        CONTROL_SEED..CONTROL_SEED + self.plan.seeds
    }

    /// The controls of the configuration, as far as the finished runs determine them.
    ///
    /// # Errors
    /// As for [`Self::repeats`].
    pub fn controls(&self, store: &Store) -> Result<Controls> {
        let seeds = self.plan.seeds;
        let single = bias::control(self.configuration, 1);
        let own = self.runs(store, self.configuration, 0..seeds)?;
        let singles = self.runs(store, &single, self.control_seeds())?;
        let are_there = own.len() == seeds as usize && singles.len() == seeds as usize;
        let matching = are_there.then(|| {
            let samples = bias::control_samples(&own, &singles);
            bias::control(self.configuration, samples)
        });
        Ok(Controls { single, matching })
    }

    /// The seeds of the fresh runs that decide about a bias if the first runs raise an alarm. `seeds` is the
    /// number of the first runs; the number of fresh runs is at least as large.
    pub fn confirming_seeds(seeds: usize) -> Range<u32> {
        // Fewer could not see what the first ones saw.
        CONFIRMING_SEED..CONFIRMING_SEED + CONFIRMING_SEEDS.max(seeds as u32)
    }

    /// Computes the row of results from the runs and references that are finished.
    /// [`judge`](super::results::judge) sets its verdict later. `all` is the number of configurations on the
    /// scene: the more there are, the stronger a sign of bias must be to raise an alarm.
    ///
    /// # Errors
    /// A file of a reference cannot be read.
    pub fn row(&self, ledger: &mut Ledger, all: usize) -> Result<Row> {
        let references = self.references(ledger)?;
        let store = &ledger.store;
        let runs = self.runs(store, self.configuration, 0..self.plan.most_seeds())?;
        let [repeat, counts] = self.repeats()?;
        let find = |key: &str| store.find(key, 0);
        let replays = match (find(&repeat), runs.first()) {
            (Some(again), Some(first)) if first.seed == 0 => Some(again.same_as(first)),
            _ => None,
        };
        let mut findings = Findings {
            counts: find(&counts).map_or_else(Vec::new, |run| run.counts.clone()),
            replays,
            ..Findings::default()
        };
        let reference = references.as_ref().map(References::last);
        if let Some(reference) = reference.filter(|_| runs.len() > 1) {
            findings.bias = Some(Bias::measure(&runs, reference));
            findings.block_bias = BlockBias::measure(&runs, reference);
            if self.configuration.expect == Expect::Unbiased {
                let own = self.runs(store, self.configuration, 0..self.plan.seeds)?;
                if let Some(control) = self.controls(store)?.matching {
                    let control = self.runs(store, &control, self.control_seeds())?;
                    if control.len() == self.plan.seeds as usize {
                        findings.blocks_p_value =
                            Some(bias::blocks_p_value(&own, &control, reference));
                    }
                }
            }
        }
        let mut row = Row::new(&self.identity.scene, self.configuration, &runs, findings)?;
        if let Some(reference) = reference
            && self.configuration.expect == Expect::Unbiased
            && row.alarms(all)
        {
            let seeds = Self::confirming_seeds(runs.len());
            let fresh = self.runs(store, self.configuration, seeds.clone())?;
            if fresh.len() == seeds.len() {
                row.rejected += fresh.iter().map(|run| u64::from(run.rejected)).sum::<u64>();
                row.confirmation = Some(Confirmation::measure(&runs, &fresh, reference));
            }
        }
        row.reference_spp = reference.map(|reference| reference.samples);
        row.wanted_reference_spp = reference.and_then(|reference| {
            let limit = bias::MAX_REFERENCE_HALF_WIDTH;
            (reference.half_width() > limit).then(|| reference.samples_for(limit).ceil())
        });
        Ok(row)
    }
}
