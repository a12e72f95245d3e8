//! Records of the work on a device, for profiles and regression tests.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// The content of a buffer after a pass that may write it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// The pass.
    pub pass: String,
    /// The buffer.
    pub buffer: String,
    /// A hash of all bytes of the buffer, in hexadecimal.
    pub hash: String,
}

/// The number of buffers and images with each name that exist now, and their size in bytes.
pub type MemoryUse = BTreeMap<String, (u32, u64)>;

/// The driver's result for a shader.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// The pass.
    pub name: String,
    /// A hash of the SPIR-V that the driver compiled.
    pub shader: String,
    /// The time that it took to make the pipeline, in milliseconds.
    pub milliseconds: f64,
    /// The report of the driver's compiler; empty without
    /// [`Features::executable_properties`](super::Features::executable_properties).
    pub report: CompilerReport,
}

/// A driver's statistics about a pipeline, unchanged.
#[derive(Clone, Debug, Default)]
pub struct CompilerReport {
    /// Invocations in a subgroup; 0 if the driver does not report it.
    pub subgroup_size: u32,
    /// Statistics, such as numbers of registers: names and values.
    pub statistics: Vec<(String, String)>,
}

/// The records so far. A list whose lock is poisoned stays unchanged: it is for information only.
#[derive(Default)]
pub struct Records {
    /// The size of the SPIR-V given to the driver, in bytes.
    shaders: AtomicU64,
    /// The time of recordings, in nanoseconds.
    submitted: AtomicU64,
    compiled: Mutex<Vec<Compiled>>,
    hashes_outputs: AtomicBool,
    outputs: Mutex<Vec<Output>>,
    memory: Mutex<MemoryUse>,
}

impl Records {
    /// The size of the SPIR-V given to the driver, in bytes.
    pub fn shader_bytes(&self) -> u64 {
        self.shaders.load(Ordering::Relaxed)
    }

    /// The total time of recordings of passes, each from the call that submitted it to the end of the wait for it.
    pub fn submitted_time(&self) -> Duration {
        Duration::from_nanos(self.submitted.load(Ordering::Relaxed))
    }

    /// The driver's results for the shaders.
    pub fn compiled(&self) -> Vec<Compiled> {
        let compiled = self.compiled.lock();
        compiled.map(|all| all.clone()).unwrap_or_default()
    }

    /// An earlier result of the driver for the same SPIR-V in the same pass.
    pub(super) fn find_compiled(&self, name: &str, shader: &str) -> Option<Compiled> {
        let compiled = self.compiled.lock().ok()?;
        let mut same = compiled.iter();
        same.find(|one| one.shader == shader && one.name == name)
            .cloned()
    }

    /// The outputs of passes since the last call, in their order, if outputs are hashed.
    pub fn take_outputs(&self) -> Vec<Output> {
        let outputs = self.outputs.lock();
        outputs
            .map(|mut outputs| std::mem::take(&mut *outputs))
            .unwrap_or_default()
    }

    /// The buffers and images that exist, by name.
    pub fn memory_use(&self) -> MemoryUse {
        let memory = self.memory.lock();
        memory.map(|memory| memory.clone()).unwrap_or_default()
    }

    /// True if the outputs of passes are hashed.
    pub(super) fn hashes_outputs(&self) -> bool {
        self.hashes_outputs.load(Ordering::Relaxed)
    }

    /// Switches the hashing of outputs on.
    pub(super) fn hash_outputs(&self) {
        self.hashes_outputs.store(true, Ordering::Relaxed);
    }

    pub(super) fn note_shader(&self, bytes: u64) {
        self.shaders.fetch_add(bytes, Ordering::Relaxed);
    }

    pub(super) fn note_submitted(&self, taken: Duration) {
        let nanoseconds = taken.as_nanos() as u64;
        self.submitted.fetch_add(nanoseconds, Ordering::Relaxed);
    }

    pub(super) fn note_compiled(&self, compiled: Compiled) {
        if let Ok(mut all) = self.compiled.lock() {
            all.push(compiled);
        }
    }

    pub(super) fn note_output(&self, output: Output) {
        if let Ok(mut outputs) = self.outputs.lock() {
            outputs.push(output);
        }
    }

    /// Records that a buffer or image with this name was allocated.
    pub(super) fn note_allocated(&self, name: &str, bytes: u64) {
        if let Ok(mut memory) = self.memory.lock() {
            let entry = memory.entry(name.to_owned()).or_default();
            *entry = (entry.0 + 1, entry.1 + bytes);
        }
    }

    /// Records that a buffer or image with this name was freed.
    pub(super) fn note_freed(&self, name: &str, bytes: u64) {
        if let Ok(mut memory) = self.memory.lock() {
            let entry = memory.entry(name.to_owned()).or_default();
            *entry = (entry.0.saturating_sub(1), entry.1.saturating_sub(bytes));
            if entry.0 == 0 {
                memory.remove(name);
            }
        }
    }
}
