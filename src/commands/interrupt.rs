//! Catches SIGINT and SIGTERM. They set a flag, which long work checks between its steps, so that it can save results
//! before the process ends.

use crate::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, Ordering};
use std::time::{Duration, Instant};

/// Further signals within this time after the first one are ignored, because they belong to the same request to stop. For
/// example, the command `timeout` sends one signal to its child and another to the child's process group, and Ctrl-C in a
/// terminal may reach a process twice.
const SAME_REQUEST: Duration = Duration::from_secs(1);

/// Watches for SIGINT and SIGTERM from the creation of this value on. Long work calls [`Self::check`] between
/// its steps, so that it can save results before it ends.
pub struct Interrupt(Arc<AtomicI32>);

impl Interrupt {
    /// Starts to watch for SIGINT and SIGTERM. The first signal only sets the number that [`Self::pending`] returns. A
    /// signal that comes more than a second after the first one ends the process at once.
    ///
    /// # Errors
    /// The system refuses a handler or a thread.
    pub fn watch() -> Result<Self> {
        let refused = |e| Error::failed(format!("cannot watch for signals: {e}"));
        let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(refused)?;
        let pending = Arc::new(AtomicI32::new(0));
        let seen = pending.clone();
        std::thread::Builder::new()
            .name("signals".into())
            .spawn(move || {
                let mut first: Option<Instant> = None;
                for signal in &mut signals {
                    let first = *first.get_or_insert_with(Instant::now);
                    if first.elapsed() > SAME_REQUEST {
                        signal_hook::low_level::exit(128 + signal);
                    }
                    // Only the first: it decides the exit status.
                    let _ = seen.compare_exchange(0, signal, Ordering::Relaxed, Ordering::Relaxed);
                }
            })
            .map_err(refused)?;
        Ok(Self(pending))
    }

    /// The number of the first signal that was received; `None` if there was none.
    pub fn pending(&self) -> Option<i32> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            signal => Some(signal),
        }
    }

    /// Returns an error if a signal was received, so that the work ends. `kept` is a clause for the message;
    /// it states which results were saved, such as [`NOTHING_WRITTEN`](super::NOTHING_WRITTEN).
    ///
    /// # Errors
    /// A signal was received.
    pub fn check(&self, kept: &str) -> Result<()> {
        self.pending().map_or(Ok(()), |signal| {
            Err(Error::Interrupted {
                signal,
                kept: kept.into(),
            })
        })
    }
}
