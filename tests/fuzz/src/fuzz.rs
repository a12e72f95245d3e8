//! Fuzzes the target that the environment variable `HEADWATER_FUZZ_TARGET` names; its arguments are those of libFuzzer.
#![no_main]

use headwater_fuzz::random::Random;
use headwater_fuzz::targets::{TARGETS, Target};
use headwater_fuzz::{Counts, gltf, is_thorough};
use libfuzzer_sys::{Corpus, fuzz_mutator, fuzz_target, fuzzer_mutate};
use std::sync::LazyLock;

static TARGET: LazyLock<Target> = LazyLock::new(|| {
    // libFuzzer sees nothing of what other threads do.
    let threads = rayon::ThreadPoolBuilder::new().num_threads(1);
    let pool = threads.use_current_thread().build_global();
    pool.expect("no other pool");
    let name = std::env::var("HEADWATER_FUZZ_TARGET").unwrap_or_default();
    let target = TARGETS.into_iter().find(|target| target.name == name);
    target.expect("HEADWATER_FUZZ_TARGET names a target")
});
static COUNTS: Counts = Counts::new();

/// Mutations that are tried until one leaves the header readable.
const TRIES: usize = 16;

fuzz_target!(|bytes: &[u8]| -> Corpus {
    (TARGET.run)(bytes);
    let has_header = (TARGET.has_header)(bytes);
    COUNTS.add(has_header);
    // Else most of the corpus, and so of what is made of it, would be files with damaged headers.
    if has_header || is_thorough(bytes) {
        Corpus::Keep
    } else {
        Corpus::Reject
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let mut random = Random(seed.into());
    random.unit();
    let tries = if random.index(16) > 0 { TRIES } else { 1 };
    let old = data[..size].to_vec();
    let mut new_size = size;
    for _ in 0..tries {
        data[..size].copy_from_slice(&old);
        new_size = match TARGET.name {
            "gltf" | "glb" => gltf::mutate(data, size, max_size, &mut random),
            _ => fuzzer_mutate(data, size, max_size),
        };
        if (TARGET.has_header)(&data[..new_size]) {
            break;
        }
    }
    new_size
});
