//! Profiles as text, which scripts can read. Each line begins with a word that says what it describes, such as `frame`,
//! `pass NAME` or `memory NAME`, and then has its values in a fixed order. The line with the names of the columns begins
//! with `#`.

use super::Profile;
use crate::base::printable::printable;
use crate::render::counters::Counts;
use std::fmt::Write;

/// `value` in millions, as text with three decimals: 1,500,000 is `1.500`. Used for numbers of rays and of bytes.
fn millions(value: u64) -> String {
    format!("{:.3}", value as f64 / 1e6)
}

/// The fraction `part` as text: a percentage with one decimal and without the percent sign, so that 0.5 is `50.0`. `None` is
/// a dash.
fn percent(part: Option<f64>) -> String {
    part.map_or_else(|| "-".into(), |part| format!("{:.1}", 100.0 * part))
}

/// A profile as text: what was measured, the times of the frame, one line per pass with its times and counts, and the memory
/// on the device. `README.md` in the folder of this file explains the columns.
pub fn table(profile: &Profile) -> String {
    let mut text = String::new();
    let subject = &profile.subject;
    let mut line = |content: std::fmt::Arguments<'_>| {
        let _ = writeln!(text, "{}", printable(&content.to_string()));
    };
    line(format_args!(
        "profile {} {}x{} bounces {} frames {} after {}",
        subject.scene,
        subject.width,
        subject.height,
        subject.bounces,
        subject.frames,
        subject.warm_up
    ));
    line(format_args!(
        "device {}; {}; {}; {}",
        subject.device,
        profile.circumstances.driver,
        profile.circumstances.tracer,
        profile.circumstances.geometry
    ));
    if profile.circumstances.in_flight <= 1 {
        line(format_args!(
            "frame median {:.3} ms p95 {:.3} ms",
            profile.frame.median, profile.frame.p95
        ));
    }
    line(format_args!(
        "host median {:.3} ms p95 {:.3} ms",
        profile.host.median, profile.host.p95
    ));
    line(format_args!(
        "{:24} {:>4} {:>10} {:>10} {:>6} {:>9} {:>6} {:>6} {:>6} {:>9} {:>9} {:>10} {:>9} {:>9}",
        "#",
        "runs",
        "median_ms",
        "p95_ms",
        "%",
        "Mrays",
        "hit_%",
        "lane_%",
        "merg_%",
        "read_MB",
        "write_MB",
        "neighbours",
        "first_ms",
        "pipe_ms"
    ));
    for pass in &profile.passes {
        let counts = &pass.counts;
        let hits = (counts.rays > 0).then(|| counts.hits as f64 / counts.rays as f64);
        line(format_args!(
            "{:24} {:>4} {:>10.3} {:>10.3} {:>6} {:>9} {:>6} {:>6} {:>6} {:>9} {:>9} {:>10} {:>9.1} {:>9.1}",
            format!("pass {}", pass.name),
            pass.runs,
            pass.milliseconds.median,
            pass.milliseconds.p95,
            percent(Some(pass.milliseconds.median / profile.whole().median)),
            millions(counts.rays),
            percent(hits),
            percent(counts.tracing_fraction()),
            percent(counts.merging_fraction()),
            millions(counts.bytes_read),
            millions(counts.bytes_written),
            counts.neighbours,
            pass.first_run,
            pass.pipeline
        ));
        for (name, value) in &pass.statistics {
            line(format_args!("compiled {} {name}: {value}", pass.name));
        }
    }
    let counts = || profile.passes.iter().map(|pass| &pass.counts);
    let sum = |of: fn(&Counts) -> u64| -> u64 { counts().map(of).sum() };
    let vertices = sum(|counts| counts.vertices);
    if vertices > 0 {
        line(format_args!(
            "world_reservoirs vertices {vertices} cells {} places {} dropped {}",
            sum(|counts| counts.cells),
            sum(|counts| counts.slots),
            sum(|counts| counts.dropped)
        ));
    }
    let sum: f64 = profile
        .passes
        .iter()
        .map(|pass| pass.milliseconds.median)
        .sum();
    line(format_args!(
        "sum of passes {sum:.3} ms, {:.1} % of the frame; {} Mrays",
        100.0 * sum / profile.whole().median,
        millions(profile.rays())
    ));
    for memory in &profile.memory {
        line(format_args!(
            "memory {} {} {}",
            memory.name, memory.count, memory.bytes
        ));
    }
    line(format_args!("memory_total {}", profile.bytes()));
    text.truncate(text.trim_end().len());
    text
}

/// A table that compares two profiles, with one line for the frame and one for each pass, so that a user sees which pass
/// became slower. The columns are the median time in the earlier profile and now, in milliseconds, and the change in
/// percent. A pass that only one of the profiles lists has dashes for the missing time and the change.
pub fn difference(now: &Profile, earlier: &Profile) -> String {
    let mut text = format!(
        "{:24} {:>10} {:>10} {:>8}",
        "#", "before_ms", "now_ms", "change_%"
    );
    let mut row = |name: String, before: Option<f64>, now: Option<f64>| {
        let time = |time: Option<f64>| time.map_or_else(|| "-".into(), |t| format!("{t:.3}"));
        let change = before
            .zip(now)
            .map(|(before, now)| format!("{:+.1}", 100.0 * (now / before - 1.0)));
        let change = change.unwrap_or_else(|| "-".into());
        let _ = write!(
            text,
            "\n{:24} {:>10} {:>10} {change:>8}",
            printable(&name),
            time(before),
            time(now)
        );
    };
    row(
        "frame".into(),
        Some(earlier.whole().median),
        Some(now.whole().median),
    );
    let find = |profile: &Profile, name: &str| {
        let mut passes = profile.passes.iter();
        passes
            .find(|pass| pass.name == name)
            .map(|pass| pass.milliseconds.median)
    };
    for pass in &now.passes {
        row(
            format!("pass {}", pass.name),
            find(earlier, &pass.name),
            find(now, &pass.name),
        );
    }
    for pass in earlier
        .passes
        .iter()
        .filter(|pass| find(now, &pass.name).is_none())
    {
        row(
            format!("pass {}", pass.name),
            find(earlier, &pass.name),
            None,
        );
    }
    text
}
