//! The finished runs of a study as tidy tables (one row for each seed and frame, one column for each variable), which tools
//! for statistics load with one line; and a schema that states the meaning and the unit of each column.

use super::plan::Resolved;
use super::run::Run;
use crate::base::printable::printable;
use crate::{Error, Result};
use serde_json::{Map, Value, json};

/// The finished runs of one configuration on one scene, which become rows of the tables.
pub struct Series<'a> {
    /// The name of the scene in the plan, for the column `scene`.
    pub scene: &'a str,
    /// The configuration, whose settings fill the columns of swept keys.
    pub configuration: &'a Resolved,
    /// The finished runs, in the order of their seeds.
    pub runs: Vec<&'a Run>,
}

/// A column of the table of errors: its name, its unit, its meaning for the schema, and a function that
/// returns its value for a run and the index of a frame.
struct Column {
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    value: fn(&Run, usize) -> f64,
}

const RADIANCE: &str = "W/(m² sr), or the unit of the scene";

const MEASURES: [Column; 8] = [
    Column {
        name: "mse",
        unit: "square of the unit of radiance",
        meaning: "mean squared error of the frame, over pixels and channels of linear RGB; the noise of the reference is taken out",
        value: |run, frame| run.mse[frame],
    },
    Column {
        name: "clamped_mse",
        unit: "1",
        meaning: "the same, with all values clamped to [0, 1]",
        value: |run, frame| run.clamped_mse[frame],
    },
    Column {
        name: "relmse",
        unit: "1",
        meaning: "mean of (value − truth)² / (reference² + 0.01), over pixels and channels; the noise of the reference is taken out",
        value: |run, frame| run.relmse[frame],
    },
    Column {
        name: "correlation",
        unit: "1",
        meaning: "Pearson's correlation of the errors of this frame and of the frame before it; 0 in frame 0",
        value: |run, frame| run.correlation[frame],
    },
    Column {
        name: "median",
        unit: "1",
        meaning: "median over the lit pixels of their luminance, divided by that of the reference",
        value: |run, frame| run.median[frame],
    },
    Column {
        name: "mean_r",
        unit: RADIANCE,
        meaning: "mean of the red channel over the picture, without directly visible emitters; of the frames that are tested for bias, and the same for all frames of a run",
        value: |run, _| run.mean[0],
    },
    Column {
        name: "mean_g",
        unit: RADIANCE,
        meaning: "the same of the green channel",
        value: |run, _| run.mean[1],
    },
    Column {
        name: "mean_b",
        unit: RADIANCE,
        meaning: "the same of the blue channel",
        value: |run, _| run.mean[2],
    },
];

/// The errors of all runs as the bytes of the file `results.csv`: one row for each run and frame. `swept` are
/// the dotted keys of the settings that the plan varies; each gets a column with its value.
///
/// # Errors
/// A setting has no JSON form, which cannot happen with finite numbers.
pub fn results(series: &[Series<'_>], swept: &[String]) -> Result<Vec<u8>> {
    let names = MEASURES.iter().map(|column| column.name.to_owned());
    table(series, swept, names.collect(), |run, frame| {
        let values = MEASURES.iter();
        values
            .map(|column| (column.value)(run, frame).to_string())
            .collect()
    })
}

/// The times of all runs in milliseconds, as the bytes of the file `times.csv`: one row for each run and
/// frame, with a column for the whole frame and one for each pass. A field is empty if the frame has no such
/// pass, or if the pass was executed for the first time.
///
/// # Errors
/// As for [`results`].
pub fn times(series: &[Series<'_>], swept: &[String]) -> Result<Vec<u8>> {
    let passes = passes(series);
    let names = std::iter::once("milliseconds").chain(passes.iter().copied());
    let names = names.map(str::to_owned).collect();
    table(series, swept, names, |run, frame| {
        let own = &run.milliseconds[frame];
        let total = own.iter().map(|(_, ms)| ms).copied().reduce(|a, b| a + b);
        let of_pass = passes.iter().map(|pass| {
            let time = own.iter().find(|(name, _)| name == pass);
            time.map_or(String::new(), |(_, ms)| ms.to_string())
        });
        let total = total.map_or(String::new(), |ms| ms.to_string());
        std::iter::once(total).chain(of_pass).collect()
    })
}

/// The names of all passes of the runs, each once, in the order in which they first occur. Each gets a column
/// in `times.csv`.
fn passes<'a>(series: &[Series<'a>]) -> Vec<&'a str> {
    let mut passes: Vec<&str> = Vec::new();
    let runs = series.iter().flat_map(|series| &series.runs);
    for (name, _) in runs.flat_map(|run| run.milliseconds.iter().flatten()) {
        if !passes.contains(&name.as_str()) {
            passes.push(name);
        }
    }
    passes
}

/// The contents of the file `schema.json`, as JSON: the name, the unit and the meaning of each column of both
/// tables.
pub fn schema(series: &[Series<'_>], swept: &[String]) -> Value {
    let column = |name: &str, unit: &str, meaning: &str| json!({ "name": name, "unit": unit, "meaning": meaning });
    let mut keys = vec![
        column("scene", "text", "name of the scene in the plan"),
        column(
            "configuration",
            "text",
            "name of the configuration in the plan",
        ),
    ];
    keys.extend(
        swept
            .iter()
            .map(|key| column(key, "text or number", "value of this setting")),
    );
    keys.push(column(
        "seed",
        "1",
        "seed of the run; runs with different seeds are independent",
    ));
    keys.push(column(
        "frame",
        "1",
        "index of the frame in its run, from 0",
    ));
    let measures = MEASURES.iter().map(|c| column(c.name, c.unit, c.meaning));
    let whole = column(
        "milliseconds",
        "ms",
        "time of the frame on the device, without passes that were executed for the first time",
    );
    let passes = passes(series);
    let passes = passes
        .iter()
        .map(|pass| column(pass, "ms", "time of this pass in the frame"));
    let mut tables = Map::new();
    tables.insert(
        "results.csv".into(),
        keys.iter().cloned().chain(measures).collect(),
    );
    tables.insert(
        "times.csv".into(),
        keys.into_iter().chain([whole]).chain(passes).collect(),
    );
    Value::Object(tables)
}

fn table(
    series: &[Series<'_>],
    swept: &[String],
    names: Vec<String>,
    values: impl Fn(&Run, usize) -> Vec<String>,
) -> Result<Vec<u8>> {
    let failed = |e: csv::Error| Error::failed(format!("a table of the study: {e}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let fixed = ["scene", "configuration"].map(str::to_owned).into_iter();
    let indices = ["seed", "frame"].map(str::to_owned);
    let header = fixed
        .chain(swept.iter().cloned())
        .chain(indices)
        .chain(names);
    writer.write_record(header).map_err(failed)?;
    for one in series {
        let settings = one.configuration.settings.to_value()?;
        let of_keys = swept.iter().map(|key| {
            let value = key
                .split('.')
                .try_fold(&settings, |tree, part| tree.get(part));
            value.map_or(String::new(), |v| {
                v.as_str().map_or(v.to_string(), str::to_owned)
            })
        });
        let names = [one.scene, &one.configuration.name]
            .map(printable)
            .into_iter();
        let fixed: Vec<String> = names.chain(of_keys).collect();
        for run in &one.runs {
            for frame in 0..run.relmse.len() {
                let indices = [run.seed.to_string(), frame.to_string()];
                let record = fixed
                    .iter()
                    .cloned()
                    .chain(indices)
                    .chain(values(run, frame));
                writer.write_record(record).map_err(failed)?;
            }
        }
    }
    writer
        .into_inner()
        .map_err(|e| Error::failed(format!("a table of the study: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Settings;

    fn run(seed: u32) -> Run {
        let frames = vec![0.25, 0.5];
        Run {
            seed,
            mse: frames.clone(),
            clamped_mse: frames.clone(),
            relmse: frames.clone(),
            correlation: frames.clone(),
            median: frames,
            milliseconds: vec![vec![], vec![("shade".into(), 1.5)]],
            ..Run::default()
        }
    }

    #[test]
    fn a_row_is_one_seed_and_frame_and_every_column_is_explained() {
        let runs = [run(0), run(1)];
        let configuration = Resolved::of(Settings::default());
        let series = [Series {
            scene: "a, \"b\"\n",
            configuration: &configuration,
            runs: runs.iter().collect(),
        }];
        let swept = ["direct.light_samples".to_owned()];
        let schema = schema(&series, &swept);
        for (name, bytes) in [
            ("results.csv", results(&series, &swept).unwrap()),
            ("times.csv", times(&series, &swept).unwrap()),
        ] {
            let mut reader = csv::Reader::from_reader(bytes.as_slice());
            let header: Vec<String> = reader
                .headers()
                .unwrap()
                .iter()
                .map(str::to_owned)
                .collect();
            let explained = schema[name].as_array().unwrap().iter();
            let explained: Vec<&str> = explained.map(|c| c["name"].as_str().unwrap()).collect();
            assert_eq!(header, explained);
            let rows: Vec<csv::StringRecord> = reader
                .records()
                .collect::<std::result::Result<_, _>>()
                .unwrap();
            assert_eq!(rows.len(), 4);
            assert!(rows.iter().all(|row| row.len() == header.len()));
            assert_eq!(&rows[3][2], "10");
            assert_eq!((&rows[3][3], &rows[3][4]), ("1", "1"));
            assert_eq!(&rows[3][5], if name == "times.csv" { "1.5" } else { "0.5" });
        }
    }
}
