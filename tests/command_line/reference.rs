//! Tests of references and large pictures that are stopped, killed and resumed.

use crate::{fail, headwater, run, succeed, succeeded, text, validated};
use headwater::image::Image;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

const REFERENCE: [&str; 6] = ["reference", "cornell", "--width", "96", "--seed", "3"];

fn samples_of(path: &Path) -> u32 {
    let image = Image::read(path).unwrap();
    image.metadata["headwater.samples"].parse().unwrap()
}

/// Waits until another process has created a file.
fn wait_for(path: &Path) {
    let start = Instant::now();
    while !path.exists() && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(path.exists(), "no file after a minute");
}

#[test]
fn a_reference_that_was_stopped_resumes_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole.exr", "parts.exr"].map(|n| folder.path().join(n));
    let arguments = [&REFERENCE[..], &["-o", text(&parts)]].concat();
    let mut child = validated(&[&arguments[..], &["--spp", "1000000"]].concat())
        .env("HEADWATER_SAVE_SECONDS", "0")
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for(&parts);
    // SAFETY: a signal to the child just started.
    unsafe { libc::kill(child.id() as i32, libc::SIGINT) };
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let stopped = samples_of(&parts);
    let more = (stopped + 50).to_string();
    succeeded(validated(
        &[&arguments[..], &["--spp", &more, "--resume"]].concat(),
    ));
    succeed(&[&REFERENCE[..], &["--spp", &more, "-o", text(&whole)]].concat());
    assert_eq!(samples_of(&parts), stopped + 50);
    assert!(
        std::fs::read(&whole).unwrap() == std::fs::read(&parts).unwrap(),
        "bits differ"
    );
    let other = [
        &REFERENCE[..4],
        &["--seed", "4", "-o", text(&parts), "--resume"],
    ]
    .concat();
    assert!(fail(&other, 2).contains("headwater.seed"));
}

#[test]
fn a_target_error_is_met_at_the_same_samples_wherever_a_run_was_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole.exr", "parts.exr"].map(|n| folder.path().join(n));
    let target = ["--target-error", "0.05"];
    succeed(&[&REFERENCE[..], &target, &["-o", text(&whole)]].concat());
    let met = samples_of(&whole);
    assert!(met > 80, "met after {met}, before a stop can matter");
    let arguments = [&REFERENCE[..], &["-o", text(&parts)]].concat();
    // Not one of the counts at which a run looks.
    succeed(&[&arguments[..], &["--spp", "71"]].concat());
    for _ in 0..2 {
        succeed(&[&arguments[..], &target, &["--resume"]].concat());
        assert!(
            std::fs::read(&whole).unwrap() == std::fs::read(&parts).unwrap(),
            "{} samples instead of {met}",
            samples_of(&parts)
        );
    }
}

#[test]
fn a_reference_stopped_before_its_first_sample_leaves_the_file_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let arguments = [&REFERENCE[..], &["--spp", "2", "-o", text(&path)]].concat();
    succeed(&arguments);
    let before = std::fs::read(&path).unwrap();
    let mut child = headwater(&[&arguments[..], &["--spp", "1000000"]].concat()[..])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // SAFETY: a signal to the child just started, which may not yet watch for it.
    unsafe { libc::kill(child.id() as i32, libc::SIGINT) };
    child.wait().unwrap();
    assert!(std::fs::read(&path).unwrap() == before);
}

#[test]
fn a_damaged_reference_is_not_resumed_and_the_message_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let arguments = [&REFERENCE[..], &["--spp", "2", "-o", text(&path)]].concat();
    succeed(&arguments);
    let whole = std::fs::read(&path).unwrap();
    let resume = [&arguments[..], &["--resume"]].concat();
    for damaged in [&whole[..whole.len() / 2], b"no picture", b""] {
        std::fs::write(&path, damaged).unwrap();
        let line = fail(&resume, 2);
        assert!(line.contains(text(&path)), "{line}");
        assert!(line.contains("start again without --resume"), "{line}");
        assert!(std::fs::read(&path).unwrap() == damaged);
    }
    std::fs::remove_file(&path).unwrap();
    let line = fail(&resume, 2);
    assert!(line.contains("start again without --resume"), "{line}");
    // Which works.
    std::fs::write(&path, "").unwrap();
    succeed(&arguments);
    assert!(std::fs::read(&path).unwrap() == whole);
}

#[test]
fn one_sample_claims_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let output = run(&[&REFERENCE[..], &["--spp", "1", "-o", text(&path)]].concat());
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("standard error needs at least 2"), "{said}");
    assert!(Image::read(&path).unwrap().floats("stderr.R").is_none());
}

#[test]
fn a_killed_reference_leaves_its_last_complete_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let arguments = [&REFERENCE[..], &["--spp", "1000000", "-o", text(&path)]].concat();
    for kill in 0..8 {
        let mut child = headwater(&arguments)
            .env("HEADWATER_SAVE_SECONDS", "0")
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        wait_for(&path);
        // Saves follow each other, so these moments fall into different parts of one.
        std::thread::sleep(Duration::from_millis(400 + 7 * kill));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(samples_of(&path) > 0);
        std::fs::remove_file(&path).unwrap();
    }
}

mod thorough {
    use super::*;

    /// A picture of more than 2²⁰ pixels is rendered in strips, and a signal stops it between two strips.
    #[test]
    fn a_large_picture_is_stopped_between_its_strips_and_a_reference_of_it_resumes() {
        let folder = tempfile::tempdir().unwrap();
        let [whole, parts] = ["whole.exr", "parts.exr"].map(|n| folder.path().join(n));
        let large = ["reference", "cornell", "--width", "1100", "--bounces", "0"];
        let arguments = [&large[..], &["-o", text(&parts)]].concat();
        succeed(&[&arguments[..], &["--spp", "2"]].concat());
        let mut child = headwater(&[&arguments[..], &["--spp", "1000000", "--resume"]].concat())
            .env("HEADWATER_SAVE_SECONDS", "0")
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while samples_of(&parts) == 2 && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(20));
        }
        // SAFETY: a signal to the child just started.
        unsafe { libc::kill(child.id() as i32, libc::SIGTERM) };
        assert_eq!(child.wait().unwrap().code(), Some(143));
        let more = (samples_of(&parts) + 1).to_string();
        succeed(&[&arguments[..], &["--spp", &more, "--resume"]].concat());
        succeed(&[&large[..], &["--spp", &more, "-o", text(&whole)]].concat());
        assert!(
            std::fs::read(&whole).unwrap() == std::fs::read(&parts).unwrap(),
            "bits differ"
        );

        let picture = folder.path().join("large.exr");
        let size = [
            "--width",
            "6000",
            "--bounces",
            "3",
            "--preset",
            "path-tracing",
        ];
        let mut child =
            headwater(&[&["render", "cornell", "-o", text(&picture)], &size[..]].concat())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
        // It says how far it is while its one frame is under way.
        let mut said = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        said.read_line(&mut line).unwrap();
        assert!(
            line.contains("0.") && line.contains("of 1 frames"),
            "{line}"
        );
        // SAFETY: as above.
        unsafe { libc::kill(child.id() as i32, libc::SIGINT) };
        assert_eq!(child.wait().unwrap().code(), Some(130));
        said.read_to_string(&mut line).unwrap();
        assert!(line.contains("nothing was written"), "{line}");
        assert!(!picture.exists());
    }
}
