//! Formats the results of a study as a table for the terminal, as CSV and as JSON.

use super::bias::LEVEL;
use super::results::Row;
use crate::Result;
use crate::base::json::value_of;
use crate::base::printable::printable;
use serde_json::Value;
use std::fmt::Write as _;

/// The rows of a study's results as text for the terminal: a table with one line for each row, then the costs of each row,
/// and then a line that explains the columns.
pub fn table(rows: &[Row]) -> String {
    // A name from a plan stays on its line.
    let printable_names = |row: &Row| Row {
        scene: printable(&row.scene),
        configuration: printable(&row.configuration),
        ..row.clone()
    };
    let rows: Vec<Row> = rows.iter().map(printable_names).collect();
    let width = |least: usize, text: fn(&Row) -> &str| {
        let longest = rows.iter().map(|row| text(row).chars().count()).max();
        longest.unwrap_or(0).max(least)
    };
    let (scenes, names) = (width(5, |r| &r.scene), width(13, |r| &r.configuration));
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
        let (bias, _) = row.deciding();
        let blocks = row.block_bias.map_or("–".to_owned(), |blocks| {
            let [low, high] = blocks.interval.map(|bias| 100.0 * bias);
            format!("{:.2} ({low:.2}–{high:.2})", 100.0 * blocks.relative)
        });
        let largest = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        let _ = writeln!(
            text,
            "{:scenes$} {:names$} {:5} {:+8.3} {:7.3} {:9.3} {:8.3} {:8.3} {blocks:>17}  {:8.5} → {:8.5} {:6.3}  {}{}{}",
            row.scene,
            row.configuration,
            bias.seeds,
            100.0 * bias.relative.iter().copied().fold(0.0, largest),
            100.0 * bias.largest_half_width(),
            100.0 * row.detectable_bias,
            row.corrected_p_value,
            row.blocks_p_value,
            row.rmse.first().copied().unwrap_or(0.0),
            row.rmse.last().copied().unwrap_or(0.0),
            row.median.last().copied().unwrap_or(1.0),
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
    text += &costs(&rows);
    let _ = writeln!(
        text,
        "bias: the largest of the channels' means, ± its 99 % half-width. 90 % sees: the bias that this check detects with a power of 90 %. p: chance of what was seen without bias; below {LEVEL} it counts. blocks %: root mean square of the bias of blocks, noise taken off, and its interval. median: that of the last frame's lit pixels, each over the reference."
    );
    text
}

/// The costs of one frame as text, with one line for each row of results: the milliseconds of every pass and the bytes per
/// pixel. If the plan requests counts, the line also has the rays, the percentage of lanes in use and the merged neighbours.
/// A second line has the times of the first execution of each pass, if they are known.
fn costs(rows: &[Row]) -> String {
    let mut text = String::new();
    for row in rows {
        let total: f64 = row.milliseconds.iter().map(|(_, ms)| ms).sum();
        let passes = row.milliseconds.iter().map(|(pass, ms)| {
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
        let _ = writeln!(
            text,
            "{} {}: {total:.2} ms, {:.0} bytes per pixel ({passes})",
            row.scene, row.configuration, row.bytes_per_pixel
        );
        if !row.first_runs.is_empty() {
            let total: f64 = row.first_runs.iter().map(|(_, ms)| ms).sum();
            let passes = row.first_runs.iter();
            let passes = passes.map(|(pass, ms)| format!("{pass} {ms:.2} ms"));
            let _ = writeln!(
                text,
                "{} {}, first runs with compilation, not counted above: {total:.2} ms ({})",
                row.scene,
                row.configuration,
                passes.collect::<Vec<_>>().join("; ")
            );
        }
    }
    text
}

/// The rows of a study's results as CSV for other programs, with one line for each frame of each row. The milliseconds are
/// the sum of [`Row::milliseconds`] over the passes. The rays are those of the last frame; their field is empty if the plan
/// does not request counts. The fields of the block bias are empty if a row has none.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "scene,configuration,seeds,frame,rmse,rmse_clamped,relmse,correlation,bias_r,bias_g,bias_b,half_width,verdict,milliseconds,rays,bytes_per_pixel,block_bias,block_bias_low,block_bias_high,median\n",
    );
    let quoted = |s: &str| format!("\"{}\"", printable(s).replace('"', "\"\""));
    for row in rows {
        let (bias, _) = row.deciding();
        let [r, g, b] = bias.relative;
        // Empty where nothing is known.
        let blocks = row
            .block_bias
            .map_or([const { String::new() }; 3], |blocks| {
                let [low, high] = blocks.interval;
                [blocks.relative, low, high].map(|value| value.to_string())
            });
        let blocks = blocks.join(",");
        let milliseconds: f64 = row.milliseconds.iter().map(|(_, ms)| ms).sum();
        let rays: u64 = row.counts.iter().map(|c| c.rays).sum();
        let rays = if row.counts.is_empty() {
            String::new()
        } else {
            rays.to_string()
        };
        for frame in 0..row.rmse.len() {
            let _ = writeln!(
                text,
                "{},{},{},{frame},{},{},{},{},{r},{g},{b},{},{},{milliseconds},{rays},{},{blocks},{}",
                quoted(&row.scene),
                quoted(&row.configuration),
                row.seeds,
                row.rmse[frame],
                row.rmse_clamped[frame],
                row.relmse[frame],
                row.correlation[frame],
                bias.largest_half_width(),
                row.verdict.text(),
                row.bytes_per_pixel,
                row.median[frame],
            );
        }
    }
    text
}

/// The rows of a study's results as JSON, with the names of the device and the driver, the commit of the program, and the
/// version of the format, which is 2. In version 1, the verdict `undecided` was `unclear` and had no `missing`, `any` was
/// not an expectation, `detectable_bias` was `found_nine_times_in_ten`, and the times in `first_runs` were among
/// `milliseconds`.
///
/// # Errors
/// The rows have no JSON form, which cannot happen with finite numbers.
pub fn json(rows: &[Row], device: &str, driver: &str) -> Result<Value> {
    let rows = value_of("results", &rows)?;
    Ok(serde_json::json!({
        "version": 2,
        "device": device,
        "driver": driver,
        "commit": env!("HEADWATER_COMMIT"),
        "rows": rows,
    }))
}
