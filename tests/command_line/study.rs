//! Tests of the command `study`: wrong plans, and studies that are stopped and continued.

use super::{fail, headwater, messages, succeed, text, validated};
use headwater::image::Image;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

const PLAN: &str = r#"
scenes = ["cornell"]
width = 24
frames = 3
seeds = 24
most_seeds = 24
reference_spp = 64
count = true
[[configurations]]
name = "accurate"
preset = "accurate"
expect = "biased"
[[configurations]]
name = "initial visibility"
preset = "s1"
expect = "biased"
"#;

fn write(folder: &Path, plan: &str) -> String {
    let path = folder.join("plan.toml");
    std::fs::write(&path, plan).unwrap();
    text(&path).to_owned()
}

#[test]
fn plans_that_make_no_sense_are_one_line_and_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let out = text(folder.path());
    for (from, to, said) in [
        ("width", "widht", "widht"),
        ("frames = 3", "frames = 0", "frames"),
        ("frames = 3", "frames = 3\nfps = 0", "fps 0"),
        ("frames = 3", "frames = 3\nfps = inf", "fps inf"),
        ("frames = 3", "frames = 3\nstart_time = nan", "start_time"),
        (
            "count = true",
            "fps = 4\n[[configurations]]\nname = \"sum\"\npreset = \"fast\"\naccumulate = true",
            "'sum' accumulates",
        ),
        ("seeds = 24", "seeds = -1", "seeds"),
        ("seeds = 24", "seeds = 4000000000", "65536"),
        ("\"cornell\"", "\"cornel\"", "cornell"),
        ("\"cornell\"", "\"cornell\", \"no.glb\"", "no.glb"),
        (
            "\"cornell\"",
            "{ scene = \"cornell\", look_att = \"0\" }",
            "look_att",
        ),
        (
            "\"cornell\"",
            "{ scene = \"cornell\", look_at = \"0\" }",
            "cornell: look_at '0'",
        ),
        ("\"s1\"", "\"s2\"", "s1"),
        ("expect = \"biased\"", "expect = \"hoped\"", "hoped"),
        (
            "name = \"accurate\"",
            "name = \"initial visibility\"",
            "initial visibility",
        ),
        (
            "preset = \"accurate\"",
            "preset = \"accurate\"\nset = { \"direct.mis\" = \"pairwize\" }",
            "pairwise",
        ),
        (
            "preset = \"accurate\"",
            "preset = \"accurate\"\nset = { \"direct.spatial.radius\" = 1e9 }",
            "direct.spatial.radius",
        ),
        (
            "preset = \"accurate\"",
            "preset = \"accurate\"\nscenes = [\"garage\"]",
            "garage",
        ),
        ("[[configurations]]", "[[configurations", "plan.toml"),
    ] {
        assert!(PLAN.contains(from), "{from}");
        let plan = write(folder.path(), &PLAN.replacen(from, to, 1));
        let error = fail(&["study", "--plan", &plan, "-o", out], 2);
        assert!(error.contains(said), "{error}");
    }
    let error = fail(&["study", "--plan", "bias-matrx", "-o", out], 2);
    assert!(error.contains("bias-matrix"), "{error}");
    let plan = write(
        folder.path(),
        &PLAN.replace("preset =", "scenes = [\"cornell\"]\npreset ="),
    );
    let error = fail(&["study", "garage", "--plan", &plan, "-o", out], 2);
    assert!(error.contains("for scene 'garage'"), "{error}");
    let error = fail(&["study", "--plan", "no/such.toml", "-o", out], 2);
    assert!(error.contains("no/such.toml"), "{error}");
}

#[test]
fn a_study_that_is_stopped_goes_on_to_the_same_results() {
    stop_and_go_on(PLAN);
}

fn stop_and_go_on(plan: &str) {
    let folder = tempfile::tempdir().unwrap();
    let plan = write(folder.path(), plan);
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let output = validated(&["study", "--plan", &plan, "-o", text(&whole)])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");

    let mut child = headwater(&["study", "--plan", &plan, "-o", text(&parts)])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let runs = parts.join("runs.jsonl");
    let began = Instant::now();
    while std::fs::read_to_string(&runs)
        .unwrap_or_default()
        .lines()
        .count()
        < 8
    {
        assert!(
            began.elapsed() < Duration::from_secs(120),
            "no run after two minutes"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    // SAFETY: a signal to the child just started.
    unsafe { libc::kill(child.id() as i32, libc::SIGINT) };
    let stopped = child.wait().unwrap();
    // A machine that is fast enough may have been done already.
    if stopped.code() != Some(0) {
        assert_eq!(stopped.code(), Some(130));
        assert!(!parts.join("results.json").exists());
    }
    let kept = std::fs::read_to_string(&runs).unwrap();

    let output = headwater(&["study", "--plan", &plan, "-o", text(&parts)])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(std::fs::read_to_string(&runs).unwrap().starts_with(&kept));
    // Times differ; pictures do not.
    let results = |folder: &Path| -> Vec<serde_json::Value> {
        let json = std::fs::read_to_string(folder.join("results.json")).unwrap();
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let rows = json["rows"].as_array().unwrap();
        let keys = [
            "configuration",
            "rmse",
            "correlation",
            "bias",
            "counts",
            "settings",
        ];
        rows.iter()
            .map(|row| keys.map(|k| row[k].clone()).into())
            .collect()
    };
    let rows = results(&whole);
    assert_eq!(rows, results(&parts));
    // The first seeds' first frames compiled; no row's time holds that.
    for row in self::rows(&whole) {
        let names = |key: &str| -> Vec<String> {
            let passes = row[key].as_array().unwrap().iter();
            let mut names: Vec<String> = passes.map(|p| p[0].to_string()).collect();
            names.sort_unstable();
            names
        };
        assert_eq!(names("first_runs"), names("milliseconds"), "{row:#}");
    }
    let rays = |row: &serde_json::Value| row[4][0]["rays"].as_u64();
    assert!(rows.iter().all(|row| rays(row) > Some(0)), "{rows:?}");
    let csv = std::fs::read_to_string(parts.join("results.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 2 * 3, "{csv}");
}

/// A glTF scene of one triangle that emits no light, with its positions embedded.
const BLACK: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;

/// The rows of a study's results, as JSON.
fn rows(folder: &Path) -> Vec<serde_json::Value> {
    let json = std::fs::read_to_string(folder.join("results.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["version"], 2);
    json["rows"].as_array().unwrap().clone()
}

/// Emission alone and a black scene have no noise: the study must not raise an alarm or divide by 0.
#[test]
fn a_study_without_noise_has_neither_alarms_nor_infinite_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let black = folder.path().join("black.gltf");
    std::fs::write(&black, BLACK).unwrap();
    for (scene, bounces) in [("cornell", 0), ("night-city", 0), (text(&black), 1)] {
        let plan = format!(
            "scenes = [{scene:?}]\nwidth = 24\nframes = 2\nseeds = 4\nbounces = {bounces}\nreference_spp = 1000\n\
             [[configurations]]\nname = \"a\"\npreset = \"accurate\"\n"
        );
        let plan = write(folder.path(), &plan);
        let out = folder.path().join("out");
        let output = headwater(&["study", "--plan", &plan, "-o", text(&out)])
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
        let said = messages(output.stderr);
        let notices = said.matches("the scene has no light").count();
        assert_eq!(notices, usize::from(scene == text(&black)), "{said}");
        let table = String::from_utf8(output.stdout).unwrap();
        let longest = table.split_whitespace().map(str::len).max();
        let (row, csv) = (
            &rows(&out)[0],
            std::fs::read_to_string(out.join("results.csv")).unwrap(),
        );
        assert_eq!(row["verdict"], "unbiased", "{table}");
        assert!(row["confirmation"].is_null(), "a false alarm: {table}");
        assert_eq!(row["seeds"], 4, "{table}");
        assert!(row["block_bias"]["interval"][1].is_number(), "{row:#}");
        assert!(!format!("{table}{csv}").contains("inf"), "{table}{csv}");
        assert!(longest < Some(80), "a number without end: {table}");
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn two_studies_do_not_work_in_one_folder() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let study = [
        "study",
        "cornell",
        "--plan",
        "bias-matrix",
        "-o",
        text(&out),
    ];
    let mut first = headwater(&study).stderr(Stdio::null()).spawn().unwrap();
    let began = Instant::now();
    while !out.join("references").exists() && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let plan = write(folder.path(), &PLAN.replace("seeds = 24", "seeds = 2"));
    let short = ["study", "--plan", &plan, "-o", text(&out)];
    let output = headwater(&short).output().unwrap();
    first.kill().unwrap();
    first.wait().unwrap();
    let said = messages(output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("another study is running in"), "{said}");
    assert!(said.contains("--output"), "{said}");
    // The lock ends with whoever holds it, however that ends.
    succeed(&short);
}

#[test]
fn a_refused_study_leaves_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    let (out, scene) = (folder.path().join("a/b"), folder.path().join("bad.glb"));
    std::fs::write(&scene, "no scene").unwrap();
    let plan = write(folder.path(), PLAN);
    let study = ["study", "--plan", &plan, "-o", text(&out)];
    for more in [vec!["--device", "no such device"], vec![text(&scene)]] {
        fail(&[&study[..], &more].concat(), 2);
        assert!(!folder.path().join("a").exists(), "{more:?}");
    }
}

mod thorough {
    use super::*;

    #[test]
    fn a_damaged_reference_is_named_with_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let plan = write(folder.path(), &PLAN.replace("seeds = 24", "seeds = 2"));
        let study = ["study", "--plan", &plan, "-o", text(&out)];
        succeed(&study);
        let references = std::fs::read_dir(out.join("references")).unwrap();
        let reference = references.last().unwrap().unwrap().path();
        let whole = std::fs::read(&reference).unwrap();
        let mut other = Image::new(3, 3);
        other.set_vectors("", ["R", "G", "B"], &[[0.5; 3]; 9]);
        for damage in 0..3 {
            match damage {
                0 => std::fs::write(&reference, &whole[..whole.len() / 2]).unwrap(),
                1 => std::fs::write(&reference, "").unwrap(),
                _ => other.write(&reference, 0.0).unwrap(),
            }
            let line = fail(&study, 2);
            assert!(line.contains(text(&reference)), "{line}");
            assert!(line.contains("delete this file"), "{line}");
        }
        std::fs::remove_file(&reference).unwrap();
        succeed(&study);
        assert!(std::fs::read(&reference).unwrap() == whole);
    }

    #[test]
    fn a_reference_that_knows_too_little_is_refused_where_something_is_to_be_proved() {
        let folder = tempfile::tempdir().unwrap();
        let plan = PLAN.replace("expect = \"biased\"", "");
        let plan = plan.replace("reference_spp = 64", "reference_spp = 4");
        let plan = write(folder.path(), &plan);
        let out = text(folder.path());
        let error = fail(&["study", "--plan", &plan, "-o", out], 2);
        assert!(error.contains("reference_spp of about"), "{error}");
        // A first look gets its table, if no proof.
        let mut quick = headwater(&["study", "--plan", &plan, "-o", out, "--quick"]);
        let output = quick.output().unwrap();
        let said = messages(output.stderr);
        assert!(output.status.success(), "{said}");
        assert!(said.contains("undecided"), "{said}");
        assert!(folder.path().join("results.json").exists());
    }

    #[test]
    fn a_study_keeps_a_reference_for_each_time() {
        let references = |settings: &str, scene: &str| {
            let folder = tempfile::tempdir().unwrap();
            let plan = PLAN
                .replace("seeds = 24", "seeds = 2")
                .replace("reference_spp = 64", "reference_spp = 2")
                .replace("\"cornell\"", scene);
            let plan = write(folder.path(), &format!("{settings}{plan}"));
            let said = succeed(&["study", "--plan", &plan, "-o", text(folder.path())]);
            let kept = std::fs::read_dir(folder.path().join("references")).unwrap();
            (kept.count(), said.contains("nothing in the scene moves"))
        };
        assert_eq!(references("fps = 4", "\"motion\""), (3, false));
        assert_eq!(references("start_time = 0.3", "\"motion\""), (1, false));
        assert_eq!(references("fps = 4", "\"cornell\""), (1, true));
    }

    #[test]
    fn too_few_seeds_are_no_bias_and_a_bias_is_a_failure() {
        let folder = tempfile::tempdir().unwrap();
        let study = |name: &str, expect: &str, seeds: u32| {
            let plan = format!(
                "scenes = [\"cornell\"]\nwidth = 24\nseeds = {seeds}\nmost_seeds = {seeds}\nreference_spp = 8192\n\
                 [[configurations]]\nname = \"a\"\npreset = \"{name}\"\n{expect}\n"
            );
            let plan = write(folder.path(), &plan);
            let out = folder.path().join("out");
            let output = headwater(&["study", "--plan", &plan, "-o", text(&out)])
                .output()
                .unwrap();
            let said = messages(output.stderr);
            let verdict = rows(&out)[0]["verdict"].as_str().unwrap().to_owned();
            (output.status.code(), verdict, said)
        };
        let (status, verdict, said) = study("accurate", "", 2);
        assert_eq!((status, verdict.as_str()), (Some(0), "undecided"), "{said}");
        assert!(
            said.contains("too few seeds for this proof: about"),
            "{said}"
        );
        assert!(said.contains("more, about "), "{said}");
        for (expect, code) in [
            ("expect = \"unbiased\"", 1),
            ("expect = \"any\"", 0),
            ("expect = \"biased\"", 0),
        ] {
            let visible = format!("set = {{ \"direct.visibility\" = \"none\" }}\n{expect}");
            let (status, verdict, said) = study("accurate", &visible, 32);
            assert_eq!((status, verdict.as_str()), (Some(code), "biased"), "{said}");
            assert_eq!(said.contains("should be unbiased"), code == 1, "{said}");
        }
        // Path tracing makes the references, so nothing is claimed of it unless it is said.
        let (status, verdict, said) = study("path-tracing", "", 2);
        assert_eq!((status, verdict.as_str()), (Some(0), "undecided"), "{said}");
        assert_eq!(said, "");
    }

    #[test]
    fn a_study_of_what_moves_goes_on_to_the_same_results() {
        let moving = PLAN.replace("\"cornell\"", "\"motion\"");
        stop_and_go_on(&format!("fps = 4\nstart_time = 0.25{moving}"));
    }

    /// A study continues with the runs of its first look (`--quick`); only the references of the two differ.
    #[test]
    fn a_study_goes_on_from_its_first_look() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let plan = write(folder.path(), &PLAN.replace("seeds = 24", "seeds = 8"));
        let study = ["study", "--plan", &plan, "-o", text(&out)];
        succeed(&[&study[..], &["--quick"]].concat());
        succeed(&study);
        assert!(rows(&out).iter().all(|row| row["replays"] == true));
    }
}
