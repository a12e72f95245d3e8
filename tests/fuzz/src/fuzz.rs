//! Fuzzes the target that the environment variable `HEADWATER_FUZZ_TARGET` names; its arguments are those of libFuzzer.
#![no_main]

use headwater_fuzz::targets::{Run, TARGETS};
use headwater_fuzz::{Counts, gltf};
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use std::sync::LazyLock;

static TARGET: LazyLock<(&str, Run)> = LazyLock::new(|| {
    // libFuzzer sees nothing of what other threads do.
    let threads = rayon::ThreadPoolBuilder::new().num_threads(1);
    let pool = threads.use_current_thread().build_global();
    pool.expect("no other pool");
    let name = std::env::var("HEADWATER_FUZZ_TARGET").unwrap_or_default();
    let target = TARGETS.into_iter().find(|(target, _)| *target == name);
    target.expect("HEADWATER_FUZZ_TARGET names a target")
});
static COUNTS: Counts = Counts::new();

fuzz_target!(|bytes: &[u8]| {
    let (_, run) = *TARGET;
    COUNTS.add(run(bytes));
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    match TARGET.0 {
        "gltf" | "glb" => gltf::mutate(data, size, max_size, seed),
        _ => fuzzer_mutate(data, size, max_size),
    }
});
