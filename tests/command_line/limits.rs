//! Tests of commands without enough memory or threads: they end with one line and status 1, and keep what was finished.

use crate::{headwater, messages, text};
use headwater::image::Image;
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Asserts that a command has ended with status 1 and one line on stderr, and returns the line.
fn failed(output: Output) -> String {
    let said = messages(output.stderr);
    assert_eq!(output.status.code(), Some(1), "{}: {said}", output.status);
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

/// A command that runs under a limit of the shell (`ulimit`), such as one of memory.
fn limited(limit: &str, program: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new("bash");
    command.env_remove("RUST_BACKTRACE");
    let script = format!("ulimit {limit} && exec \"$0\" \"$@\"");
    command.arg("-c").arg(script).arg(program).args(arguments);
    command
}

#[test]
fn a_scene_that_memory_does_not_hold_ends_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.glb");
    let program = Path::new(env!("CARGO_BIN_EXE_headwater"));
    let triangles = ["--set", "triangles=12000000", "-o", text(&out)];
    let arguments = [&["scene", "generate", "terrain"], &triangles[..]].concat();
    let line = failed(limited("-v 400000", program, &arguments).output().unwrap());
    assert!(line.contains("out of memory"), "{line}");
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

/// A grey PNG needs far more memory than its texels take in the file: this is known before it is decoded.
#[test]
fn a_grey_png_that_memory_does_not_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grey.png");
    image::GrayImage::new(8192, 4096).save(&path).unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_headwater"));
    let arguments = ["compare", text(&path), text(&path)];
    let mut command = limited("-v 800000", program, &arguments);
    // Each thread takes address space.
    let output = command.env("RAYON_NUM_THREADS", "1").output().unwrap();
    let line = messages(output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}");
    let needed = format!(
        "grey.png: {} bytes are more than there is memory for",
        30_u64 << 25
    );
    assert!(line.contains(&needed), "{line}");
}

/// Whatever memory is missing, the last save stays whole. Some allocations of a software driver are not checked, and end the
/// process by a signal; where the program itself lacks memory, it says so.
#[test]
fn a_reference_that_runs_out_of_memory_keeps_its_last_save() {
    let said = (0..6).find_map(|_| {
        let output = without_memory();
        output.status.code().is_some().then(|| failed(output))
    });
    let line = said.expect("each of six processes was ended by a signal");
    assert!(line.contains("out of memory"), "{line}");
}

/// Runs a reference that gets no more memory after its first save, and checks that a save is left.
fn without_memory() -> Output {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr");
    let child = headwater(&[
        "reference",
        "cornell",
        "--width",
        "256",
        "--spp",
        "1000",
        "-o",
        text(&out),
    ])
    .env("HEADWATER_SAVE_SECONDS", "0")
    .env_remove("RUST_BACKTRACE")
    .stdout(Stdio::null())
    .stderr(Stdio::piped())
    .spawn()
    .unwrap();
    let began = Instant::now();
    while !out.exists() {
        assert!(began.elapsed() < Duration::from_secs(60), "no file");
        std::thread::sleep(Duration::from_millis(10));
    }
    let none = libc::rlimit {
        rlim_cur: 1 << 20,
        rlim_max: 1 << 20,
    };
    let id = child.id() as i32;
    // SAFETY: the limits of the child just started, from a structure that lives during the call.
    let set = unsafe { libc::prlimit(id, libc::RLIMIT_AS, &none, std::ptr::null_mut()) };
    assert_eq!(set, 0);
    let output = child.wait_with_output().unwrap();
    let kept = Image::read(&out).unwrap();
    assert!(kept.metadata["headwater.samples"].parse::<u32>().unwrap() > 0);
    if output.status.code().is_some() {
        assert_eq!(folder.path().read_dir().unwrap().count(), 1);
    }
    output
}

#[test]
fn threads_that_cannot_be_started_are_one_line() {
    let folder = tempfile::tempdir().unwrap();
    // Root has no such limit, and another user may not read the folder of the build.
    std::fs::set_permissions(folder.path(), Permissions::from_mode(0o755)).unwrap();
    let program = folder.path().join("headwater");
    let built = env!("CARGO_BIN_EXE_headwater");
    let linked = std::fs::hard_link(built, &program);
    linked
        .or_else(|_| std::fs::copy(built, &program).map(drop))
        .unwrap();
    // SAFETY: it only asks who runs this.
    let is_root = unsafe { libc::geteuid() } == 0;
    for arguments in [
        &["scene", "list"][..],
        &["render", "cornell", "-o", "a.exr"],
    ] {
        let mut command = limited("-u 1", &program, arguments);
        if is_root {
            const NOBODY: u32 = 65534;
            command.uid(NOBODY).gid(NOBODY);
        }
        let line = failed(command.current_dir("/").output().unwrap());
        assert!(line.contains("cannot start threads"), "{line}");
        assert!(line.contains("ulimit -u"), "{line}");
    }
}
