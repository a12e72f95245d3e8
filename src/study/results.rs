//! The results of a study: one row for each configuration on each scene, with its errors, its costs, and its verdict about
//! bias.

use super::bias::{Bias, Confirmation, LEVEL, MAX_HALF_WIDTH};
use super::block_bias::BlockBias;
use super::plan::{Expect, Resolved};
use super::run::Run;
use crate::Result;
use crate::metrics::statistics::{Estimate, holm};
use crate::render::counters::Counts;
use serde::Serialize;
use serde_json::Value;

/// The results of one configuration on one scene, as the files of results and the printed table state them. Lists with one
/// entry for each frame of a run begin with frame 0.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The name of the scene in the plan, which tables show.
    pub scene: String,
    /// The name of the configuration in the plan, which tables show.
    pub configuration: String,
    /// The complete settings of the configuration as JSON: those of its preset, to which the changes of the plan are
    /// applied.
    pub settings: Value,
    /// True if the picture that is measured after a frame is the mean of this frame and all frames before it.
    pub accumulate: bool,
    /// The number of runs with the first seeds, one run for each seed. The runs with fresh seeds after an alarm (a sign of
    /// bias) do not count.
    pub seeds: usize,
    /// The root of the mean squared error of each frame against the reference of its time, in linear RGB and in the scene's
    /// unit of radiance. The mean is over pixels, channels and seeds, and the noise of the reference is taken out.
    pub rmse: Vec<f64>,
    /// The root of the mean squared error of each frame like [`Self::rmse`], but with all values clamped to
    /// [0, 1], so that a few very bright pixels do not dominate.
    pub rmse_clamped: Vec<f64>,
    /// The relMSE of each frame against the reference of its time: the mean over pixels, channels and seeds of (a − t)² /
    /// (b² + 0.01), where a is the value in the frame, t the truth, and b the value in the reference.
    pub relmse: Vec<f64>,
    /// For each frame, the half-width of the 95 % interval of [`Self::relmse`]. Null for fewer than two seeds.
    pub relmse_half_width: Vec<Option<f64>>,
    /// For each frame, Pearson's correlation of the errors of all pixels with their errors in the previous frame, as the
    /// mean over seeds. It is in [−1, 1]: 1 means that both frames have the same noise, 0 that their noise is independent.
    /// Frame 0 has 0.
    pub correlation: Vec<f64>,
    /// For each frame, the median of the ratio of a pixel's luminance to its luminance in the reference, as the mean over
    /// seeds. The median is over the pixels that [`Reference::median_ratio`](super::reference::Reference::median_ratio)
    /// selects. If it is below 1, most of them are too dark.
    pub median: Vec<f64>,
    /// The counts of each pass in the last frame, such as the number of rays, from a repetition of the run with the first
    /// seed. Empty unless the plan requests counts.
    pub counts: Vec<Counts>,
    /// The memory on the device that resampling keeps between passes and frames, in bytes for each pixel of the picture; 0
    /// for path tracing.
    pub bytes_per_pixel: f64,
    /// The number of radiances and weights (of candidates and reservoirs) that shaders rejected because they were NaN,
    /// infinite, negative or too large. It counts all runs, also those with fresh seeds. If it is not 0, the row makes the
    /// study fail.
    pub rejected: u64,
    /// The bias of the picture's mean, estimated from the runs with the first seeds. After an alarm, [`Self::confirmation`]
    /// has the bias that decides. Null for fewer than two runs.
    pub bias: Option<Bias>,
    /// The root mean square of the bias of blocks of 8 × 8 pixels, as a fraction of the reference's mean luminance. It also
    /// shows a bias that cancels over the picture. The verdict does not depend on it. Null for fewer than three runs.
    pub block_bias: Option<BlockBias>,
    /// The p-value for a bias in blocks of 8 × 8 pixels, in [0, 1]; a small value raises an alarm. Two tests
    /// are combined: whether the errors of blocks are distributed as those of path tracing with similar
    /// noise, and whether the block that is farthest from the reference has a bias. The value would be exact
    /// if blocks were independent. It is null if the row does not expect `unbiased`, or until the runs of
    /// path tracing are finished.
    pub blocks_p_value: Option<f64>,
    /// The result of the runs with fresh seeds, which alone decide if the first seeds raised an alarm (a sign of bias). Null
    /// without an alarm.
    pub confirmation: Option<Confirmation>,
    /// The smallest of the p-values that decide about this row, after Holm's correction for the number of
    /// tests. The tests of all rows that expect `unbiased` are corrected as one group, and those of all other
    /// rows as a second group. If the p-value is below 0.01, and there are at least four seeds, the verdict
    /// is `biased`.
    pub corrected_p_value: f64,
    /// The smallest bias of the mean that the check of this row finds with a probability of 90 %, as a fraction of the
    /// reference's mean. The check can miss a smaller bias. Null without a bias.
    pub detectable_bias: Option<f64>,
    /// True if a repetition of the run with the first seed gave the same means of channels and of blocks, to the last bit.
    /// False means that a pass has a data race, and the row makes the study fail. Null before the repetition.
    pub replays: Option<bool>,
    /// The number of samples per pixel of the reference; null if it is not known yet.
    pub reference_spp: Option<u32>,
    /// The number of samples per pixel that the reference needs so that a verdict `unbiased` is possible;
    /// null if the reference has enough samples, or does not exist yet.
    pub wanted_reference_spp: Option<f64>,
    /// The verdict that the plan expects. A verdict `biased` makes the study fail only if this is `unbiased`.
    pub expect: Expect,
    /// The verdict of the bias check, which [`judge`] sets: unbiased, biased, or undecided. The study fails if it is biased
    /// although the plan expects `unbiased`.
    pub verdict: Verdict,
    /// The additional work with which the row could be decided, if its verdict is `undecided`; null for another verdict.
    pub missing: Option<Missing>,
    /// The mean duration of one run, in seconds, from which the time for more seeds is predicted.
    #[serde(skip)]
    pub(super) run_seconds: f64,
}

/// The values of a [`Row`] that need more than the runs themselves, such as a reference, a control or a
/// repetition. A value is missing (`None` or empty) until the study has rendered what it needs.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// The bias of the picture's mean; see [`Row::bias`].
    pub bias: Option<Bias>,
    /// The size of the bias in blocks of pixels; see [`Row::block_bias`].
    pub block_bias: Option<BlockBias>,
    /// The p-value for a bias in blocks of pixels, in [0, 1]; see [`Row::blocks_p_value`].
    pub blocks_p_value: Option<f64>,
    /// The counts of each pass, such as rays; see [`Row::counts`].
    pub counts: Vec<Counts>,
    /// True if a repetition of the first run gave the same bits; see [`Row::replays`].
    pub replays: Option<bool>,
}

/// The additional work with which a row with the verdict `undecided` could be decided, so that the user can raise the
/// numbers in the plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Missing {
    /// The approximate number of additional runs, each with a new seed. Null if no number suffices, because the error of the
    /// reference is too large, or if nothing is known yet.
    pub seeds: Option<f64>,
}

/// The outcome of the check whether one configuration has a bias on one scene. It is decided by the p-values of the tests
/// for bias and by the 99 % interval of the bias of the picture's mean. A study fails if a configuration is biased although
/// its plan expects it to be unbiased.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// No bias was found, and the 99 % interval is so narrow (its half-width is at most [`MAX_HALF_WIDTH`]) that a larger bias would
    /// have been found.
    Unbiased,
    /// The difference from the reference is too large to be chance: a p-value of the tests that decide about the row,
    /// corrected for the number of tests, is below [`LEVEL`].
    Biased,
    /// No bias was found, but the 99 % interval is too wide (its half-width is above [`MAX_HALF_WIDTH`]) to
    /// exclude one; or there are fewer than four seeds. More seeds or a better reference are needed.
    Undecided,
}

impl Verdict {
    /// The word for the verdict in tables and in CSV: `unbiased`, `biased` or `undecided`.
    pub(super) fn text(self) -> &'static str {
        match self {
            Self::Unbiased => "unbiased",
            Self::Biased => "biased",
            Self::Undecided => "undecided",
        }
    }
}

impl Row {
    /// Summarises the runs of a configuration on the scene with the name `scene`, one run for each seed, as a row of
    /// results. [`judge`] must be called later: until then, the verdict, the corrected p-value and the detectable bias have
    /// initial values without meaning.
    ///
    /// # Errors
    /// The settings have no JSON form, which cannot happen with finite numbers.
    pub fn new(
        scene: &str,
        configuration: &Resolved,
        runs: &[&Run],
        findings: Findings,
    ) -> Result<Self> {
        let frames = runs.first().map_or(0, |run| run.relmse.len());
        let each = |part: fn(&Run) -> &[f64]| -> Vec<Estimate> {
            let of_frame =
                |frame: usize| -> Vec<f64> { runs.iter().map(|run| part(run)[frame]).collect() };
            (0..frames)
                .map(|frame| Estimate::of(&of_frame(frame)))
                .collect()
        };
        let mean = |part| each(part).iter().map(|e| e.mean).collect::<Vec<f64>>();
        let root = |part| mean(part).iter().map(|e| e.max(0.0).sqrt()).collect();
        let half_width = |e: &Estimate| (e.samples > 1).then(|| e.t_interval_half_width(0.95));
        Ok(Self {
            scene: scene.to_owned(),
            configuration: configuration.name.clone(),
            settings: configuration.settings.to_value()?,
            accumulate: configuration.accumulate,
            seeds: runs.len(),
            rmse: root(|r| &r.mse),
            rmse_clamped: root(|r| &r.clamped_mse),
            relmse: mean(|r| &r.relmse),
            relmse_half_width: each(|r| &r.relmse).iter().map(half_width).collect(),
            correlation: mean(|r| &r.correlation),
            median: mean(|r| &r.median),
            counts: findings.counts,
            bytes_per_pixel: runs.first().map_or(0.0, |r| r.bytes_per_pixel),
            rejected: runs.iter().map(|r| u64::from(r.rejected)).sum(),
            bias: findings.bias,
            block_bias: findings.block_bias,
            blocks_p_value: findings.blocks_p_value,
            confirmation: None,
            corrected_p_value: 1.0,
            detectable_bias: None,
            replays: findings.replays,
            reference_spp: None,
            wanted_reference_spp: None,
            expect: configuration.expect,
            verdict: Verdict::Undecided,
            missing: None,
            run_seconds: runs.iter().map(|r| r.seconds).sum::<f64>() / runs.len().max(1) as f64,
        })
    }

    /// The reason why this row makes the study fail, as a text for the user: rejected values, a run that cannot be repeated
    /// to the last bit, or a bias that the plan does not expect. `None` if the row does not make it fail.
    pub fn complaint(&self) -> Option<&'static str> {
        if self.rejected > 0 {
            Some("values were refused")
        } else if self.replays == Some(false) {
            Some("the same seed gives another picture")
        } else if self.expect == Expect::Unbiased && self.verdict == Verdict::Biased {
            Some("should be unbiased")
        } else {
            None
        }
    }

    /// A text for the user about an undecided row: what is missing for a verdict, and which key of the plan the user should
    /// raise. `None` unless the row expects `unbiased` and its verdict is `undecided`.
    pub fn open_question(&self) -> Option<String> {
        let missing = self.missing.filter(|_| self.expect == Expect::Unbiased)?;
        let Some(seeds) = missing.seeds else {
            let samples = self.wanted_reference_spp;
            return Some(samples.map_or("too few runs are finished".to_owned(), |samples| {
                format!(
                    "its reference is too noisy for this proof: raise reference_spp to about {samples}"
                )
            }));
        };
        let minutes = match (seeds * self.run_seconds / 60.0).ceil() {
            ..=1.0 => "a minute".to_owned(),
            minutes => format!("{minutes} minutes"),
        };
        Some(format!(
            "too few seeds for this proof: about {seeds} more, about {minutes}; raise most_seeds in the plan, by default 4 × seeds"
        ))
    }

    /// True if the first seeds raise an alarm (a sign of bias), so that fresh seeds must decide. They raise one if
    /// [`Self::blocks_p_value`] is below [`LEVEL`] / `rows`, or if the smallest p-value of the three colour channels is
    /// below a third of that. `rows` is the number of rows of the same scene; the more there are, the stronger the sign must
    /// be.
    pub fn alarms(&self, rows: usize) -> bool {
        let level = LEVEL / rows.max(1) as f64;
        let p_values = self.bias.iter().flat_map(|bias| bias.p_values);
        let least = p_values.fold(1.0, f64::min);
        3.0 * least < level || self.blocks_p_value.is_some_and(|p| p < level)
    }

    /// The bias and the p-values that decide whether the row is called biased. If no p-value of the first seeds was small
    /// enough to suspect a bias, they are those of the first seeds: one p-value for each channel. Otherwise further seeds
    /// were rendered, and the results are of these alone: one p-value for each channel, and one for the pattern of blocks.
    /// `None` for fewer than two runs.
    pub(super) fn deciding(&self) -> Option<(&Bias, Vec<f64>)> {
        match &self.confirmation {
            None => (self.bias.as_ref()).map(|bias| (bias, bias.p_values.to_vec())),
            Some(fresh) => {
                let mut p_values = fresh.bias.p_values.to_vec();
                p_values.push(fresh.pattern_p_value);
                Some((&fresh.bias, p_values))
            }
        }
    }
}

/// The minimum number of seeds with which a row can get the verdict `biased`. Two or three values can be
/// almost equal by chance. The degrees of freedom of the test are then those of the reference, and its
/// p-value is far too small.
const LEAST_SEEDS: usize = 4;

/// Sets the verdict, the corrected p-value, the detectable bias and the missing work of all rows, when the rows of all
/// scenes are complete. Holm's correction keeps the probability of any false verdict `biased` low. The tests of all rows
/// that expect `unbiased` are corrected as one group, and those of all other rows as a second group.
pub fn judge(rows: &mut [Row]) {
    for claimed in [true, false] {
        let mut chosen: Vec<&mut Row> = (rows.iter_mut())
            .filter(|r| (r.expect == Expect::Unbiased) == claimed)
            .collect();
        let p_values: Vec<Vec<f64>> = (chosen.iter())
            .map(|row| {
                row.deciding()
                    .map_or_else(Vec::new, |(_, p_values)| p_values)
            })
            .collect();
        let corrected = holm(&p_values.concat());
        let tests = corrected.len();
        let mut rest = corrected.as_slice();
        for (row, own) in chosen.iter_mut().zip(&p_values) {
            let (own, others) = rest.split_at(own.len());
            rest = others;
            row.corrected_p_value = own.iter().copied().fold(1.0, f64::min);
            row.detectable_bias = row.deciding().map(|(bias, _)| bias.detectable(tests));
            // Fresh seeds decide whether there is a difference; how fine a one can be seen, they or those
            // before, whichever see finer.
            let finest = (row.bias.iter())
                .chain(row.deciding().map(|(bias, _)| bias))
                .min_by(|a, b| a.largest_half_width().total_cmp(&b.largest_half_width()));
            let widest = finest.map_or(f64::INFINITY, Bias::largest_half_width);
            let seeds = finest.and_then(Bias::missing_seeds);
            let is_enough = (row.deciding()).is_some_and(|(bias, _)| bias.seeds >= LEAST_SEEDS);
            row.verdict = if row.corrected_p_value < LEVEL && is_enough {
                Verdict::Biased
            } else if widest > MAX_HALF_WIDTH || row.corrected_p_value < LEVEL {
                Verdict::Undecided
            } else {
                Verdict::Unbiased
            };
            row.missing = (row.verdict == Verdict::Undecided).then_some(Missing { seeds });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bias::samples::{BLOCKS, reference, runs};
    use super::super::manifest::{Manifest, Request};
    use super::super::results_text::{json, table};
    use super::super::shard::Shard;
    use super::*;
    use crate::render::Settings;

    /// The row of `count` runs, each with a duration of one minute. The luminance of every block scatters around 1 +
    /// `offset`; in the reference it is 1.
    fn row(expect: Expect, count: u32, offset: f64) -> Row {
        let mut runs = runs(count, 0, [offset; BLOCKS]);
        for run in &mut runs {
            run.seconds = 60.0;
        }
        let runs: Vec<&Run> = runs.iter().collect();
        let configuration = Resolved {
            expect,
            ..Resolved::of(Settings::default())
        };
        let findings = Findings {
            bias: Some(Bias::measure(&runs, &reference())),
            block_bias: BlockBias::measure(&runs, &reference()),
            ..Findings::default()
        };
        Row::new("scene", &configuration, &runs, findings).unwrap()
    }

    fn manifest() -> Manifest {
        let request = Request {
            plan: "plan".into(),
            text: String::new(),
            scenes: Vec::new(),
            environment: None,
            bounces: None,
            quick: false,
        };
        Manifest::new(request, "device", "driver", Shard::WHOLE)
    }

    #[test]
    fn only_a_bias_that_was_not_expected_is_a_complaint() {
        for (expect, count, offset, verdict, complains) in [
            (Expect::Unbiased, 2048, 0.0, Verdict::Unbiased, false),
            (Expect::Unbiased, 2048, 0.05, Verdict::Biased, true),
            (Expect::Unbiased, 16, 0.0, Verdict::Undecided, false),
            (Expect::Biased, 2048, 0.05, Verdict::Biased, false),
            (Expect::Biased, 16, 0.0, Verdict::Undecided, false),
            (Expect::Any, 2048, 0.0, Verdict::Unbiased, false),
            (Expect::Any, 2048, 0.05, Verdict::Biased, false),
            (Expect::Any, 16, 0.0, Verdict::Undecided, false),
            // Three seeds prove nothing, however far off they are.
            (Expect::Biased, 3, 100.0, Verdict::Undecided, false),
            (Expect::Biased, 4, 100.0, Verdict::Biased, false),
        ] {
            let mut rows = [row(expect, count, offset)];
            judge(&mut rows);
            let [row] = &rows;
            assert_eq!(row.verdict, verdict, "{expect:?} {count} {offset}");
            assert_eq!(row.complaint().is_some(), complains, "{expect:?} {offset}");
            assert_eq!(row.missing.is_some(), verdict == Verdict::Undecided);
        }
    }

    #[test]
    fn an_open_question_says_what_it_takes() {
        let mut rows = [row(Expect::Unbiased, 16, 0.0)];
        judge(&mut rows);
        let seeds = rows[0].missing.unwrap().seeds.unwrap();
        assert!(seeds > 16.0, "{seeds}");
        let said = table(&rows);
        assert!(
            said.contains("undecided: too few seeds for this proof: about"),
            "{said}"
        );
        // A run takes one minute.
        let time = format!("about {seeds} more, about {seeds} minutes");
        assert!(said.contains(&time), "{said}");
        assert!(said.contains("raise most_seeds in the plan"), "{said}");
        let json = json(&rows, &manifest()).unwrap();
        assert_eq!(json["version"], 3);
        assert_eq!(json["rows"][0]["verdict"], "undecided");
        assert_eq!(json["rows"][0]["missing"]["seeds"], seeds);
    }

    #[test]
    fn what_two_runs_do_not_say_is_left_out() {
        let mut rows = [row(Expect::Any, 2, 0.0)];
        judge(&mut rows);
        let said = table(&rows);
        assert!(!said.contains("inf") && !said.contains("NaN"), "{said}");
        let json = json(&rows, &manifest()).unwrap();
        assert!(json["rows"][0]["block_bias"].is_null());
    }
}
