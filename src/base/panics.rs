//! Catches panics of libraries that decode files, which a damaged file can cause, so that such a file is reported as an
//! error of input.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

/// Runs `work` and returns its result, or `None` if it panicked; the panic is not printed. After a panic, data outside of
/// `work` that `work` changes may be inconsistent and must not be used. Panics of other threads are printed as usual.
pub fn caught<T>(work: impl FnOnce() -> T) -> Option<T> {
    thread_local!(static QUIET: Cell<bool> = const { Cell::new(false) });
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = take_hook();
        set_hook(Box::new(move |panic| {
            if !QUIET.get() {
                usual(panic);
            }
        }));
    });
    QUIET.set(true);
    let outcome = catch_unwind(AssertUnwindSafe(work));
    QUIET.set(false);
    outcome.ok()
}
