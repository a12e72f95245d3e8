//! Formats the results of a study as tables for the terminal, and as JSON.

use super::bias::LEVEL;
use super::costs::{Cost, Ratio};
use super::manifest::Manifest;
use super::results::Row;
use crate::Result;
use crate::base::json::value_of;
use crate::base::printable::printable;
use serde_json::Value;
use std::fmt::Write as _;

/// The rows of a study's results as text for the terminal: a table of the verdicts with one line for each row, and a line
/// that explains the columns.
pub fn table(rows: &[Row]) -> String {
    // A name from a plan stays on its line.
    let printable_names = |row: &Row| Row {
        scene: printable(&row.scene),
        configuration: printable(&row.configuration),
        ..row.clone()
    };
    let rows: Vec<Row> = rows.iter().map(printable_names).collect();
    let (scenes, names) = widths(rows.iter().map(|row| (&row.scene, &row.configuration)));
    let mut text = format!(
        "{:scenes$} {:names$} {:>5} {:>8} {:>7} {:>9} {:>8} {:>8} {:>17}  {:>19} {:>6}  verdict\n",
        "scene",
        "configuration",
        "seeds",
        "bias %",
        "± 99 %",
        "90 % sees",
        "p (Holm)",
        "blocks p",
        "blocks % (99 %)",
        "rmse first → last",
        "median",
    );
    for row in &rows {
        let blocks = row.block_bias.map(|blocks| {
            let [low, high] = blocks.interval.map(|bias| 100.0 * bias);
            format!("{:.2} ({low:.2}–{high:.2})", 100.0 * blocks.relative)
        });
        let largest = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        let deciding = row.deciding().map(|(bias, _)| bias);
        let rmse = |rmse: Option<&f64>| rmse.map(|rmse| format!("{rmse:.5}"));
        let _ = writeln!(
            text,
            "{:scenes$} {:names$} {:5} {:>8} {:>7} {:>9} {:>8} {:>8} {:>17}  {:>8} → {:>8} {:>6}  {}{}{}",
            row.scene,
            row.configuration,
            deciding.map_or(row.seeds, |bias| bias.seeds),
            or_dash(deciding.map(|bias| {
                let bias = bias.relative.iter().copied().fold(0.0, largest);
                format!("{:+.3}", 100.0 * bias)
            })),
            or_dash(deciding.map(|bias| format!("{:.3}", 100.0 * bias.largest_half_width()))),
            or_dash(
                row.detectable_bias
                    .map(|bias| format!("{:.3}", 100.0 * bias))
            ),
            or_dash(deciding.map(|_| format!("{:.3}", row.corrected_p_value))),
            or_dash(row.blocks_p_value.map(|p| format!("{p:.3}"))),
            or_dash(blocks),
            or_dash(rmse(row.rmse.first())),
            or_dash(rmse(row.rmse.last())),
            or_dash(row.median.last().map(|median| format!("{median:.3}"))),
            row.verdict.text(),
            if row.confirmation.is_some() {
                " on fresh seeds"
            } else {
                ""
            },
            (row.complaint().map(str::to_owned))
                .or_else(|| row.open_question())
                .map_or(String::new(), |text| format!(": {text}")),
        );
    }
    let _ = writeln!(
        text,
        "bias: the largest of the channels' means, ± its 99 % half-width. 90 % sees: the bias that this check detects with a power of 90 %. p: chance of what was seen without bias; below {LEVEL} it counts. blocks %: root mean square of the bias of blocks, noise taken off, and its interval. median: that of the last frame's lit pixels, each over the reference."
    );
    text
}

/// The widths of the columns of scenes and configurations, in characters: each fits its longest name and its
/// title.
fn widths<'a>(names: impl Iterator<Item = (&'a String, &'a String)>) -> (usize, usize) {
    names.fold((5, 13), |(scenes, configurations), (scene, name)| {
        (
            scenes.max(scene.chars().count()),
            configurations.max(name.chars().count()),
        )
    })
}

fn or_dash(text: Option<String>) -> String {
    text.unwrap_or_else(|| "–".to_owned())
}

/// The costs of a study as text for the terminal: a table of times and of errors at equal time, then the
/// milliseconds of every pass. `rows` are the results, in the order of `costs`.
pub fn costs(costs: &[Cost], rows: &[Row]) -> String {
    let printable_names = |cost: &Cost| Cost {
        scene: printable(&cost.scene),
        configuration: printable(&cost.configuration),
        ..cost.clone()
    };
    let costs: Vec<Cost> = costs.iter().map(printable_names).collect();
    let (scenes, names) = widths(costs.iter().map(|cost| (&cost.scene, &cost.configuration)));
    let mut text = format!(
        "{:scenes$} {:names$} {:>9} {:>22} {:>19} {:>22} {:>22}\n",
        "scene",
        "configuration",
        "ms",
        "time (95 %)",
        "relMSE ± 95 %",
        "error at equal time",
        "clamped",
    );
    let ratio = |ratio: Option<Ratio>| {
        or_dash(ratio.map(|Ratio { value, interval }| {
            format!("{value:.2} ({:.2}–{:.2})", interval[0], interval[1])
        }))
    };
    for (cost, row) in costs.iter().zip(rows) {
        let error = row.relmse.last().map(|error| {
            let half_width = row.relmse_half_width.last().copied().flatten();
            let half_width = half_width.map_or(String::new(), |h| format!(" ± {h:.4}"));
            format!("{error:.4}{half_width}")
        });
        let has_time = !cost.milliseconds.is_empty();
        let _ = writeln!(
            text,
            "{:scenes$} {:names$} {:>9} {:>22} {:>19} {:>22} {:>22}",
            cost.scene,
            cost.configuration,
            or_dash(has_time.then(|| format!("{:.2}", cost.frame_milliseconds()))),
            ratio(cost.time_ratio),
            or_dash(error),
            ratio(cost.error_at_equal_time),
            ratio(cost.clamped_error_at_equal_time),
        );
    }
    text += "ms: median time of a frame on the device. time: relative to a frame of path tracing. relMSE: of the last frame. error at equal time: the root of the relMSE, and the clamped RMSE, of the last frame, relative to path tracing that had the same time.\n";
    text + &passes(&costs, rows)
}

/// The costs of one frame as text, with one line for each row of results: the milliseconds of every pass and the bytes per
/// pixel. If the plan requests counts, the line also has the rays, the percentage of lanes in use and the merged neighbours.
/// A second line has the times of the first execution of each pass, if they are known.
fn passes(costs: &[Cost], rows: &[Row]) -> String {
    let mut text = String::new();
    for (cost, row) in costs.iter().zip(rows) {
        let (scene, configuration) = (&cost.scene, &cost.configuration);
        let passes = cost.milliseconds.iter().map(|(pass, ms)| {
            let mut part = format!("{pass} {ms:.2} ms");
            let Some(counts) = row.counts.iter().find(|c| c.pass == *pass) else {
                return part;
            };
            let _ = write!(part, ", {} rays", counts.rays);
            for (what, fraction) in [
                ("tracing", counts.tracing_fraction()),
                ("merging", counts.merging_fraction()),
            ] {
                if let Some(fraction) = fraction {
                    let _ = write!(part, ", {:.0} % of lanes {what}", 100.0 * fraction);
                }
            }
            if counts.neighbours > 0 {
                let _ = write!(part, ", {} neighbours", counts.neighbours);
            }
            part
        });
        let passes = passes.collect::<Vec<_>>().join("; ");
        if !passes.is_empty() {
            let _ = writeln!(
                text,
                "{scene} {configuration}: {:.2} ms, {:.0} bytes per pixel ({passes})",
                cost.frame_milliseconds(),
                row.bytes_per_pixel
            );
        }
        if !cost.first_runs.is_empty() {
            let total: f64 = cost.first_runs.iter().map(|(_, ms)| ms).sum();
            let passes = cost.first_runs.iter();
            let passes = passes.map(|(pass, ms)| format!("{pass} {ms:.2} ms"));
            let _ = writeln!(
                text,
                "{scene} {configuration}, first runs with compilation, not counted above: {total:.2} ms ({})",
                passes.collect::<Vec<_>>().join("; ")
            );
        }
    }
    text
}

/// The rows of a study's results as JSON, with the names of the device and the driver, the commit of the program, and the
/// version of the format, which is 3. Since this version, times are in a file of their own, the noise of the reference is
/// taken out of errors, and values that are not known yet are null.
///
/// # Errors
/// The rows have no JSON form, which cannot happen with finite numbers.
pub fn json(rows: &[Row], manifest: &Manifest) -> Result<Value> {
    let rows = value_of("results", &rows)?;
    Ok(serde_json::json!({
        "version": 3,
        "device": manifest.device,
        "driver": manifest.driver,
        "commit": manifest.commit,
        "rows": rows,
    }))
}
