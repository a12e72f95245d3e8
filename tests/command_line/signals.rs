//! Tests of SIGINT and SIGTERM: the results that are kept, and the effect of a second signal.

use crate::{headwater, text};
use headwater::image::Image;
use std::io::Read;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

/// A child process that is killed when a test fails.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn start(arguments: &[&str]) -> Running {
    let mut command = headwater(arguments);
    command.env("HEADWATER_SAVE_SECONDS", "1000");
    Running(
        command
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap(),
    )
}

fn send(child: &Running, signal: i32) {
    // SAFETY: a signal to the child just started.
    assert_eq!(unsafe { libc::kill(child.0.id() as i32, signal) }, 0);
}

/// Waits until a child process has a handler of SIGINT.
fn wait_until_it_watches(child: &Running) {
    let path = format!("/proc/{}/status", child.0.id());
    let began = Instant::now();
    let watches = || {
        let status = std::fs::read_to_string(&path).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        let caught = u64::from_str_radix(caught.unwrap().trim(), 16).unwrap();
        caught & (1 << (libc::SIGINT - 1)) != 0
    };
    while !watches() {
        assert!(began.elapsed() < Duration::from_secs(60), "no handler");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// The next line that a child writes to stderr; for a long command, the first one is an estimate of its duration.
fn first_line(child: &mut Running) -> String {
    let mut byte = [0];
    let mut line = Vec::new();
    let errors = child.0.stderr.as_mut().unwrap();
    while errors.read(&mut byte).unwrap() == 1 && byte != *b"\n" {
        line.push(byte[0]);
    }
    String::from_utf8(line).unwrap()
}

/// The next line on stderr that contains `part`. The lines before it depend on the speed of the machine and are dropped.
fn line_with(child: &mut Running, part: &str) -> String {
    let mut before = String::new();
    loop {
        match first_line(child) {
            line if line.contains(part) => return line,
            line if line.is_empty() => panic!("no line with '{part}': {before}"),
            line => before += &format!("{line}\n"),
        }
    }
}

/// Waits for the end of a child; returns its exit status and the rest of its stderr.
fn ended(mut child: Running) -> (Option<i32>, String) {
    let mut said = String::new();
    let mut errors = child.0.stderr.take().unwrap();
    errors.read_to_string(&mut said).unwrap();
    (child.0.wait().unwrap().code(), said)
}

/// GNU `timeout` sends its signal twice, to the child and to the child's process group; that must count as one signal.
#[test]
fn two_signals_at_once_are_one() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr");
    let long = ["--width", "64", "--spp", "100000000", "-o", text(&out)];
    let arguments = [&["reference", "cornell"], &long[..]].concat();
    for _ in 0..4 {
        let mut child = start(&arguments);
        let _ = first_line(&mut child);
        send(&child, libc::SIGTERM);
        std::thread::sleep(Duration::from_millis(2));
        send(&child, libc::SIGTERM);
        let (status, said) = ended(child);
        assert_eq!(status, Some(143), "{said}");
        assert!(said.contains("keeps"), "{said}");
        assert!(Image::read(&out).is_ok());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        std::fs::remove_file(&out).unwrap();
    }
}

/// Nobody reads the output of the process, so it blocks while it writes, and only a second signal can end it.
#[test]
fn a_signal_more_than_a_second_after_the_first_ends_the_process_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("a.gltf");
    // The list of cameras is longer than what a pipe holds.
    let camera = r#"{"type":"perspective","perspective":{"yfov":1}}"#;
    let nodes = vec![r#"{"camera":0}"#; 20_000].join(",");
    let text_of_scene =
        format!(r#"{{"asset":{{"version":"2.0"}},"cameras":[{camera}],"nodes":[{nodes}]}}"#);
    std::fs::write(&scene, text_of_scene).unwrap();
    let mut command = headwater(&["scene", "inspect", text(&scene)]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = Running(command.spawn().unwrap());
    let mut printed = child.0.stdout.take().unwrap();
    printed.read_exact(&mut [0]).unwrap();
    send(&child, libc::SIGINT);
    std::thread::sleep(Duration::from_millis(1500));
    let status = child.0.try_wait().unwrap();
    assert_eq!(status, None, "the first signal ended the process");
    send(&child, libc::SIGINT);
    let (status, said) = ended(child);
    assert_eq!(status, Some(130), "{said}");
    drop(printed);
}

#[test]
fn accumulated_frames_are_kept_when_a_signal_comes() {
    let folder = tempfile::tempdir().unwrap();
    let [out, again] = ["a.exr", "b.exr"].map(|name| folder.path().join(name));
    for (signal, preset) in [(libc::SIGINT, "path-tracing"), (libc::SIGTERM, "accurate")] {
        let arguments = ["render", "cornell", "--width", "32", "--accumulate"];
        let arguments = [&arguments[..], &["--preset", preset, "--frames"]].concat();
        let long = [&arguments[..], &["4294967295", "-o", text(&out)]].concat();
        let mut child = start(&long);
        line_with(&mut child, "4294967295 frames will take about");
        send(&child, signal);
        let (status, said) = ended(child);
        assert_eq!(status, Some(128 + signal), "{said}");
        let last = said.lines().last().unwrap_or_default();
        let kept = Image::read(&out).unwrap();
        let frames = &kept.metadata["headwater.samples"];
        assert!(
            last.contains(&format!(
                "mean of the {frames} complete frames of 4294967295"
            )),
            "{said}"
        );
        // They are what as many frames asked for come to.
        crate::succeed(&[&arguments[..], &[frames, "-o", text(&again)]].concat());
        assert!(
            std::fs::read(&out).unwrap() == std::fs::read(&again).unwrap(),
            "{frames} frames of {preset} differ"
        );
    }
}

#[test]
fn a_study_tells_how_much_of_all_its_work_is_done_and_how_long_the_rest_takes() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut child = start(&["study", "--plan", "bias-matrix", "-o", text(&out)]);
    let line = line_with(&mut child, " left");
    send(&child, libc::SIGINT);
    let (status, said) = ended(child);
    assert_eq!(status, Some(130), "{said}");
    assert!(line.contains("% of the study after"), "{line}");
    // A step that took long may be followed by a line of its own.
    let last = said.lines().last().unwrap_or_default();
    let truth = if out.exists() {
        "out keeps the finished runs; the same command continues"
    } else {
        "nothing was written"
    };
    assert!(last.contains(truth), "{said}");
}

#[test]
fn a_study_that_is_stopped_before_anything_is_finished_leaves_nothing_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let child = start(&["study", "--plan", "bias-matrix", "-o", text(&out)]);
    wait_until_it_watches(&child);
    send(&child, libc::SIGINT);
    let (status, said) = ended(child);
    assert_eq!(status, Some(130), "{said}");
    assert!(said.contains("nothing was written"), "{said}");
    assert!(!out.exists());
}
