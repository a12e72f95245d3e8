//! The result files of a study. They are written from the runs and references that are finished, also while
//! the study is running.

use super::axes;
use super::cell::Cell;
use super::costs::{Cost, is_path_tracing};
use super::ledger::Ledger;
use super::manifest::Manifest;
use super::plan::{Plan, Resolved, rendered_on};
use super::planned_scene::PlannedScene;
use super::results::{Findings, Row, judge};
use super::results_text;
use super::tidy::{self, Series};
use crate::base::files::write_atomically;
use crate::base::json::value_of;
use crate::{Error, Result};
use serde_json::json;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The results of a study: one row and one cost for each configuration on each scene, in the order of the
/// plan.
pub struct Results {
    /// The errors and verdicts. They depend only on the runs and references, so they are the same in every
    /// repetition.
    pub rows: Vec<Row>,
    /// The times and the errors at equal time, one entry for each of [`Self::rows`], in the same order.
    pub costs: Vec<Cost>,
}

/// The result files in the folder of a study: tables in JSON and CSV, the schema of the CSV tables, and a
/// figure.
pub struct Outputs {
    folder: PathBuf,
}

const RESULTS: &str = "results.json";
const ERRORS: &str = "results.csv";
const COSTS: &str = "times.json";
const TIMES: &str = "times.csv";
const SCHEMA: &str = "schema.json";
const AXES: &str = "axes.svg";

impl Outputs {
    /// Prepares the result files of the study in `folder`. This only stores the path, and opens nothing.
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
        }
    }

    /// The paths of all result files, also of those that do not exist yet.
    pub fn files(&self) -> [PathBuf; 6] {
        [RESULTS, ERRORS, COSTS, TIMES, SCHEMA, AXES].map(|name| self.folder.join(name))
    }

    /// Computes the results from the runs and references of `ledger`, writes all result files, and returns
    /// the results. The figure is removed if no parameter of a scene is varied.
    ///
    /// # Errors
    /// A file of a reference cannot be read, or a result cannot be written.
    pub fn write(
        &self,
        (plan, configurations): (&Plan, &[Resolved]),
        manifest: &Manifest,
        ledger: &mut Ledger,
    ) -> Result<Results> {
        let mut rows = Vec::new();
        for planned in &plan.scenes {
            let own: Vec<&Resolved> = rendered_on(configurations, &planned.name).collect();
            for configuration in &own {
                rows.push(match cell(plan, planned, configuration, manifest) {
                    Some(cell) => cell.row(ledger, own.len())?,
                    None => Row::new(&planned.name, configuration, &[], Findings::default())?,
                });
            }
        }
        judge(&mut rows);
        let series = series((plan, configurations), manifest, ledger)?;
        let costs = costs(&series);
        let swept = plan.swept_keys();
        let Manifest { device, driver, .. } = manifest;
        let times = json!({
            "version": 1,
            "device": device,
            "driver": driver,
            "commit": manifest.commit,
            "rows": value_of("times", &costs)?,
        });
        let json = |value: serde_json::Value| format!("{value:#}\n").into_bytes();
        for (name, bytes) in [
            (ERRORS, tidy::results(&series, &swept)?),
            (COSTS, json(times)),
            (TIMES, tidy::times(&series, &swept)?),
            (SCHEMA, json(tidy::schema(&series, &swept))),
            // The last one, so that whoever finds it finds the others.
            (RESULTS, json(results_text::json(&rows, manifest)?)),
        ] {
            write_atomically(&self.folder.join(name), |file| file.write_all(&bytes))?;
        }
        let axes_file = self.folder.join(AXES);
        match axes::svg(&rows)? {
            Some(figure) => write_atomically(&axes_file, |file| write!(file, "{figure}"))?,
            // The figure of an earlier plan would stand beside other results.
            None => match std::fs::remove_file(&axes_file) {
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    return Err(Error::writing(&axes_file, error));
                }
                _ => {}
            },
        }
        Ok(Results { rows, costs })
    }
}

/// One configuration on one scene, with the identity of the scene from `manifest`; `None` if the scene was
/// not loaded yet.
fn cell<'a>(
    plan: &'a Plan,
    planned: &'a PlannedScene,
    configuration: &'a Resolved,
    manifest: &'a Manifest,
) -> Option<Cell<'a>> {
    Some(Cell {
        plan,
        planned,
        configuration,
        identity: manifest.identity(&planned.name)?,
    })
}

/// The finished runs, as one series for each configuration on each scene, in the order of the plan.
fn series<'a>(
    (plan, configurations): (&'a Plan, &'a [Resolved]),
    manifest: &'a Manifest,
    ledger: &'a Ledger,
) -> Result<Vec<Series<'a>>> {
    let mut all = Vec::new();
    for planned in &plan.scenes {
        for configuration in rendered_on(configurations, &planned.name) {
            let cell = cell(plan, planned, configuration, manifest);
            let runs = cell.map_or(Ok(Vec::new()), |cell| {
                cell.runs(&ledger.store, configuration, 0..plan.most_seeds())
            });
            all.push(Series {
                scene: &planned.name,
                configuration,
                runs: runs?,
            });
        }
    }
    Ok(all)
}

/// The costs of all series, in their order. Each is compared with the first series on the same scene that is
/// path tracing.
fn costs(series: &[Series<'_>]) -> Vec<Cost> {
    let of = |one: &Series<'_>| {
        let is_base = |s: &&Series<'_>| s.scene == one.scene && is_path_tracing(s.configuration);
        let base = series.iter().find(is_base);
        let base = base.map(|base| (base.configuration, base.runs.as_slice()));
        Cost::of(one.scene, (one.configuration, &one.runs), base)
    };
    series.iter().map(of).collect()
}
