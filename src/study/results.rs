//! What a study found: one row for each scene and configuration, as JSON, CSV and a table.

use super::bias::{Bias, LEVEL, WIDEST};
use super::plan::Expect;
use super::run::Run;
use crate::metrics::statistics::holm;
use crate::{Error, Result};
use serde::Serialize;
use serde_json::Value;
use std::fmt::Write as _;

/// One configuration on one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The scene.
    pub scene: String,
    /// The configuration.
    pub configuration: String,
    /// Its resolved settings.
    pub settings: Value,
    /// Number of independent runs.
    pub seeds: usize,
    /// Mean over seeds, by frame.
    pub rmse: Vec<f64>,
    /// Likewise, of clamped pictures.
    pub rmse_clamped: Vec<f64>,
    /// Likewise.
    pub relmse: Vec<f64>,
    /// Median over seeds of the last frame's passes.
    pub milliseconds: Vec<(String, f64)>,
    /// Values refused, over all runs.
    pub rejected: u64,
    /// What the bias check measured.
    pub bias: Bias,
    /// The least of the channels' p-values after Holm's correction over the whole study.
    pub corrected_p_value: f64,
    /// What it was expected to be.
    pub expect: Expect,
    /// What it was found to be.
    pub verdict: Verdict,
}

/// What a bias check found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// No difference, and an interval narrow enough to have seen one.
    Unbiased,
    /// A difference beyond chance.
    Biased,
    /// No difference seen, but the interval is too wide to tell.
    Unclear,
}

impl Verdict {
    fn text(self) -> &'static str {
        match self {
            Self::Unbiased => "unbiased",
            Self::Biased => "biased",
            Self::Unclear => "unclear",
        }
    }
}

impl Row {
    /// Summarises runs; verdicts follow in [`judge`].
    pub fn new(runs: &[&Run], settings: Value, bias: Bias, expect: Expect) -> Self {
        let mean = |part: fn(&Run) -> &[f64]| {
            let frames = runs.first().map_or(0, |run| part(run).len());
            (0..frames)
                .map(|f| runs.iter().map(|run| part(run)[f]).sum::<f64>() / runs.len() as f64)
                .collect()
        };
        let passes = runs.first().map_or(0, |run| run.milliseconds.len());
        let median = |pass: usize| {
            let mut all: Vec<f64> = runs
                .iter()
                .filter_map(|r| Some(r.milliseconds.get(pass)?.1))
                .collect();
            all.sort_by(f64::total_cmp);
            all[all.len() / 2]
        };
        Self {
            scene: runs.first().map_or(String::new(), |r| r.scene.clone()),
            configuration: runs
                .first()
                .map_or(String::new(), |r| r.configuration.clone()),
            settings,
            seeds: runs.len(),
            rmse: mean(|r| &r.rmse),
            rmse_clamped: mean(|r| &r.rmse_clamped),
            relmse: mean(|r| &r.relmse),
            milliseconds: (0..passes)
                .map(|pass| (runs[0].milliseconds[pass].0.clone(), median(pass)))
                .collect(),
            rejected: runs.iter().map(|r| u64::from(r.rejected)).sum(),
            bias,
            corrected_p_value: 1.0,
            expect,
            verdict: Verdict::Unclear,
        }
    }

    /// Whether it is what it was expected to be.
    pub fn holds(&self) -> bool {
        self.expect == Expect::Biased || self.verdict == Verdict::Unbiased
    }

    fn widest(&self) -> f64 {
        self.bias.half_width.iter().copied().fold(0.0, f64::max)
    }
}

/// Decides over all rows at once: Holm's correction is over every channel of every row that should be
/// unbiased, and of the others by themselves.
pub fn judge(rows: &mut [Row]) {
    for expect in [Expect::Unbiased, Expect::Biased] {
        let chosen: Vec<usize> = (0..rows.len())
            .filter(|i| rows[*i].expect == expect)
            .collect();
        let p_values: Vec<f64> = chosen.iter().flat_map(|i| rows[*i].bias.p_values).collect();
        let corrected = holm(&p_values);
        for (place, i) in chosen.into_iter().enumerate() {
            let own = &corrected[3 * place..3 * place + 3];
            let row = &mut rows[i];
            row.corrected_p_value = own.iter().copied().fold(1.0, f64::min);
            row.verdict = if row.corrected_p_value < LEVEL {
                Verdict::Biased
            } else if row.widest() > WIDEST {
                Verdict::Unclear
            } else {
                Verdict::Unbiased
            };
        }
    }
}

/// All rows as lines for a reader.
pub fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "scene            configuration                        bias %   ± 99 %   p (Holm)  blocks p  rmse first → last   verdict\n",
    );
    for row in rows {
        let largest = row
            .bias
            .relative
            .iter()
            .copied()
            .fold(0.0_f64, |a, b| if b.abs() > a.abs() { b } else { a });
        let _ = writeln!(
            text,
            "{:16} {:35} {:+8.3} {:8.3} {:10.3} {:9.3}  {:8.5} → {:8.5}  {}{}",
            row.scene,
            row.configuration,
            100.0 * largest,
            100.0 * row.widest(),
            row.corrected_p_value,
            row.bias.blocks_p_value,
            row.rmse.first().copied().unwrap_or(0.0),
            row.rmse.last().copied().unwrap_or(0.0),
            row.verdict.text(),
            if row.holds() {
                ""
            } else {
                " (should be unbiased)"
            },
        );
    }
    text
}

/// All rows as CSV: a line for each frame.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "scene,configuration,seeds,frame,rmse,rmse_clamped,relmse,bias_r,bias_g,bias_b,half_width,verdict\n",
    );
    let quoted = |s: &str| format!("\"{}\"", s.replace('"', "\"\""));
    for row in rows {
        for frame in 0..row.rmse.len() {
            let _ = writeln!(
                text,
                "{},{},{},{frame},{},{},{},{},{},{},{},{}",
                quoted(&row.scene),
                quoted(&row.configuration),
                row.seeds,
                row.rmse[frame],
                row.rmse_clamped[frame],
                row.relmse[frame],
                row.bias.relative[0],
                row.bias.relative[1],
                row.bias.relative[2],
                row.widest(),
                row.verdict.text(),
            );
        }
    }
    text
}

/// All rows as JSON with a version.
///
/// # Errors
/// Never with finite numbers.
pub fn json(rows: &[Row], device: &str, driver: &str) -> Result<Value> {
    let rows = serde_json::to_value(rows).map_err(|e| Error::failed(format!("results: {e}")))?;
    Ok(serde_json::json!({
        "version": 1,
        "device": device,
        "driver": driver,
        "commit": env!("HEADWATER_COMMIT"),
        "rows": rows,
    }))
}
