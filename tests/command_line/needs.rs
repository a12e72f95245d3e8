//! Tests of `render --budget-ms` and `render --target-relmse`.

use super::{headwater, messages, text};
use std::path::Path;
use std::process::Output;

/// Renders a small picture with the options `options` to `file`; measurements are kept in `folder`.
fn render(folder: &Path, options: &[&str], file: &Path) -> Output {
    let scene = ["render", "cornell", "--width", "24", "--measure-time", "2"];
    headwater(&[&scene, options, &["-o", text(file)]].concat())
        .env("XDG_CACHE_HOME", folder)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// The messages of a run that ended with `status`.
fn failed(output: Output, status: i32) -> String {
    let said = messages(output.stderr);
    assert_eq!(output.status.code(), Some(status), "{said}");
    said
}

/// The scene is measured once; the choice has enough frames for the error, and the command that is printed repeats the file.
#[test]
fn an_error_is_reached_and_the_printed_command_repeats_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Two candidates alone take less time to compile.
    let options = [
        "--target-relmse",
        "0.02",
        "--seed",
        "7",
        "--preset",
        "balanced",
    ];
    let first = render(folder, &options, &folder.join("first.exr"));
    let said = messages(first.stderr);
    assert!(first.status.success(), "{said}");
    assert!(said.contains("measuring the scene"), "{said}");
    let again = said
        .lines()
        .find_map(|line| line.split_once("again: headwater "));
    let (_, again) = again.expect(&said);
    assert!(
        again.contains("--accumulate") && again.contains("--seed 7"),
        "{again}"
    );
    let words: Vec<&str> = again.split_whitespace().collect();
    let repeated = headwater(&words).current_dir(folder).output().unwrap();
    assert!(repeated.status.success(), "{}", messages(repeated.stderr));
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert!(read("first.exr") == read("picture.exr"), "{again}");

    // A known scene is not measured again, and the same frames are chosen.
    let second = render(folder, &options, &folder.join("second.exr"));
    let said = messages(second.stderr);
    assert!(
        second.status.success() && !said.contains("measuring"),
        "{said}"
    );
    assert!(read("first.exr") == read("second.exr"), "{said}");
    // Neither the seed nor the need changes the measurements, but the light does.
    let third = folder.join("third.exr");
    for (changes, measures) in [(&["--seed", "8"][..], false), (&["--bounces", "2"], true)] {
        let need = ["--target-relmse", "0.03", "--preset", "balanced"];
        let options = [&need, changes].concat();
        let output = render(folder, &options, &third);
        let said = messages(output.stderr);
        assert!(output.status.success(), "{said}");
        assert_eq!(said.contains("measuring"), measures, "{changes:?}: {said}");
    }

    let reference = folder.join("reference.exr");
    let scene = ["reference", "cornell", "--width", "24", "--spp", "4096"];
    let output = headwater(&[&scene[..], &["-o", text(&reference)]].concat()).output();
    assert!(output.unwrap().status.success());
    let compared = headwater(&["compare", "first.exr", text(&reference), "--json"])
        .current_dir(folder)
        .output()
        .unwrap();
    let compared: serde_json::Value = serde_json::from_slice(&compared.stdout).unwrap();
    let relmse = compared["relmse"].as_f64().unwrap();
    // One picture scatters around the mean over seeds by about 10 %, and two seconds on a busy machine measure as badly.
    assert!((0.01..0.03).contains(&relmse), "{compared:#}");
}

/// Among the candidates that a large budget allows, the one with the least error is chosen, and the user's number of frames
/// stays.
#[test]
fn a_budget_is_met_with_the_frames_that_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let options = [
        "--budget-ms",
        "1e5",
        "--preset",
        "balanced",
        "--frames",
        "3",
    ];
    let output = render(folder, &options, &folder.join("picture.exr"));
    let said = messages(output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("chosen: `balanced`, the last one of 3 frames"),
        "{said}"
    );
}

/// A need that nothing meets is said, with the nearest; the picture is there all the same. Settings of the user are kept.
#[test]
fn needs_that_nothing_meets_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let file = folder.join("picture.exr");
    let options = ["--budget-ms", "1e-6", "--preset", "fast", "--frames", "2"];
    let said = failed(render(folder, &options, &file), 1);
    assert!(
        said.contains("--budget-ms") && said.contains("`fast`") && said.contains(" ms per frame"),
        "{said}"
    );
    assert!(said.contains("the last one of 2 frames"), "{said}");
    assert!(file.exists());
    let said = failed(render(folder, &["--target-relmse", "0"], &file), 2);
    assert!(said.contains("--target-relmse 0"), "{said}");
    // What path tracing does not show has no reference.
    for (options, expected) in [
        (["--set", "indirect.mode=off"], "indirect.mode=off"),
        (["--set", "integrator=path-tracing"], "integrator"),
        (["--bounces", "0"], "--bounces 0"),
    ] {
        let options = [&["--target-relmse", "0.1"], &options[..]].concat();
        let said = failed(render(folder, &options, &file), 2);
        assert!(said.contains(expected), "{said}");
    }
    let said = failed(
        render(folder, &["--budget-ms", "5", "--target-relmse", "1"], &file),
        2,
    );
    assert!(said.contains("--budget-ms"), "{said}");
}
