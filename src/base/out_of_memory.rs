//! When memory runs out, this module prints one line on stderr and ends the process with exit status 1. The standard
//! library would print two lines and abort, and only an unstable interface of it can change that.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

thread_local! {
    /// True while this thread runs [`may_fail`]; then an allocation that fails does not end the process. The flag needs no
    /// allocation and is never dropped, so that the allocator can read it at any time.
    static MAY_FAIL: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work` and returns its result. An allocation that fails in `work` does not end the process, so that functions such
/// as `try_reserve` can return an error.
pub fn may_fail<T>(work: impl FnOnce() -> T) -> T {
    let before = MAY_FAIL.replace(true);
    let result = work();
    MAY_FAIL.set(before);
    result
}

/// The system's allocator, except that an allocation that fails ends the process with one line on stderr. The program
/// `headwater` uses it as its global allocator.
pub struct Allocator;

/// Returns `memory`, the pointer that an allocation of `bytes` bytes returned. If it is null, ends the process, except
/// inside [`may_fail`], where the null pointer is returned.
fn checked(memory: *mut u8, bytes: usize) -> *mut u8 {
    if memory.is_null() && !MAY_FAIL.get() {
        end(bytes);
    }
    memory
}

/// Prints one line, which names the number of bytes that could not be allocated, and ends the process. It
/// allocates no memory itself.
#[cold]
fn end(bytes: usize) -> ! {
    let mut line = [0; 160];
    let length = line.len();
    let mut rest = &mut line[..];
    // The line has room for any number.
    let _ = writeln!(
        rest,
        "headwater: out of memory: {bytes} bytes cannot be allocated; take a smaller picture or scene, or give more memory"
    );
    let length = length - rest.len();
    end_with(&line[..length])
}

/// Prints `line`, which must end with a line break, on stderr and ends the process with exit status 1. Any thread and any
/// signal handler may call it; if several threads do so at once, only the first one prints its line. No output file is
/// left incomplete, because a file gets its name only when it is complete.
pub fn end_with(line: &[u8]) -> ! {
    static ENDS: AtomicBool = AtomicBool::new(false);
    while ENDS.swap(true, Ordering::Relaxed) {
        std::thread::sleep(Duration::from_secs(1));
    }
    // Not by the standard library, whose lock a thread may hold that waits for memory or was interrupted.
    let _ = rustix::io::write(rustix::stdio::stderr(), line);
    signal_hook::low_level::exit(1)
}

// SAFETY: memory comes from the system's allocator, by the same layouts, and a failure is its null pointer or the end of
// the process.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's layout.
        checked(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's layout.
        checked(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's memory, layout and size.
        checked(unsafe { System.realloc(memory, layout, size) }, size)
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's memory and layout.
        unsafe { System.dealloc(memory, layout) }
    }
}
