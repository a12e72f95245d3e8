//! The work of a study on one scene: it renders the runs that are missing, renders more runs where the interval of the bias
//! is too wide for a verdict, and makes one row of results for each configuration.

use super::bias::{
    self, Bias, CONFIRMING_SEEDS, Confirmation, MAX_HALF_WIDTH, MAX_REFERENCE_HALF_WIDTH,
};
use super::block_bias::BlockBias;
use super::forecast::{Effort, Forecast};
use super::plan::{Expect, Plan, Resolved};
use super::planned_scene::PlannedScene;
use super::reference::References;
use super::results::Row;
use super::store::Store;
use super::subject::Subject;
use crate::base::progress::Watch;
use crate::{Error, Result};
use std::ops::Range;
use std::time::Instant;

/// The first seed of the runs of controls. A control is path tracing with about as much noise as a configuration, and the
/// blocks of pixels of the configuration are compared with those of the control. The number is far from the seeds of other
/// runs, so that no seed has two uses.
const CONTROL_SEED: u32 = 1 << 20;
/// The first seed of the runs that alone decide whether a configuration is biased after an alarm, which is a sign of bias in
/// the first runs. It is far from the seeds of other runs, so that these runs are independent of the first ones.
const CONFIRMING_SEED: u32 = 1 << 21;

/// The number of samples per pixel that the forecast of the study's duration assumes for controls, which are path tracing
/// for comparison with the blocks of a configuration. The real number is known only later, from the measured noise. This
/// constant changes no result.
const LIKELY_CONTROL_SAMPLES: u32 = 8;

/// Sets in the forecast the number of steps of all work that `plan` requires on the scene `planned`, before any work begins,
/// so that the first report of progress covers the whole study. `own` are the configurations that are rendered on this
/// scene.
pub fn forecast_scene(
    forecast: &mut Forecast,
    plan: &Plan,
    planned: &PlannedScene,
    own: &[&Resolved],
) {
    let (name, seeds) = (planned.name.as_str(), u64::from(plan.seeds));
    let frames: u64 = own.iter().map(|c| u64::from(c.frames)).sum();
    forecast.set_to_come(name, Effort::Runs, seeds * frames);
    let repeats = own.iter().map(|c| u64::from(c.frames) * repeats(c)).sum();
    forecast.set_to_come(name, Effort::Repeats, repeats);
    let samples = planned.reference_spp.unwrap_or(plan.reference_spp);
    // If nothing moves in the scene, all frames have the same one: then too many are expected until it is made.
    let references = plan.fps.map_or(1, |_| u64::from(plan.frames));
    forecast.set_to_come(name, Effort::References, references * u64::from(samples));
    if own.iter().any(|c| c.expect == Expect::Unbiased) {
        let frames = u64::from(1 + LIKELY_CONTROL_SAMPLES);
        forecast.set_to_come(name, Effort::Controls, seeds * frames);
    }
}

/// The number of times that the run of a configuration with the first seed is repeated: once to find data races, and once
/// more if the plan requests counts of rays.
fn repeats(configuration: &Resolved) -> u64 {
    1 + u64::from(configuration.count)
}

/// The work that a plan requires on one of its scenes, with all that it needs: the scene on the device, the finished runs,
/// and the report of progress.
pub struct Work<'a> {
    /// The plan of the study. It states how many seeds each configuration gets, at first and at most.
    plan: &'a Plan,
    /// The number of samples per pixel of this scene's references: that of the scene or, if the scene has none, that of the
    /// plan.
    reference_spp: u32,
    /// The scene on the device, with its references and renderers.
    subject: Subject,
    /// The finished runs of the study. Runs that it does not have are rendered and added to it.
    store: &'a mut Store,
    /// The forecast of the whole study. It is told the duration of each step, and estimates the fraction of the study that
    /// is done.
    forecast: &'a mut Forecast,
    /// A callback that is called repeatedly with the fraction of the whole study that is done, in [0, 1]. An error from it
    /// ends the work.
    watch: &'a mut Watch<'a>,
}

impl<'a> Work<'a> {
    /// Prepares the work that `plan` requires on its scene `planned`; `subject` is this scene on the device. Finished runs
    /// are taken from `store`, and new ones are added to it. `watch` is called with the fraction of the whole study that is
    /// done, in [0, 1]; an error from it ends the work.
    pub fn new(
        plan: &'a Plan,
        planned: &PlannedScene,
        subject: Subject,
        store: &'a mut Store,
        forecast: &'a mut Forecast,
        watch: &'a mut Watch<'a>,
    ) -> Self {
        Self {
            plan,
            reference_spp: planned.reference_spp.unwrap_or(plan.reference_spp),
            subject,
            store,
            forecast,
            watch,
        }
    }

    /// Renders the runs that are missing, and returns one row of results for each configuration, in the order of
    /// `configurations`. The rows have no valid verdicts yet; [`judge`](super::results::judge) must set them when the rows
    /// of all scenes are complete.
    ///
    /// # Errors
    /// The device or the disk fails, a reference cannot be made or read, the scene cannot be rendered at the time of a
    /// frame, or `watch` returns an error.
    pub fn rows(&mut self, configurations: &[&Resolved]) -> Result<Vec<Row>> {
        // Configurations take turns, so that what disturbs the machine disturbs all alike.
        self.forecast
            .set_to_come(&self.subject.name, Effort::Runs, 0);
        self.run(Effort::Runs, configurations, 0..self.plan.seeds)?;
        let seeds = self.extend(configurations)?;
        let rows = (configurations.iter())
            .map(|configuration| self.row(configuration, seeds, configurations.len()))
            .collect();
        self.forecast.close(&self.subject.name);
        rows
    }

    /// Makes the references of the configurations in `claims`, and refuses a reference with too large an error. The caller
    /// ensures that the plan expects these configurations to be unbiased. The interval of a bias contains the error of the
    /// reference, so no number of runs could make the interval narrow enough for a proof with such a reference.
    ///
    /// # Errors
    /// The half-width of a reference exceeds [`MAX_REFERENCE_HALF_WIDTH`], or an error of [`Self::rows`] occurs.
    pub fn check_references(&mut self, claims: &[&Resolved]) -> Result<()> {
        let spp = self.reference_spp;
        for configuration in claims {
            let references = self.references(configuration)?;
            let reference = references.last();
            let width = reference.half_width();
            if width > MAX_REFERENCE_HALF_WIDTH {
                let needed = reference.samples_for(MAX_REFERENCE_HALF_WIDTH);
                return Err(Error::input(format!(
                    "scene {}: its reference of {spp} samples per pixel has the mean within ±{:.2} % only; give it a reference_spp of about {:.0}",
                    self.subject.name,
                    100.0 * width,
                    needed.ceil()
                )));
            }
        }
        Ok(())
    }

    /// Renders runs with further seeds of each configuration that is expected to be unbiased, until its interval is at most
    /// as wide as [`MAX_HALF_WIDTH`] allows or the plan's maximum of seeds is reached. A wider interval proves nothing. Returns the
    /// largest number of seeds of any configuration; those with a narrow interval have fewer.
    fn extend(&mut self, configurations: &[&Resolved]) -> Result<u32> {
        let mut seeds = self.plan.seeds;
        while seeds < self.plan.most_seeds() {
            let mut wide = Vec::new();
            for configuration in configurations {
                if configuration.expect == Expect::Unbiased
                    && self.bias(configuration, seeds)?.largest_half_width() > MAX_HALF_WIDTH
                {
                    wide.push(*configuration);
                }
            }
            if wide.is_empty() {
                break;
            }
            let more = (seeds + self.plan.seeds).min(self.plan.most_seeds());
            self.run(Effort::Runs, &wide, seeds..more)?;
            seeds = more;
        }
        Ok(seeds)
    }

    /// Makes the row of results of one configuration from its runs with seeds below `seeds`. If the plan expects no bias,
    /// but these runs raise an alarm (a sign of bias), it also renders runs with fresh seeds, which then decide. `all` is
    /// the number of configurations on the scene; the more there are, the stronger a sign must be to raise an alarm.
    fn row(&mut self, configuration: &Resolved, seeds: u32, all: usize) -> Result<Row> {
        let key = self.subject.key(configuration)?;
        let bias = self.bias(configuration, seeds)?;
        let blocks_p_value = match configuration.expect {
            Expect::Unbiased => self.blocks_p_value(configuration)?,
            Expect::Biased | Expect::Any => 1.0,
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
            self.run(Effort::Runs, &[configuration], fresh.clone())?;
            let fresh = self.store.of(&key, fresh);
            row.rejected += fresh.iter().map(|run| u64::from(run.rejected)).sum::<u64>();
            row.confirmation = Some(Confirmation::measure(
                &self.store.of(&key, 0..seeds),
                &fresh,
                references.last(),
            ));
        }
        if let Some(first) = self.store.find(&key, 0) {
            let start = Instant::now();
            let again = self.subject.repeat(configuration, 0, &references)?;
            row.replays = again.same_as(first);
            self.step(Effort::Repeats, configuration.frames, start)?;
        }
        if configuration.count {
            let start = Instant::now();
            row.counts = self.subject.counts(configuration, 0, &references)?;
            self.step(Effort::Repeats, configuration.frames, start)?;
        }
        Ok(row)
    }

    /// Records in the forecast that `frames` frames of one kind of work are done, and that they took the time since `start`.
    /// Then calls `watch` with the fraction of the study that is done; its error ends the work.
    fn step(&mut self, effort: Effort, frames: u32, start: Instant) -> Result<()> {
        let (name, frames) = (&self.subject.name, u64::from(frames));
        self.forecast.done(name, effort, frames, start.elapsed());
        (self.watch)(self.forecast.fraction())
    }

    /// Renders one run for each of the configurations and each seed in `seeds`, unless the store already has this run. For
    /// each seed, the configurations take turns, so that a disturbance of the machine affects the times of all of them.
    fn run(
        &mut self,
        effort: Effort,
        configurations: &[&Resolved],
        seeds: Range<u32>,
    ) -> Result<()> {
        let mut missing = 0;
        for configuration in configurations {
            let key = self.subject.key(configuration)?;
            let blocks = self.subject.blocks();
            (self.store).keep_whole(&key, configuration.frames as usize, blocks);
            let runs = seeds.len() - self.store.of(&key, seeds.clone()).len();
            missing += runs as u64 * u64::from(configuration.frames);
        }
        let name = self.subject.name.clone();
        self.forecast.raise_to_come(&name, effort, missing);
        for seed in seeds {
            for configuration in configurations {
                let key = self.subject.key(configuration)?;
                if self.store.find(&key, seed).is_some() {
                    continue;
                }
                let references = self.references(configuration)?;
                let start = Instant::now();
                self.subject
                    .run(configuration, seed, &references, self.store)?;
                self.step(effort, configuration.frames, start)?;
            }
        }
        Ok(())
    }

    fn references(&mut self, configuration: &Resolved) -> Result<References> {
        let Self {
            subject,
            forecast,
            watch,
            reference_spp,
            ..
        } = self;
        let name = subject.name.clone();
        let (mut heard, mut before) = (Instant::now(), 0.0);
        let references = subject.references(configuration, *reference_spp, &mut |fraction| {
            // A reference for each frame begins again at 0.
            let more = if fraction > before {
                fraction - before
            } else {
                fraction
            };
            let samples = (more * f64::from(*reference_spp)).round() as u64;
            forecast.done(&name, Effort::References, samples, heard.elapsed());
            (heard, before) = (Instant::now(), fraction);
            watch(forecast.fraction())
        })?;
        forecast.set_to_come(&name, Effort::References, 0);
        Ok(references)
    }

    fn bias(&mut self, configuration: &Resolved, seeds: u32) -> Result<Bias> {
        let references = self.references(configuration)?;
        let key = self.subject.key(configuration)?;
        Ok(Bias::measure(
            &self.store.of(&key, 0..seeds),
            references.last(),
        ))
    }

    /// The p-value for a bias in blocks of pixels of the configuration; a small value raises an alarm. It renders the
    /// missing runs of a control and compares the blocks with those of the control. A control is path tracing, which has no
    /// bias, with about as much noise as the configuration and as many runs as the plan has seeds.
    fn blocks_p_value(&mut self, configuration: &Resolved) -> Result<f64> {
        let seeds = self.plan.seeds;
        let own = self.subject.key(configuration)?;
        let control_seeds = CONTROL_SEED..CONTROL_SEED + self.plan.seeds;
        let single = bias::control(configuration, 1);
        self.run(Effort::Controls, &[&single], control_seeds.clone())?;
        let single = self.subject.key(&single)?;
        let samples = bias::control_samples(
            &self.store.of(&own, 0..seeds),
            &self.store.of(&single, control_seeds.clone()),
        );
        let control = bias::control(configuration, samples);
        self.run(Effort::Controls, &[&control], control_seeds.clone())?;
        let control = self.subject.key(&control)?;
        let references = self.references(configuration)?;
        Ok(bias::blocks_p_value(
            &self.store.of(&own, 0..seeds),
            &self.store.of(&control, control_seeds),
            references.last(),
        ))
    }
}
