//! Shows the progress of long work on stderr, with an estimate of the time left: as a bar on a terminal, otherwise as
//! lines.

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::cell::Cell;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// The interval between two lines of progress if stderr is no terminal. Work that ends sooner prints no line.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// The minimum time from the first report of progress to the first estimate of the time left; an earlier estimate would
/// be too uncertain.
const ESTIMATE_AFTER: Duration = Duration::from_secs(1);

/// The minimum time from the start of work that is reported as a fraction to the first estimate of the time
/// left. Before, most of the time was used to load the scene and to compile shaders, which happens only once.
const ESTIMATE_FRACTIONS_AFTER: Duration = Duration::from_secs(5);

/// If the estimated time left is longer than this, a notice is printed once, because an argument may have been mistyped.
const LONG: Duration = Duration::from_secs(3600);

/// The number of steps of the bar on a terminal, whatever the unit of the work is. The library of the bar counts whole steps
/// only, so the fraction of the work that is done is rounded down to such a step.
const TICKS: u64 = 10_000;

/// Shows the progress of one piece of work on stderr. The work calls [`Self::at`] between its steps. When this value is
/// dropped, the bar disappears.
pub struct Progress {
    bar: ProgressBar,
    terminal: bool,
    steps: Steps,
    started: Instant,
    last_line: Cell<Instant>,
    /// The time of the first report of progress, and the number of steps that were done then; `None` before this report. The
    /// time left is estimated from the speed since this report, because the time before it contains preparations, such as
    /// the compilation of shaders.
    first: Cell<Option<(Instant, f64)>>,
    announced: Cell<bool>,
    /// The largest progress that was reported, in steps or as a fraction of the work. If the total grows
    /// during the work, the display does not go back: it stays at this value until the progress exceeds it.
    shown: Cell<f64>,
}

/// The unit in which the progress of one piece of work is reported. It decides what the bar and the lines show, and
/// whether the time left can be estimated.
enum Steps {
    /// Progress is reported in steps, such as frames or samples. The first field is the number of all steps, or `None` if
    /// it is unknown; the second field is the name of the steps in the plural.
    Counted(Option<u64>, &'static str),
    /// Progress is reported as the fraction of the whole work that is done, in [0, 1]. The field is the name of the work.
    Fractions(&'static str),
}

impl Progress {
    /// Shows the progress of work with `total` steps; `unit` is their name in the plural, such as "frames". If `total` is
    /// `None`, the time left is not estimated.
    pub fn new(total: Option<u64>, unit: &'static str) -> Self {
        Self::with(Steps::Counted(total, unit))
    }

    /// Shows the progress of work that is reported as a fraction in [0, 1]. `name` is the name of the whole work, such as
    /// "the study".
    pub fn of_whole(name: &'static str) -> Self {
        Self::with(Steps::Fractions(name))
    }

    /// Marks work that may end before its last step, for example when a target error is reached. Then no notice about its
    /// long duration is printed.
    pub fn that_may_end_sooner(self) -> Self {
        self.announced.set(true);
        self
    }

    fn with(steps: Steps) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let target = if terminal {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let total = match steps {
            Steps::Counted(total, _) => total,
            Steps::Fractions(_) => Some(1),
        };
        let bar = ProgressBar::with_draw_target(total.map(|_| TICKS), target);
        let template = match total {
            Some(_) => "{bar:40} {msg}",
            None => "{spinner} {msg} after {elapsed}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self {
            bar,
            terminal,
            steps,
            started: Instant::now(),
            last_line: Cell::new(Instant::now()),
            first: Cell::new(None),
            announced: Cell::new(false),
            shown: Cell::new(0.0),
        }
    }

    /// Reports that `done` steps are done; a number that is not an integer means that a step is done in part. If this
    /// value was made by [`Self::of_whole`], `done` is the fraction of the work that is done.
    pub fn at(&self, done: f64) {
        let total = match self.steps {
            Steps::Counted(total, _) => total.map(|total| total as f64),
            Steps::Fractions(_) => Some(1.0),
        };
        let left = total.and_then(|total| match self.steps {
            Steps::Counted(..) => self.left(done, total),
            Steps::Fractions(_) => self.left_of_whole(done),
        });
        self.shown.set(done.max(self.shown.get()));
        let done = self.shown.get();
        match total {
            Some(total) => self
                .bar
                .set_position((done / total * TICKS as f64).min(TICKS as f64) as u64),
            None => self.bar.tick(),
        }
        self.announce(left);
        let line_is_due = !self.terminal && self.last_line.get().elapsed() >= LINE_EVERY;
        if !self.terminal && !line_is_due {
            return;
        }
        let mut text = self.text(done);
        if line_is_due {
            self.last_line.set(Instant::now());
            text += &format!(" after {} s", self.started.elapsed().as_secs());
        }
        if let Some(left) = left {
            text += &format!(", about {} left", HumanDuration(left));
        }
        if line_is_due {
            super::say(text);
        } else {
            self.bar.set_message(text);
        }
    }

    fn text(&self, done: f64) -> String {
        let decimals = if done.fract() == 0.0 { 0 } else { 2 };
        match self.steps {
            Steps::Counted(Some(total), unit) => format!("{done:.decimals$} of {total} {unit}"),
            Steps::Counted(None, unit) => format!("{done:.decimals$} {unit}"),
            Steps::Fractions(name) => format!("{:.1} % of {name}", 100.0 * done),
        }
    }

    /// The estimated time left, at the mean speed since the first report; `None` if that report was less than a second
    /// ago or nothing was done since. `total` is in the unit of `done`: steps, or 1 for the whole work.
    fn left(&self, done: f64, total: f64) -> Option<Duration> {
        let Some((start, before)) = self.first.get() else {
            self.first.set(Some((Instant::now(), done)));
            return None;
        };
        let passed = start.elapsed();
        if passed < ESTIMATE_AFTER || done <= before {
            return None;
        }
        let seconds = passed.as_secs_f64() * (total - done).max(0.0) / (done - before);
        Duration::try_from_secs_f64(seconds).ok()
    }

    /// The estimated time left, if the fraction `done` of the work, in [0, 1], is done. It assumes that the
    /// fraction grows in proportion to the time since the start. `None` in the first seconds, or if nothing
    /// is done.
    fn left_of_whole(&self, done: f64) -> Option<Duration> {
        let passed = self.started.elapsed();
        if passed < ESTIMATE_FRACTIONS_AFTER || done <= 0.0 {
            return None;
        }
        Duration::try_from_secs_f64(passed.as_secs_f64() * (1.0 - done) / done).ok()
    }

    /// Prints a notice if the estimated time `left` is longer than [`LONG`], so that the user can end work that was
    /// started by mistake. It is printed once at most; with `None`, which means that there is no estimate, nothing is
    /// printed.
    fn announce(&self, left: Option<Duration>) {
        let Some(left) = left.filter(|left| *left > LONG && !self.announced.get()) else {
            return;
        };
        self.announced.set(true);
        let work = match self.steps {
            Steps::Counted(total, unit) => format!("{} {unit}", total.unwrap_or_default()),
            Steps::Fractions(name) => name.to_owned(),
        };
        let text = format!(
            "at this speed {work} will take about {}; Ctrl-C ends the work",
            HumanDuration(left)
        );
        self.bar.suspend(|| super::notice(&text));
    }

    /// Ends the display because the work is done: the bar on the terminal disappears.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
