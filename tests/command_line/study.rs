//! `study`: plans that make no sense, and work that is stopped and goes on.

use super::{fail, headwater, succeed, text, validated};
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

#[test]
fn a_study_of_what_moves_goes_on_to_the_same_results() {
    let moving = PLAN.replace("\"cornell\"", "\"motion\"");
    stop_and_go_on(&format!("fps = 4\nstart_time = 0.25{moving}"));
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
    let rays = |row: &serde_json::Value| row[4][0]["rays"].as_u64();
    assert!(rows.iter().all(|row| rays(row) > Some(0)), "{rows:?}");
    let csv = std::fs::read_to_string(parts.join("results.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 2 * 3, "{csv}");
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
    assert_eq!(quick.output().unwrap().status.code(), Some(1));
    assert!(folder.path().join("results.json").exists());
}
