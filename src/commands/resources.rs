//! Prepares the process before a command runs: starts its threads, and ensures that crashes and panics, for which no
//! function can return an error, end the program with one line on stderr and exit status 1.

use crate::base::out_of_memory::end_with;
use crate::{Error, Result};
use signal_hook::consts::{SIGABRT, SIGBUS, SIGSEGV};

/// Starts the threads for all parallel work now, because a thread that cannot be started later causes a panic. From then on,
/// crashes and panics end the program with one line on stderr and exit status 1. If `RUST_BACKTRACE` is set, they are not
/// caught, so that the user gets the backtrace of a panic and the core dump of a crash.
///
/// # Errors
/// The system refuses the threads or the signal handlers.
pub fn prepare() -> Result<()> {
    // Threads that have no memory when they start panic before they do anything, with this text.
    let no_memory = format!("os error {}", libc::ENOMEM);
    if std::env::var_os("RUST_BACKTRACE").is_none() {
        watch_for_crashes()?;
        std::panic::set_hook(Box::new(move |panic| {
            let panic = panic.to_string();
            let line = super::line(match panic.contains(&no_memory) {
                true => "out of memory: a thread cannot start; take a smaller picture or scene, or give more memory".to_owned(),
                false => format!("internal error, {panic}; RUST_BACKTRACE=1 shows where"),
            });
            end_with(format!("{line}\n").as_bytes());
        }));
    }
    let threads = rayon::ThreadPoolBuilder::new().build_global();
    threads.map_err(|e| {
        Error::failed(format!(
            "cannot start threads: {e}; allow more of them (ulimit -u), or set RAYON_NUM_THREADS to a small number"
        ))
    })
}

/// Handles SIGABRT, SIGBUS and SIGSEGV: prints one line on stderr and ends the program. A driver that gets no memory
/// often crashes with one of these signals.
fn watch_for_crashes() -> Result<()> {
    const CRASHED: &[u8] = b"headwater: a driver or a library crashed, perhaps out of memory; take a smaller picture or scene, or another device; RUST_BACKTRACE=1 lets it crash\n";
    for signal in [SIGABRT, SIGBUS, SIGSEGV] {
        // SAFETY: `end_with` neither allocates nor takes a lock, so that it may run in a handler, and does not return to
        // where the signal came from.
        unsafe { signal_hook_registry::register_unchecked(signal, |_| end_with(CRASHED)) }
            .map_err(|e| Error::failed(format!("cannot watch for crashes: {e}")))?;
    }
    Ok(())
}
