//! Compares the configurations of one scene by their errors at equal time, and states which one to use.

use super::costs::{Cost, Ratio, is_path_tracing};
use super::plan::Resolved;
use super::results::{Row, Verdict};
use crate::page::{Answer, Standing};
use std::cmp::Ordering;

/// A configuration counts as empty, and is not advised, if its [`Row::median`] is below this fraction of that
/// of path tracing: most of its pixels are too dark, so a small error does not mean a good picture.
const LEAST_MEDIAN: f64 = 0.5;

/// The error at equal time of path tracing, relative to itself: exactly 1.
const ITSELF: Ratio = Ratio {
    value: 1.0,
    interval: [1.0, 1.0],
};

/// One configuration of a scene with its errors, verdict and times, by which the comparison ranks it.
#[derive(Clone, Copy)]
pub struct Entry<'a> {
    /// The configuration, with complete settings.
    pub configuration: &'a Resolved,
    /// The errors and the verdict of the configuration.
    pub row: &'a Row,
    /// The times of the configuration, and its errors at equal time.
    pub cost: &'a Cost,
    /// True if this is the path tracing with which the other configurations are compared.
    pub is_base: bool,
    /// True if most lit pixels are too dark (see [`LEAST_MEDIAN`]); such a configuration is not advised.
    is_empty: bool,
}

impl Entry<'_> {
    /// True if the time and the error of a frame are known, so that the configuration can be ranked.
    fn is_measured(&self) -> bool {
        self.milliseconds() > 0.0 && self.error().is_finite()
    }

    /// The time of the measured picture, in milliseconds: that of one frame, or of all accumulated frames.
    pub fn milliseconds(&self) -> f64 {
        self.frames_of_picture() * self.cost.frame_milliseconds()
    }

    /// The number of frames whose mean is the measured picture; 1 if frames are not accumulated.
    pub fn frames_of_picture(&self) -> f64 {
        match self.configuration.accumulate {
            true => f64::from(self.configuration.frames),
            false => 1.0,
        }
    }

    /// The error of the measured picture: the root of the relMSE of the last frame, ≥ 0; NaN if not known.
    pub fn error(&self) -> f64 {
        let squared = self.row.relmse.last().copied().unwrap_or(f64::NAN);
        if squared < 0.0 { 0.0 } else { squared.sqrt() }
    }

    /// The lower and the upper end of the 95 % interval of [`Self::error`]; `None` for fewer than two seeds.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let squared = *self.row.relmse.last()?;
        let half_width = (*self.row.relmse_half_width.last()?)?;
        let ends = [squared - half_width, squared + half_width];
        half_width
            .is_finite()
            .then(|| ends.map(|end| end.max(0.0).sqrt()))
    }

    /// The error divided by that of path tracing in the same time; below 1 is better. `None` if not known.
    pub fn at_equal_time(&self) -> Option<Ratio> {
        if self.is_base {
            Some(ITSELF)
        } else {
            self.cost.error_at_equal_time
        }
    }

    /// True if the configuration can be advised: it has no certain bias, and is not mostly too dark.
    fn is_candidate(&self) -> bool {
        self.row.verdict != Verdict::Biased && !self.is_empty
    }

    fn name(&self) -> String {
        quoted(&self.configuration.name)
    }
}

/// The configurations of one scene in the order of their rank, and whether the first one is advised.
pub struct Comparison<'a> {
    /// The configurations whose time and error are known: those that can be advised, then the others; both
    /// sorted by the error at equal time, or by the error of a frame if there is no path tracing.
    pub entries: Vec<Entry<'a>>,
    /// The names of configurations without a known time or error; if there are any, nothing is advised.
    pub unknown: Vec<&'a str>,
    /// True if the first configuration is advised: it is certainly better than the other candidates.
    pub is_decided: bool,
}

impl<'a> Comparison<'a> {
    /// Compares configurations, given with rows and costs. If `is_whole` is false (a shard), none is advised.
    pub fn new(all: &[(&'a Resolved, &'a Row, &'a Cost)], is_whole: bool) -> Self {
        let base = all.iter().position(|(c, ..)| is_path_tracing(c));
        let median = |row: &Row| row.median.last().copied().unwrap_or(1.0);
        let usual = base.map_or(1.0, |base| median(all[base].1));
        let entries = all.iter().enumerate();
        let entries = entries.map(|(index, (configuration, row, cost))| Entry {
            configuration,
            row,
            cost,
            is_base: Some(index) == base,
            is_empty: median(row) < LEAST_MEDIAN * usual,
        });
        let (mut entries, unknown): (Vec<_>, Vec<_>) = entries.partition(Entry::is_measured);
        entries.sort_by(order);
        let is_decided = is_whole && unknown.is_empty() && is_decided(&entries);
        Self {
            is_decided,
            unknown: (unknown.iter())
                .map(|entry| entry.configuration.name.as_str())
                .collect(),
            entries,
        }
    }

    /// The result for the configuration with the index `index` in [`Self::entries`], which the page shows.
    pub fn standing(&self, index: usize) -> Standing {
        let entry = &self.entries[index];
        match index {
            0 if self.is_decided => Standing::Advised,
            _ if entry.row.verdict == Verdict::Biased => Standing::Biased,
            _ if entry.is_empty => Standing::Empty,
            _ => Standing::Finalist,
        }
    }

    /// The index of path tracing, the basis of comparison, in [`Self::entries`]; `None` if there is none.
    pub fn yardstick(&self) -> Option<usize> {
        self.entries.iter().position(|entry| entry.is_base)
    }

    /// The answer for the page: which configuration to use, or why none is advised. `size` is the width and
    /// the height of the pictures, in pixels.
    pub fn answer(&self, size: (u32, u32)) -> Answer {
        let mut sentence = self.sentence(size);
        let biased = self.entries.iter();
        let biased = biased.filter(|entry| entry.row.verdict == Verdict::Biased);
        let biased: Vec<String> = biased.map(Entry::name).collect();
        if !biased.is_empty() {
            sentence += &format!(" Biased, and therefore not advised: {}.", biased.join(", "));
        }
        if !self.unknown.is_empty() {
            let names: Vec<String> = self.unknown.iter().map(|name| quoted(name)).collect();
            sentence += &format!(" Not measured yet: {}.", names.join(", "));
        }
        Answer {
            is_decided: self.is_decided,
            sentence,
            details: self.details(size),
        }
    }

    fn sentence(&self, (width, height): (u32, u32)) -> String {
        let Some(best) = self.entries.first() else {
            return "Undecided: no configuration has a time and an error yet.".to_owned();
        };
        if self.entries.iter().all(|entry| entry.error() <= 0.0) {
            return "Undecided: no configuration has an error, because nothing here has noise."
                .to_owned();
        }
        let error = percent(best);
        let candidates: Vec<&Entry<'_>> =
            (self.entries.iter()).filter(|e| e.is_candidate()).collect();
        let next = candidates.get(1);
        if self.is_decided {
            let mut text = format!(
                "Use {}: {} of {width} × {height}, error {error}.",
                best.name(),
                time(best)
            );
            if let Some(ratio) = best.at_equal_time().filter(|_| !best.is_base) {
                text += &format!(
                    " At equal time, it has {} of the error of path tracing.",
                    range(ratio)
                );
            }
            if let Some((next, ratio)) = next.and_then(|next| Some((next, next.at_equal_time()?))) {
                text += &match next.is_base {
                    true => " The next best is path tracing.".to_owned(),
                    false => format!(" The next best is {} with {}.", next.name(), range(ratio)),
                };
            }
            return text + &bias(best);
        }
        if candidates.is_empty() {
            return "Undecided: each configuration is biased or leaves most pixels dark."
                .to_owned();
        }
        let Some(base) = self.entries.iter().find(|entry| entry.is_base) else {
            return format!(
                "Undecided: there is no path tracing to compare with at equal time. {} has the least error of a frame: {error}, with {}.",
                best.name(),
                time(best)
            );
        };
        let Some(ratio) = best.at_equal_time() else {
            return format!(
                "Undecided: too few runs have the same seed as those of {}.",
                base.name()
            );
        };
        let own = match best.is_base {
            true => format!("{} has the least error", best.name()),
            false => format!(
                "{} has the least error, {} of that of path tracing",
                best.name(),
                range(ratio)
            ),
        };
        // The one that is in the way need not be the next one: an interval of a later one can be wider.
        let tied = candidates[1..].iter().find(|other| {
            (other.at_equal_time()).is_none_or(|other| other.interval[0] <= ratio.interval[1])
        });
        match tied.map(|other| (other, other.at_equal_time())) {
            Some((other, Some(theirs))) if !other.is_base => format!(
                "Undecided: at equal time, {own}, but {} cannot be told apart from it: {}.",
                other.name(),
                range(theirs)
            ),
            Some((other, Some(_))) => format!(
                "Undecided: at equal time, {own}, but {} cannot be told apart from it.",
                other.name()
            ),
            Some((other, None)) => format!(
                "Undecided: at equal time, {own}, but that of {} is not known yet.",
                other.name()
            ),
            None => format!("Undecided as long as results are missing: at equal time, {own}."),
        }
    }

    /// The rule of the answer, and the conditions of its numbers, as sentences for the page.
    fn details(&self, (width, height): (u32, u32)) -> String {
        let mut text = "A configuration is advised if the 95 % interval of its error at equal time lies below those of all others that are neither biased nor too dark.".to_owned();
        let Some(best) = self.entries.first() else {
            return text;
        };
        let spp = best.row.reference_spp.map_or(String::new(), |samples| {
            format!(" with a reference of {samples} samples per pixel")
        });
        text += &format!(
            " Error: root of the relMSE of frame {}, the mean over {} seeds, ± half of its 95 % interval, at {width} × {height}{spp}.",
            best.configuration.frames - 1,
            best.row.seeds
        );
        let sums = (self.entries.iter()).filter(|entry| entry.frames_of_picture() > 1.0);
        let sums: Vec<String> = sums.map(Entry::name).collect();
        if !sums.is_empty() {
            text += &format!(
                " Time and error of {} are those of {} frames that are added up.",
                sums.join(", "),
                best.configuration.frames
            );
        }
        text
    }
}

/// Compares two configurations by rank: `Less` if `a` is better, mainly by its error at equal time.
fn order(a: &Entry<'_>, b: &Entry<'_>) -> Ordering {
    let groups = b.is_candidate().cmp(&a.is_candidate());
    let by_error = a.error().total_cmp(&b.error());
    groups.then(match (a.at_equal_time(), b.at_equal_time()) {
        (Some(a), Some(b)) => a.value.total_cmp(&b.value).then(by_error),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => by_error,
    })
}

/// True if the first configuration certainly has less error at equal time than all others that can be
/// advised. The rule is cautious, because the intervals of both contain the noise of path tracing.
fn is_decided(entries: &[Entry<'_>]) -> bool {
    let candidates: Vec<_> = (entries.iter())
        .filter(|entry| entry.is_candidate())
        .map(Entry::at_equal_time)
        .collect();
    let Some((Some(first), others)) = candidates.split_first() else {
        return false;
    };
    let is_above = |other: &Option<Ratio>| other.is_some_and(|o| first.interval[1] < o.interval[0]);
    entries.iter().any(|entry| entry.is_base) && !others.is_empty() && others.iter().all(is_above)
}

/// A sentence about the bias of the advised configuration for the answer; empty if little is known.
fn bias(best: &Entry<'_>) -> String {
    match (best.row.verdict, best.row.detectable_bias) {
        (Verdict::Unbiased, Some(bias)) => format!(
            " It is unbiased: a bias of {:.1} % would have been found.",
            100.0 * bias
        ),
        (Verdict::Undecided, Some(bias)) if bias.is_finite() => format!(
            " No bias was found; only one above {:.1} % would have been.",
            100.0 * bias
        ),
        _ => String::new(),
    }
}

/// Writes a name between backticks, which pages show as code; backticks in it become apostrophes.
fn quoted(name: &str) -> String {
    format!("`{}`", name.replace('`', "'"))
}

/// Formats a ratio and its interval with two decimals, such as `0.40 (0.30–0.49)`.
pub fn range(Ratio { value, interval }: Ratio) -> String {
    format!("{value:.2} ({:.2}–{:.2})", interval[0], interval[1])
}

/// Formats an error in percent with half of its interval, such as `20.0 % ± 2.0 %` or `about 20.0 %`.
pub fn percent(entry: &Entry<'_>) -> String {
    let error = 100.0 * entry.error();
    entry
        .interval()
        .map_or(format!("about {error:.1} %"), |[low, high]| {
            format!("{error:.1} % ± {:.1} %", 50.0 * (high - low))
        })
}

fn time(entry: &Entry<'_>) -> String {
    let time = match entry.milliseconds() {
        ms if ms < 10.0 => format!("{ms:.2} ms"),
        ms if ms < 100.0 => format!("{ms:.1} ms"),
        ms => format!("{ms:.0} ms"),
    };
    match entry.frames_of_picture() {
        1.0 => format!("{time} per frame"),
        frames => format!("{time} for {frames} frames"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Settings;
    use crate::render::settings::Integrator;
    use crate::study::results::Findings;
    use crate::study::run::Run;

    /// Test data: a configuration whose two runs have the relMSE `relmse`, with its row and its costs.
    /// `ratio` is its error at equal time: the value and the ends of its interval.
    fn results(
        name: &str,
        relmse: [f64; 2],
        ratio: Option<[f64; 3]>,
        verdict: Verdict,
    ) -> (Resolved, Row, Cost) {
        let integrator = match name {
            "path tracing" => Integrator::PathTracing,
            _ => Integrator::Restir,
        };
        let mut configuration = Resolved::of(Settings {
            integrator,
            ..Settings::default()
        });
        configuration.name = name.to_owned();
        let runs = relmse.map(|relmse| Run {
            relmse: vec![relmse],
            mse: vec![relmse],
            clamped_mse: vec![relmse],
            correlation: vec![0.0],
            median: vec![if name == "dark" { 0.3 } else { 1.0 }],
            milliseconds: vec![vec![("pass".to_owned(), 20.0)]],
            ..Run::default()
        });
        let runs: Vec<&Run> = runs.iter().collect();
        let mut row = Row::new("scene", &configuration, &runs, Findings::default()).unwrap();
        row.verdict = verdict;
        let mut cost = Cost::of("scene", (&configuration, &runs), None);
        cost.error_at_equal_time = ratio.map(|[value, low, high]| Ratio {
            value,
            interval: [low, high],
        });
        (configuration, row, cost)
    }

    fn compared<R>(
        all: &[(Resolved, Row, Cost)],
        is_whole: bool,
        look: impl Fn(&Comparison<'_>) -> R,
    ) -> R {
        let all: Vec<_> = all.iter().map(|(a, b, c)| (a, b, c)).collect();
        look(&Comparison::new(&all, is_whole))
    }

    fn path_tracing() -> (Resolved, Row, Cost) {
        results("path tracing", [0.25, 0.25], None, Verdict::Undecided)
    }

    #[test]
    fn a_certain_winner_is_advised_and_a_tie_is_not() {
        let good = |low, high| {
            results(
                "good",
                [0.04, 0.04],
                Some([0.4, low, high]),
                Verdict::Unbiased,
            )
        };
        let other = || {
            results(
                "other`s",
                [0.03, 0.03],
                Some([0.6, 0.5, 0.7]),
                Verdict::Undecided,
            )
        };
        let answer = |all: &[_], is_whole| compared(all, is_whole, |c| c.answer((8, 4)));
        let all = [path_tracing(), other(), good(0.3, 0.49)];
        let decided = answer(&all, true);
        assert!(decided.is_decided);
        let text = decided.sentence;
        assert!(
            text.starts_with("Use `good`: 20.0 ms per frame of 8 × 4, error 20.0 % ± 0.0 %."),
            "{text}"
        );
        assert!(
            text.contains("0.40 (0.30–0.49) of the error of path tracing"),
            "{text}"
        );
        assert!(
            text.contains("next best is `other's` with 0.60 (0.50–0.70)"),
            "{text}"
        );
        compared(&all, true, |c| {
            assert_eq!(c.standing(0), Standing::Advised);
            assert_eq!(c.standing(1), Standing::Finalist);
            assert_eq!(c.yardstick(), Some(2));
        });
        // A shard knows a part only.
        assert!(!answer(&all, false).is_decided);
        let tie = answer(&[path_tracing(), other(), good(0.3, 0.51)], true);
        assert!(!tie.is_decided);
        assert!(
            (tie.sentence).contains("but `other's` cannot be told apart"),
            "{}",
            tie.sentence
        );
        let worse = results("good", [0.3, 0.3], Some([1.5, 1.2, 1.8]), Verdict::Unbiased);
        let text = answer(&[worse, path_tracing()], true).sentence;
        assert!(text.starts_with("Use `path tracing`"), "{text}");
    }

    #[test]
    fn neither_biased_nor_dark_nor_unknown_ones_are_advised() {
        let ratio = Some([0.1, 0.05, 0.2]);
        let biased = results("biased", [0.01, 0.01], ratio, Verdict::Biased);
        let dark = results("dark", [0.01, 0.01], ratio, Verdict::Undecided);
        let fine = results(
            "fine",
            [0.09, 0.09],
            Some([0.5, 0.4, 0.6]),
            Verdict::Unbiased,
        );
        let mut all = vec![biased, dark, path_tracing(), fine];
        compared(&all, true, |c| {
            assert!(c.is_decided);
            let names: Vec<&str> = (c.entries.iter())
                .map(|e| e.configuration.name.as_str())
                .collect();
            assert_eq!(&names[..2], ["fine", "path tracing"]);
            assert!(c.answer((8, 4)).sentence.contains("not advised: `biased`."));
            assert_eq!(c.standing(2), Standing::Biased);
            assert_eq!(c.standing(3), Standing::Empty);
        });
        let mut late = results("late", [0.2, 0.2], None, Verdict::Undecided);
        late.1.relmse.clear();
        all.push(late);
        compared(&all, true, |c| {
            assert!(!c.is_decided && c.unknown == ["late"]);
            let text = c.answer((8, 4)).sentence;
            assert!(text.contains("Not measured yet: `late`."), "{text}");
        });
        compared(&[], true, |c| {
            assert!(c.answer((8, 4)).sentence.starts_with("Undecided"));
        });
    }

    #[test]
    fn without_path_tracing_the_least_error_is_first_and_nothing_is_advised() {
        let all = [
            results("a", [0.09, 0.09], None, Verdict::Unbiased),
            results("b", [0.04, 0.04], None, Verdict::Unbiased),
        ];
        compared(&all, true, |c| {
            let text = c.answer((8, 4)).sentence;
            assert!(!c.is_decided && text.contains("no path tracing"), "{text}");
            assert!(text.contains("`b` has the least error"), "{text}");
        });
    }
}
