//! Programs (compute pipelines with their layouts) that are made in background threads.
//!
//! A driver takes up to a second for a large shader, on one core. So the programs of all passes are compiled at the same
//! time, and the first recording of a pass waits for its program.

use super::device::Device;
use super::program::{Program, Source};
use crate::{Error, Result};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::{Builder, JoinHandle};

/// A program (a compute pipeline with its layouts), or the message of the error that prevented it.
type Made = std::result::Result<Program, String>;

/// Stack size of a compiling thread in bytes. It is the usual size of a main thread's stack, because compilers recurse
/// deeply.
const STACK_BYTES: usize = 8 << 20;

/// A program (a compute pipeline with its layouts) that a background thread makes or has made. Dropping it waits for the
/// driver's compiler, which cannot be interrupted.
pub(super) struct Compilation {
    name: String,
    made: OnceLock<Made>,
    thread: Mutex<Option<JoinHandle<Made>>>,
}

impl Compilation {
    /// Starts a thread that makes a program from the shader and the values in `source`. If no thread can be started, the
    /// call itself makes the program.
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

    /// Waits until the program is made, and returns it; later calls return at once.
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
