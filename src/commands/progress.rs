//! How far long work has come: a bar on a terminal, plain lines elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::cell::Cell;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Between plain lines; work that ends sooner prints none.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// Ticks of the bar for each step.
const TICKS: u64 = 1000;

/// The progress of one piece of work.
pub struct Progress {
    bar: ProgressBar,
    terminal: bool,
    total: Option<u64>,
    unit: &'static str,
    started: Instant,
    last_line: Cell<Instant>,
}

impl Progress {
    /// Work of `total` steps called `unit`; without a total, how far it is yet to go is not known.
    pub fn new(total: Option<u64>, unit: &'static str) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let target = if terminal {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(total.map(|total| total * TICKS), target);
        let template = match total {
            Some(_) => "{bar:40} {msg}, {eta} left",
            None => "{spinner} {msg} after {elapsed}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self {
            bar,
            terminal,
            total,
            unit,
            started: Instant::now(),
            last_line: Cell::new(Instant::now()),
        }
    }

    /// `done` steps are done; of large ones a part may be.
    pub fn at(&self, done: f64) {
        self.bar.set_position((done * TICKS as f64) as u64);
        let line_is_due = !self.terminal && self.last_line.get().elapsed() >= LINE_EVERY;
        if !self.terminal && !line_is_due {
            return;
        }
        let decimals = if done.fract() == 0.0 { 0 } else { 2 };
        let of = self.total.map_or(String::new(), |all| format!(" of {all}"));
        let text = format!("{done:.decimals$}{of} {}", self.unit);
        if line_is_due {
            self.last_line.set(Instant::now());
            let seconds = self.started.elapsed().as_secs();
            super::say(format_args!("{text} after {seconds} s"));
        } else {
            self.bar.set_message(text);
        }
    }

    /// The work is done.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
