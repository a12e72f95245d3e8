//! Measures the stages of opening a scene, for `-v`.

use rustix::time::{ClockId, Timespec, clock_gettime};
use std::time::Instant;

/// Runs `work` and returns its result. The wall time and the CPU time of all threads that it takes are logged, in seconds,
/// behind the name of the stage.
pub fn timed<T>(stage: &str, work: impl FnOnce() -> T) -> T {
    let (start, cpu_start) = (Instant::now(), cpu_seconds());
    let result = work();
    log::info!(
        "{stage}: {:.2} s ({:.2} s of CPU time)",
        start.elapsed().as_secs_f64(),
        cpu_seconds() - cpu_start
    );
    result
}

/// The CPU time that the process has taken so far, in seconds.
fn cpu_seconds() -> f64 {
    let Timespec { tv_sec, tv_nsec } = clock_gettime(ClockId::ProcessCPUTime);
    tv_sec as f64 + tv_nsec as f64 * 1e-9
}
