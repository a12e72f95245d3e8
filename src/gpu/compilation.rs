//! Programs that are made in the background.
//!
//! Drivers take up to a second for a large shader, each on one core. So the programs of all passes are compiled at the same
//! time, and the first recording of a pass waits for its program.

use super::device::Device;
use super::program::{Program, Source};
use crate::{Error, Result};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::{Builder, JoinHandle};

/// A program, or the text of the reason why there is none.
type Made = std::result::Result<Program, String>;

/// The size of a compiling thread's stack, in bytes: the usual size of a main thread's stack, since compilers recurse deeply.
const STACK_BYTES: usize = 8 << 20;

/// A program, finished or not. Dropping it waits for the driver, which cannot be interrupted.
pub(super) struct Compilation {
    name: String,
    made: OnceLock<Made>,
    thread: Mutex<Option<JoinHandle<Made>>>,
}

impl Compilation {
    /// Starts to make a program.
    pub(super) fn start(device: &Arc<Device>, source: Source) -> Self {
        let source = Arc::new(source);
        let make = |device: &Arc<Device>, source: &Source| {
            Program::new(device, source).map_err(|e| e.to_string())
        };
        let thread = {
            let (device, source) = (device.clone(), source.clone());
            Builder::new()
                .name(format!("compile {}", source.name))
                .stack_size(STACK_BYTES)
                .spawn(move || make(&device, &source))
        };
        let made = OnceLock::new();
        if thread.is_err() {
            // Where the process can have no more threads, it waits.
            made.get_or_init(|| make(device, &source));
        }
        Self {
            name: source.name.clone(),
            made,
            thread: Mutex::new(thread.ok()),
        }
    }

    /// Waits for the program.
    ///
    /// # Errors
    /// The shader uses more than the device can bind, or the driver rejects it.
    pub(super) fn wait(&self) -> Result<&Program> {
        let made = self.made.get_or_init(|| {
            let thread = self.thread.lock().ok().and_then(|mut thread| thread.take());
            // A thread that panicked has made nothing.
            let joined = thread.and_then(|thread| thread.join().ok());
            joined.unwrap_or_else(|| Err(format!("pass {} could not be made", self.name)))
        });
        made.as_ref().map_err(Error::failed)
    }
}

impl Drop for Compilation {
    fn drop(&mut self) {
        // What the thread makes is then dropped here, and not whenever it ends.
        drop(self.wait());
    }
}
