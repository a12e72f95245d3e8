//! SIGINT and SIGTERM as a value that long work looks at between its steps.

use crate::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Watches for signals from its creation on.
pub struct Interrupt(Arc<AtomicUsize>);

impl Interrupt {
    /// Begins to watch. A second signal of the same kind ends the process at once.
    ///
    /// # Errors
    /// The system refuses a handler.
    pub fn watch() -> Result<Self> {
        let flag = Arc::new(AtomicUsize::new(0));
        for signal in [SIGINT, SIGTERM] {
            let armed = Arc::new(std::sync::atomic::AtomicBool::new(false));
            let refused = |e| Error::failed(format!("cannot watch for signals: {e}"));
            // In this order: the first signal arms, the second finds it armed.
            signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, armed.clone())
                .map_err(refused)?;
            signal_hook::flag::register(signal, armed).map_err(refused)?;
            signal_hook::flag::register_usize(signal, flag.clone(), signal as usize)
                .map_err(refused)?;
        }
        Ok(Self(flag))
    }

    /// The number of the signal that came.
    pub fn pending(&self) -> Option<i32> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            signal => Some(signal as i32),
        }
    }

    /// Ends work once a signal came; `kept` says what is kept of it.
    ///
    /// # Errors
    /// A signal came.
    pub fn check(&self, kept: &str) -> Result<()> {
        self.pending().map_or(Ok(()), |signal| {
            Err(Error::Interrupted {
                signal,
                kept: kept.into(),
            })
        })
    }
}
