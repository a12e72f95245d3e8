//! The advice as text: sentences with the recommendation, the conditions of the measurement, and a table.

use super::chain::Purpose;
use super::front::{Front, Measured, Point, Verdict};
use crate::base::milliseconds;

/// The advice in a few sentences: the recommended settings, their frame time and error, the error of path
/// tracing in the same time, the bias, and the comparison with other finalists.
pub fn advice(front: &Front) -> String {
    let verdict = front.verdict;
    let Some(best) = front.finalists.first() else {
        return "undecided: nothing was measured".to_owned();
    };
    let factor = match verdict {
        Verdict::Undecided(factor) => Some(factor),
        Verdict::Better | Verdict::Cheaper | Verdict::Likely => None,
    };
    if let Some(factor) = factor {
        let seconds = (front.seconds * factor).ceil();
        return format!(
            "Undecided: after {:.0} s, the error of `{}` is not known within a factor of two; --time {seconds} may suffice.",
            front.seconds, best.candidate.name
        );
    }
    let mut text = format!(
        "Use `{}`: {} per frame of {} × {}, error {}.",
        best.candidate.name,
        time(best),
        front.wanted_size.0,
        front.wanted_size.1,
        percent(&best.error)
    );
    if let Some(path_tracing) = path_tracing(front).filter(|p| p.candidate != best.candidate) {
        let error = path_tracing.error_in(best.milliseconds);
        text += &format!(" Path tracing for the same time: {}.", percent(&error));
    }
    text += &if best.bias.is_found() {
        format!(
            " Its mean is off by {:+.1} % ± {:.1} %, which may be a bias.",
            100.0 * best.bias.relative,
            100.0 * best.bias.half_width
        )
    } else {
        format!(" No bias found above {:.1} %.", 100.0 * best.bias.bound())
    };
    if let Some(second) = front.finalists.get(1) {
        let name = &second.candidate.name;
        text += &match verdict {
            Verdict::Cheaper => {
                format!(" `{name}` cannot be told apart from it at equal time, and costs more.")
            }
            Verdict::Likely => format!(
                " Whether `{name}` is worse at equal time is not certain; a longer --time can decide."
            ),
            Verdict::Better | Verdict::Undecided(_) => String::new(),
        };
    }
    if let Some(better) = lower_error(front, best) {
        text += &format!(
            " `{}` has {:.2} of the error for {:.1} times the time.",
            better.candidate.name,
            better.error.value / best.error.value,
            better.milliseconds / best.milliseconds
        );
    }
    text
}

/// The measurements of path tracing in the final; `None` if path tracing is not among the finalists.
fn path_tracing(front: &Front) -> Option<&Point> {
    let is_path_tracing = |p: &&Point| p.candidate.is_path_tracing().unwrap_or(false);
    front.finalists.iter().find(is_path_tracing)
}

/// The finalist with the smallest error, if its whole confidence interval is below the error of `best`, the
/// recommended one. Finalists with empty pictures are left out. The advice mentions it, because the user may
/// accept its longer time. `None` if there is no such finalist.
fn lower_error<'a>(front: &'a Front, best: &Point) -> Option<&'a Point> {
    let is_empty = |p: &Point| path_tracing(front).is_some_and(|pt| p.is_empty(pt));
    let others = (front.finalists.iter()).filter(|p| p.candidate != best.candidate && !is_empty(p));
    let least = others.min_by(|a, b| a.error.value.total_cmp(&b.error.value))?;
    let highest = least.error.interval.map_or(f64::INFINITY, |[_, high]| high);
    (highest < best.error.value).then_some(least)
}

/// The conditions of the measurement in one line of text: the frames, seeds, picture size and references with
/// which the errors were measured, and the time that this took.
pub fn details(front: &Front) -> String {
    let frames = match front.purpose {
        Purpose::Still => "the first frame".to_owned(),
        Purpose::Steady => format!(
            "frames {} to {} of a camera at rest",
            front.purpose.frames() / 2,
            front.purpose.frames() - 1
        ),
        Purpose::Mean => format!("the mean of {} frames", front.purpose.frames()),
        Purpose::Motion => format!(
            "frame {} of a moving camera (by itself, or sideways by a thousandth of the scene per frame)",
            front.purpose.frames() - 1
        ),
    };
    format!(
        "Error: root of the relMSE of {frames}, the geometric mean over {} seeds (the largest has {:.1} %), ± half of its 95 % interval, at {} × {} with two references of {} samples per pixel (and the frames of all candidates); measured in {:.0} s, after {:.0} s for the compilation of shaders.",
        front.finalists.first().map_or(0, |point| point.chains),
        front
            .finalists
            .first()
            .map_or(0.0, |point| 100.0 * point.largest_error),
        front.size.0,
        front.size.1,
        front.reference_samples,
        front.seconds,
        front.compilation_seconds
    )
}

/// A table in text with one line per measured candidate: its name, frame time in milliseconds, error in
/// percent, and number of seeds. The finalists come first, then the candidates that were left out.
pub fn table(front: &Front) -> String {
    let points = front.points();
    let names = points.iter().map(|p| p.candidate.name.chars().count());
    let width = names.max().unwrap_or(0).max(9);
    let mut text = format!(
        "{:width$} {:>10} {:>20} {:>5}",
        "candidate", "ms", "error", "seeds"
    );
    for (index, point) in points.into_iter().enumerate() {
        // The first references of the race were too noisy for an interval to be honest.
        let error = match index < front.finalists.len() {
            true => percent(&point.error),
            false => about(&point.error),
        };
        text += &format!(
            "\n{:width$} {:>10.1} {:>20} {:>5}",
            point.candidate.name, point.milliseconds, error, point.chains
        );
    }
    text
}

fn time(point: &Point) -> String {
    milliseconds::text(point.milliseconds, point.is_timed)
}

fn percent(error: &Measured) -> String {
    let half_width = error.half_width();
    let value = 100.0 * error.value;
    if half_width.is_finite() {
        format!("{value:.1} % ± {:.1} %", 100.0 * half_width)
    } else {
        about(error)
    }
}

fn about(error: &Measured) -> String {
    format!("about {:.1} %", 100.0 * error.value)
}
