//! Draws the error and the bias of configurations over a parameter of the scene, as an SVG figure, for a study whose scenes
//! differ only in the value of that parameter. The figure shows for which values a configuration is better than another.

use super::results::Row;
use crate::{Error, Result};
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::collections::BTreeMap;

/// The width and height of a panel of the figure, in pixels. A panel is one chart: of the error or of the bias over one
/// parameter.
const PANEL: (u32, u32) = (360, 300);
/// The height of a line of the legend below the panels, in pixels. There is one line for each configuration.
const LINE: u32 = 20;
/// The maximum horizontal distance between two neighbouring error bars, as a fraction of the length of the axis. If several
/// configurations have an error bar at the same value of the parameter, the bars are drawn side by side, because otherwise
/// one bar would hide the others.
const BESIDE: f64 = 0.012;
/// The minimum number of scenes that a parameter needs to get panels in the figure, because a curve through fewer points
/// shows no trend. These scenes must differ only in the value of this parameter, which is part of the scene's name.
const LEAST: usize = 3;
/// The colours of the configurations, which colour-blind people can distinguish (Okabe and Ito, 2008). If there are more
/// configurations than colours, the colours are used again from the first one on.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// The result of one configuration on one scene: a point of the curve that the figure shows over a parameter of the scene.
struct Point {
    value: f64,
    /// The RMSE of the last frame, averaged over the seeds, as a fraction of the reference's mean radiance. The fraction
    /// makes bright and dark scenes comparable.
    error: f64,
    /// For the colour channel with the largest bias: the bias of the picture's mean, and then the half-width of the 99 %
    /// interval of this bias. Both are in percent of the reference's mean. The figure shows them as an error bar.
    bias: [f64; 2],
}

/// The points of the figure, grouped into panels and curves. The outer key is a pair: the name of a scene without its
/// parameter, and the name of the parameter in which the scenes with this name differ. Each such pair has two panels. The
/// inner key is the name of a configuration, and its value is the configuration's curve with one point per scene.
type Axes<'a> = BTreeMap<(&'a str, &'a str), BTreeMap<&'a str, Vec<Point>>>;

/// Draws a figure from the rows of a study's results, and returns the text of an SVG file. It uses only scenes that have
/// exactly one parameter, whose value is a positive number, because the axis is logarithmic. If some configuration has
/// results on at least three scenes that differ only in this parameter, the parameter gets one panel for the error and one
/// for the bias, each with a curve for every configuration. Returns `None` if no parameter gets panels.
///
/// # Errors
/// The drawing library fails.
pub fn svg(rows: &[Row]) -> Result<Option<String>> {
    let mut axes = Axes::new();
    for row in rows {
        let Some((scene, (key, value))) = (row.scene.split_once(':'))
            .and_then(|(scene, setting)| Some((scene, setting.split_once('=')?)))
        else {
            continue;
        };
        // A second setting would not be a number.
        let Some(value) = value.parse().ok().filter(|value: &f64| *value > 0.0) else {
            continue;
        };
        let Some((bias, _)) = row.deciding() else {
            continue;
        };
        let channels = [0, 1, 2].map(|channel| [bias.relative[channel], bias.half_width[channel]]);
        let largest = |a: [f64; 2], b: [f64; 2]| if b[0].abs() > a[0].abs() { b } else { a };
        let point = Point {
            value,
            error: row.rmse.last().copied().unwrap_or(0.0) / bias.brightness(),
            bias: channels
                .into_iter()
                .reduce(largest)
                .unwrap_or_default()
                .map(|b| 100.0 * b),
        };
        let lines = axes.entry((scene, key)).or_default();
        lines.entry(&row.configuration).or_default().push(point);
    }
    axes.retain(|_, lines| lines.values().any(|points| points.len() >= LEAST));
    if axes.is_empty() {
        return Ok(None);
    }
    for points in axes.values_mut().flat_map(BTreeMap::values_mut) {
        points.sort_by(|a, b| a.value.total_cmp(&b.value));
    }
    let mut text = String::new();
    draw(&axes, &mut text).map_err(|e| Error::failed(format!("the figure of axes: {e}")))?;
    Ok(Some(text))
}

/// An error of the drawing library. The library writes the figure to a text in memory, so files are never the cause.
type Failure = Box<dyn std::error::Error>;

fn draw(axes: &Axes<'_>, text: &mut String) -> std::result::Result<(), Failure> {
    let mut names: Vec<&str> = axes.values().flat_map(BTreeMap::keys).copied().collect();
    names.sort_unstable();
    names.dedup();
    let (width, height) = (PANEL.0 * axes.len() as u32, 2 * PANEL.1);
    let size = (width, height + LINE * (names.len() as u32 + 1));
    let root = SVGBackend::with_string(text, size).into_drawing_area();
    root.fill(&WHITE)?;
    let (panels, legend) = root.split_vertically(height);
    let panels = panels.split_evenly((2, axes.len()));
    let color = |name: &str| {
        let index = names.iter().position(|known| *known == name);
        COLORS[index.unwrap_or(0) % COLORS.len()]
    };
    for (column, ((scene, key), lines)) in axes.iter().enumerate() {
        let points = || lines.values().flatten();
        let values = range(points().map(|point| point.value));
        let errors = range(points().map(|point| point.error));
        let title = format!("{scene}: {key}");
        let (above, below) = (&panels[column], &panels[axes.len() + column]);

        let mut chart = chart(
            above,
            &title,
            "RMSE / mean",
            values.clone(),
            errors.log_scale(),
        )?;
        for (name, points) in lines {
            let line = points.iter().map(|point| (point.value, point.error));
            chart.draw_series(LineSeries::new(line, color(name)).point_size(3))?;
        }

        let widest = points().map(|point| point.bias[0].abs() + point.bias[1]);
        let widest = widest.fold(1.0, f64::max);
        let mut chart = self::chart(below, "", "bias, ± 99 %", values, -widest..widest)?;
        let beside = BESIDE.min(0.1 / lines.len() as f64);
        for (index, (name, points)) in lines.iter().enumerate() {
            // Beside each other, or bars of the same value would hide all but the last one.
            let aside = index as f64 - 0.5 * (lines.len() - 1) as f64;
            let aside = (chart.x_range().end / chart.x_range().start).powf(beside * aside);
            chart.draw_series(points.iter().map(|point| {
                let [bias, half_width] = point.bias;
                let (low, high) = (bias - half_width, bias + half_width);
                let at = point.value * aside;
                ErrorBar::new_vertical(at, low, bias, high, color(name).filled(), 6)
            }))?;
        }
    }
    for (index, name) in names.iter().enumerate() {
        let (x, y) = (20, (LINE / 2 + LINE * index as u32) as i32);
        let mark = [(x, y), (x + 14, y + 8)];
        legend.draw(&Rectangle::new(mark, color(name).filled()))?;
        legend.draw(&Text::new(*name, (x + 20, y - 3), ("sans-serif", 14)))?;
    }
    root.present()?;
    Ok(())
}

/// A chart whose horizontal axis shows the values of a parameter on a logarithmic scale.
type Chart<'a, 'b, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<LogCoord<f64>, Y>>;

/// Prepares a chart in `area`, draws its axes and the caption `title`, and returns the chart, so that the caller can draw
/// curves into it. The horizontal axis covers the range `values` of the parameter on a logarithmic scale. The vertical axis
/// has the range and the scale of `up`, and the label `what`.
fn chart<'a, 'b, Y: AsRangedCoord<Value = f64>>(
    area: &'a DrawingArea<SVGBackend<'b>, plotters::coord::Shift>,
    title: &str,
    what: &str,
    values: std::ops::Range<f64>,
    up: Y,
) -> std::result::Result<Chart<'a, 'b, Y::CoordDescType>, Failure>
where
    Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
{
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 16))
        .margin(10)
        .x_label_area_size(30)
        .y_label_area_size(60)
        .build_cartesian_2d(values.log_scale(), up)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .y_desc(what)
        .x_labels(6)
        .x_label_formatter(&short)
        .y_label_formatter(&short)
        .draw()?;
    Ok(chart)
}

/// A number as text with at most two significant digits, so that the labels of axes are short.
fn short(number: &f64) -> String {
    let rounded: f64 = format!("{number:.1e}").parse().unwrap_or(*number);
    match rounded.abs() {
        0.0 => "0".into(),
        0.001..1e4 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

/// The range of a logarithmic axis that includes all positive numbers of `values`, with a margin at both ends. Numbers that
/// are not positive are left out; if there are no others, the range is 0.5 to 2.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values
        .filter(|value| *value > 0.0)
        .fold((f64::INFINITY, 0.0_f64), |(low, high), v| {
            (low.min(v), high.max(v))
        });
    if low > high {
        0.5..2.0
    } else {
        let room = (high / low).powf(0.06).max(1.4);
        low / room..high * room
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let numbers = [0.1 + 0.2, 0.0, -1.25, 1e-10 * 1.0000001, 9.9999e7, 1000.0];
        let texts = numbers.map(|number| short(&number));
        assert_eq!(texts, ["0.3", "0", "-1.2", "1e-10", "1e8", "1000"]);
    }
}
