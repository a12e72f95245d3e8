//! Programs (compute pipelines with their layouts) that are made in background threads.
//!
//! A driver takes up to a second to compile a large shader, on one core. So the programs of all passes are compiled at the
//! same time, each in its own thread, and the first recording of a pass waits for its program.

use super::device::Device;
use super::program::{Program, Source};
use crate::{Error, Result};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::{Builder, JoinHandle};

/// The result of making a program (a compute pipeline with its layouts): the program, or the text of the error, which every
/// later use of the program reports.
type Made = std::result::Result<Program, String>;

/// Stack size, in bytes, of each thread that makes a program. It is as large as the usual stack of a main
/// thread, because drivers' compilers recurse deeply.
const STACK_BYTES: usize = 8 << 20;

/// A program (a compute pipeline with its layouts) that a background thread makes or has made. Dropping the value waits for
/// the thread, because the driver's compiler cannot be interrupted.
pub(super) struct Compilation {
    name: String,
    made: OnceLock<Made>,
    thread: Mutex<Option<JoinHandle<Made>>>,
}

impl Compilation {
    /// Starts a thread that makes a program from `source`, which has the shader and the values of its specialisation
    /// constants. If no thread can be started, the program is made before the call returns.
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

    /// Waits until the background thread has made the program, and returns the program. Later calls return it at once.
    ///
    /// # Errors
    /// The shader binds more storage buffers than the device allows, or the driver rejects the shader.
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
