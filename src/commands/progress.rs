//! How far long work has come: a bar on a terminal, plain lines elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::cell::Cell;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Between plain lines; work that ends sooner prints none.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// The progress of one piece of work.
pub struct Progress {
    bar: ProgressBar,
    terminal: bool,
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
        let bar = ProgressBar::with_draw_target(total, target);
        let template = match total {
            Some(_) => "{bar:40} {pos}/{len} {msg}, {eta} left",
            None => "{spinner} {pos} {msg} after {elapsed}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_message(unit);
        Self {
            bar,
            terminal,
            unit,
            started: Instant::now(),
            last_line: Cell::new(Instant::now()),
        }
    }

    /// `done` steps are done.
    pub fn at(&self, done: u64) {
        self.bar.set_position(done);
        if !self.terminal && self.last_line.get().elapsed() >= LINE_EVERY {
            self.last_line.set(Instant::now());
            let of = match self.bar.length() {
                Some(total) => format!(" of {total}"),
                None => String::new(),
            };
            let seconds = self.started.elapsed().as_secs();
            super::say(format_args!("{done}{of} {} after {seconds} s", self.unit));
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
