//! The memory that loading takes. It is a process of its own, because what a process has in memory when it starts
//! a program is counted as the program's: this one keeps little.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::{Command, Stdio};

/// Runs the program; the bytes that it had in memory at most.
fn peak_memory(arguments: &[&str]) -> u64 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_headwater"))
        .args(arguments)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut usage = std::mem::MaybeUninit::<libc::rusage>::zeroed();
    let mut status = 0;
    // SAFETY: waits for the child just started, and fills what it is given.
    let usage = unsafe {
        libc::wait4(child.id() as i32, &raw mut status, 0, usage.as_mut_ptr());
        usage.assume_init()
    };
    // It was waited for already; this only tells the standard library.
    let _ = child.try_wait();
    assert_eq!(status, 0, "{arguments:?}");
    // Linux counts in KiB.
    usage.ru_maxrss as u64 * 1024
}

/// Writes a wavy ground of 2 · `side`² triangles.
fn write_obj(path: &Path, side: u32) {
    let mut file = BufWriter::new(File::create(path).unwrap());
    let row = side + 1;
    for i in 0..row * row {
        let (x, z) = (f64::from(i % row) * 0.1, f64::from(i / row) * 0.1);
        writeln!(file, "v {x:.6} {:.6} {z:.6}", x.sin() * z.cos()).unwrap();
    }
    for i in (0..row * side).filter(|i| i % row < side) {
        let (a, b, c, d) = (i + 1, i + 2, i + row + 1, i + row + 2);
        writeln!(file, "f {a} {c} {b}\nf {b} {c} {d}").unwrap();
    }
    file.flush().unwrap();
}

#[test]
fn loading_takes_at_most_four_times_a_files_memory() {
    let triangles = match std::env::var_os("HEADWATER_TEST_ALL") {
        Some(_) => 5_000_000,
        None => 1_000_000,
    };
    let folder = tempfile::tempdir().unwrap();
    let paths = ["a.glb", "a.obj"].map(|name| folder.path().join(name));
    let [glb, obj] = paths.each_ref().map(|path| path.to_str().unwrap());
    let setting = format!("triangles={triangles}");
    peak_memory(&["scene", "generate", "terrain", "--set", &setting, "-o", glb]);
    write_obj(Path::new(obj), f64::from(triangles / 2).sqrt() as u32);
    let nothing = peak_memory(&["--help"]);
    for path in [glb, obj] {
        let size = std::fs::metadata(path).unwrap().len();
        let peak = peak_memory(&["scene", "inspect", path]);
        println!("{path}: {size} bytes, {peak} in memory, {nothing} without");
        assert!(peak <= 4 * size, "{size} bytes, {peak} in memory");
        // Or it was not the program that was measured.
        assert!(
            peak > nothing + size / 2,
            "{peak} in memory, {nothing} without"
        );
    }
}
