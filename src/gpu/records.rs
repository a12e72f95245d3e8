//! Records of the work on a device (compiled shaders, times, memory, hashes of outputs), for profiles and regression tests.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// A hash of a buffer's content after a pass that may write the buffer. Regression tests compare the hashes of two drivers,
/// to find the first pass whose results differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// Name of the pass that ran last before the hash was made.
    pub pass: String,
    /// Name of the buffer that the pass may write.
    pub buffer: String,
    /// The first 16 hexadecimal digits of the BLAKE3 hash of all bytes of this buffer after the pass.
    pub hash: String,
}

/// The memory that buffers and images occupy now, which profiles show. The key is the name under which buffers were
/// allocated. The value is the number of buffers with this name, and the sum of their sizes in bytes. All images together
/// have the name `images`.
pub type MemoryUse = BTreeMap<String, (u32, u64)>;

/// The driver's result for one pipeline: the time to make it, and the report of the driver's compiler. Profiles show both,
/// so that an expensive shader can be found.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// Name of the pass for which the pipeline was made.
    pub name: String,
    /// The first 16 hexadecimal digits of the BLAKE3 hash of the SPIR-V that the driver compiled.
    pub shader: String,
    /// Time in which the driver made the pipeline, on the host, in milliseconds.
    pub milliseconds: f64,
    /// The report of the driver's compiler; empty without
    /// [`Features::executable_properties`](super::Features::executable_properties), or if the driver fails to report.
    pub report: CompilerReport,
}

/// A driver's statistics about one pipeline, for profiles. Their names and values are those of the driver.
#[derive(Clone, Debug, Default)]
pub struct CompilerReport {
    /// Number of invocations in a subgroup; 0 if the driver does not report it.
    pub subgroup_size: u32,
    /// The report of the driver's compiler about the pipeline, such as the number of registers: pairs of name and value, in
    /// the driver's order. The names differ between drivers.
    pub statistics: Vec<(String, String)>,
}

/// The records of the work on a device since it was opened, which profiles and regression tests read. If a thread panics
/// while it changes one of the lists, this list is not changed any more, and reads as empty. This is no error, because
/// rendering does not depend on the records.
#[derive(Default)]
pub struct Records {
    /// Total size in bytes of the SPIR-V of all pipelines made so far; see [`Records::shader_bytes`].
    shaders: AtomicU64,
    /// Total time on the host of the recordings that [`Recording::finish`](super::Recording::finish) submitted, in
    /// nanoseconds; see [`Records::submitted_time`].
    submitted: AtomicU64,
    compiled: Mutex<Vec<Compiled>>,
    hashes_outputs: AtomicBool,
    outputs: Mutex<Vec<Output>>,
    memory: Mutex<MemoryUse>,
}

impl Records {
    /// Total size in bytes of the SPIR-V of all pipelines made so far, after specialisation and removal of dead code. It
    /// shows how a change of shaders changes the amount of code that the driver must compile.
    pub fn shader_bytes(&self) -> u64 {
        self.shaders.load(Ordering::Relaxed)
    }

    /// The total time on the host of all recordings that [`Recording::finish`](super::Recording::finish) submitted. Each
    /// recording counts from its submission to the end of the wait for it. Those that
    /// [`Recording::submit`](super::Recording::submit) submitted do not count. A profile with one frame in flight reads this
    /// total before and after a frame; the difference is the time of the frame's recordings.
    pub fn submitted_time(&self) -> Duration {
        Duration::from_nanos(self.submitted.load(Ordering::Relaxed))
    }

    /// The driver's results, one for each pipeline made so far, in the order in which the pipelines were finished.
    pub fn compiled(&self) -> Vec<Compiled> {
        let compiled = self.compiled.lock();
        compiled.map(|all| all.clone()).unwrap_or_default()
    }

    /// An earlier result of the driver for the pass `name` and SPIR-V whose hash is `shader` ([`Compiled::shader`]); `None`
    /// if there is none. A device that only compiles uses it instead of compiling the same shader again.
    pub(super) fn find_compiled(&self, name: &str, shader: &str) -> Option<Compiled> {
        let compiled = self.compiled.lock().ok()?;
        let mut same = compiled.iter();
        same.find(|one| one.shader == shader && one.name == name)
            .cloned()
    }

    /// Returns the hashes that were made since the device was opened, or since this function was last called, and removes
    /// them from the records. There is one hash for each buffer that a pass may write, in the order of the passes. The list
    /// is empty unless [`Device::hash_outputs`](super::Device::hash_outputs) was called.
    pub fn take_outputs(&self) -> Vec<Output> {
        let outputs = self.outputs.lock();
        outputs
            .map(|mut outputs| std::mem::take(&mut *outputs))
            .unwrap_or_default()
    }

    /// The buffers and images that exist now: for each name, their number and the sum of their sizes in bytes.
    pub fn memory_use(&self) -> MemoryUse {
        let memory = self.memory.lock();
        memory.map(|memory| memory.clone()).unwrap_or_default()
    }

    /// True if the outputs of passes are hashed. Each pass is then submitted alone, so that its outputs can be read.
    pub(super) fn hashes_outputs(&self) -> bool {
        self.hashes_outputs.load(Ordering::Relaxed)
    }

    /// Switches the hashing of the outputs of passes on, until the device is closed.
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

    /// Adds a buffer or image of `bytes` bytes, allocated under the name `name`, to the record of the memory in use.
    pub(super) fn note_allocated(&self, name: &str, bytes: u64) {
        if let Ok(mut memory) = self.memory.lock() {
            let entry = memory.entry(name.to_owned()).or_default();
            *entry = (entry.0 + 1, entry.1 + bytes);
        }
    }

    /// Removes a freed buffer or image of `bytes` bytes with the name `name` from the memory in use.
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
