//! Tests of the command `study`: wrong plans, and studies that are stopped and continued.

mod pages;

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
        ("\"cornell\"", "\"cornell\", \"cornell\"", "is there twice"),
        ("reference_spp = 64", "reference_spp = 9000000", "4194304"),
        ("frames = 3", "frames = 90000", "65536"),
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
        // What is known stands in the tables.
        assert!(
            rows(&parts)
                .iter()
                .any(|row| row["seeds"].as_u64() > Some(0))
        );
        let [page] = pages::pages(&parts).try_into().unwrap();
        let known = page["points"].as_array().unwrap().len();
        assert!(known > 0 && pages::pictures(&page) == known, "{known}");
    }
    let kept = std::fs::read_to_string(&runs).unwrap();

    let output = headwater(&["study", "--plan", &plan, "-o", text(&parts)])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(std::fs::read_to_string(&runs).unwrap().starts_with(&kept));
    // Times differ; results do not.
    for name in ["results.json", "results.csv", "schema.json"] {
        let [whole, parts] = [&whole, &parts].map(|folder| std::fs::read(folder.join(name)));
        assert!(whole.unwrap() == parts.unwrap(), "{name}");
    }
    let rows = rows(&whole);
    let rays = |row: &serde_json::Value| row["counts"][0]["rays"].as_u64();
    assert!(rows.iter().all(|row| rays(row) > Some(0)), "{rows:?}");
    assert!(rows.iter().all(|row| row["replays"] == true), "{rows:?}");
    // The first seeds' first frames compiled; no row's time holds that.
    for row in self::table(&whole, "times.json") {
        let names = |key: &str| -> Vec<String> {
            let passes = row[key].as_array().unwrap().iter();
            let mut names: Vec<String> = passes.map(|p| p[0].to_string()).collect();
            names.sort_unstable();
            names
        };
        assert_eq!(names("first_runs"), names("milliseconds"), "{row:#}");
    }
    let csv = std::fs::read_to_string(parts.join("results.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 2 * 24 * 3, "{csv}");
}

/// A glTF scene of one triangle that emits no light, with its positions embedded.
const BLACK: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;

/// The rows of a study's results, as JSON.
fn rows(folder: &Path) -> Vec<serde_json::Value> {
    table(folder, "results.json")
}

/// The rows of a JSON file of a study.
fn table(folder: &Path, name: &str) -> Vec<serde_json::Value> {
    let json = std::fs::read_to_string(folder.join(name)).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    json["rows"].as_array().unwrap().clone()
}

#[test]
fn shards_merge_to_the_whole_study() {
    let plan = PLAN
        .replace("seeds = 24", "seeds = 4")
        .replace("frames = 3", "frames = 2");
    merge_three_shards(&plan);
}

/// Three shards, of which one is killed and started again, give the results of the whole study, to the last byte.
fn merge_three_shards(plan: &str) {
    let folder = tempfile::tempdir().unwrap();
    let plan = write(folder.path(), plan);
    let whole = folder.path().join("whole");
    let study = |out: &Path, more: &[&str]| {
        let arguments = [&["study", "--plan", &plan, "-o", text(out)], more].concat();
        headwater(&arguments)
    };
    assert!(study(&whole, &[]).output().unwrap().status.success());
    let shards = ["1/3", "2/3", "3/3"].map(|shard| (shard, folder.path().join(&shard[..1])));
    let mut killed = study(&shards[1].1, &["--shard", "2/3"]).spawn().unwrap();
    let began = Instant::now();
    let runs = shards[1].1.join("runs.jsonl");
    let has_runs = || runs.metadata().is_ok_and(|about| about.len() > 0);
    while !has_runs() && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(2));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    let merged = folder.path().join("merged");
    let merge = |folders: &[&Path]| {
        let mut arguments = vec!["study", "merge", "-o", text(&merged)];
        arguments.extend(folders.iter().map(|folder| text(folder)));
        headwater(&arguments).output().unwrap()
    };
    for (shard, out) in &shards {
        let output = study(out, &["--shard", shard]).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        if *shard == "2/3" {
            let output = merge(&[&shards[0].1, out]);
            let said = messages(output.stderr);
            assert!(output.status.success(), "{said}");
            assert!(said.contains("1 of 3 shards and "), "{said}");
        }
    }
    let all = [&shards[0].1, &shards[1].1, &shards[2].1];
    let output = merge(&all.map(|folder| folder.as_path()));
    assert!(output.status.success(), "{output:?}");
    for name in ["results.json", "results.csv", "schema.json"] {
        let [whole, merged] = [&whole, &merged].map(|folder| std::fs::read(folder.join(name)));
        assert!(whole.unwrap() == merged.unwrap(), "{name}");
    }
    for page in pages::pages(&merged) {
        assert_eq!(pages::pictures(&page), 2);
    }

    for (folders, said) in [
        (vec![&whole, &whole], "are the same shard"),
        (vec![&shards[0].1, &whole], "different numbers of shards"),
        (vec![&folder.path().join("none")], "has no study"),
    ] {
        let folders: Vec<&Path> = folders.into_iter().map(|folder| folder.as_path()).collect();
        let output = merge(&folders);
        let line = messages(output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(line.contains(said), "{line}");
    }
    let other = study(&shards[0].1, &["--shard", "2/3"]).output().unwrap();
    let line = messages(other.stderr);
    assert_eq!(other.status.code(), Some(2), "{line}");
    assert!(line.contains("has the shard 1/3 of a study"), "{line}");
}

#[test]
fn another_plan_does_not_replace_the_results_of_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let plan = |name: &str| {
        format!(
            "scenes = [\"cornell\"]\nwidth = 16\nseeds = 2\nreference_spp = 4\n[[configurations]]\nname = \"{name}\"\npreset = \"path-tracing\"\n"
        )
    };
    let first = write(folder.path(), &plan("a"));
    succeed(&["study", "--plan", &first, "-o", text(&out)]);
    let kept = std::fs::read(out.join("results.json")).unwrap();
    let other = write(folder.path(), &plan("b"));
    let line = fail(&["study", "--plan", &other, "-o", text(&out)], 2);
    assert!(
        line.contains("has the results of other scenes or configurations"),
        "{line}"
    );
    assert_eq!(std::fs::read(out.join("results.json")).unwrap(), kept);
}

#[test]
fn plans_are_listed_with_their_questions() {
    let output = headwater(&["study", "--list"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let list = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = list.lines().collect();
    assert!(lines.len() > 40 && lines.len().is_multiple_of(2), "{list}");
    for plan in lines.chunks(2) {
        assert!(plan[0].contains(": ") && plan[0].len() > 30, "{plan:?}");
        assert!(plan[1].contains(" runs, about "), "{plan:?}");
    }
}

/// Emission alone and a black scene have no noise: the study must not raise an alarm or divide by 0.
#[test]
fn a_study_without_noise_has_neither_alarms_nor_infinite_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let black = folder.path().join("black.gltf");
    std::fs::write(&black, BLACK).unwrap();
    for (scene, bounces) in [("cornell", 0), ("night-city", 0), (text(&black), 1)] {
        let plan = format!(
            "scenes = [{{ scene = {scene:?}, environment = \"none\" }}]\nwidth = 24\nframes = 2\nseeds = 4\nbounces = {bounces}\nreference_spp = 1000\n\
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
    use std::collections::BTreeSet;

    /// The work that depends on the results of all shards (a better reference, more seeds, controls, fresh seeds) gives the
    /// same bytes too.
    #[test]
    fn shards_of_a_proof_merge_to_the_whole_proof() {
        let plan = PLAN
            .replace("seeds = 24\nmost_seeds = 24", "seeds = 4\nmost_seeds = 12")
            .replace("reference_spp = 64", "reference_spp = 16")
            .replace("frames = 3", "frames = 2")
            .replacen("expect = \"biased\"", "expect = \"unbiased\"", 1);
        merge_three_shards(&plan);
    }

    /// However a study ends, its tables are complete files, and what it has finished is not rendered again.
    #[test]
    fn a_study_that_is_killed_again_and_again_leaves_tables_and_repeats_no_run() {
        let folder = tempfile::tempdir().unwrap();
        let plan = write(folder.path(), &PLAN.replace("frames = 3", "frames = 8"));
        let out = folder.path().join("out");
        let study = || headwater(&["study", "--plan", &plan, "-o", text(&out)]);
        let mut finished = false;
        for attempt in 0..10 {
            let mut child = study()
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            let began = Instant::now();
            while !out.join("index.html").exists() && began.elapsed() < Duration::from_secs(60) {
                std::thread::sleep(Duration::from_millis(2));
            }
            // Moments from the start of the process until several runs are finished.
            std::thread::sleep(Duration::from_millis(37 * attempt * attempt));
            child.kill().unwrap();
            finished |= child.wait().unwrap().success();
            assert_eq!(rows(&out).len(), 2, "attempt {attempt}");
            // Each page is a complete file.
            pages::pages(&out);
            for name in ["results.csv", "times.csv"] {
                let table = std::fs::read_to_string(out.join(name)).unwrap();
                assert!(
                    table.starts_with("scene,") && table.ends_with('\n'),
                    "{table}"
                );
            }
        }
        println!("finished before a kill: {finished}");
        assert!(study().output().unwrap().status.success());
        assert!(rows(&out).iter().all(|row| row["seeds"] == 24));
        let runs = std::fs::read_to_string(out.join("runs.jsonl")).unwrap();
        let mut seen = BTreeSet::new();
        for line in runs.lines() {
            let run: serde_json::Value = serde_json::from_str(line).unwrap();
            let key = (run["key"].to_string(), run["seed"].as_u64());
            assert!(seen.insert(key), "rendered twice: {}", run["seed"]);
        }
    }

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
    fn a_reference_that_knows_too_little_leaves_the_row_undecided() {
        let folder = tempfile::tempdir().unwrap();
        let plan = PLAN
            .replace("expect = \"biased\"", "")
            .replace("reference_spp = 64", "reference_spp = 8");
        let plan = write(folder.path(), &plan);
        let out = text(folder.path());
        let output = headwater(&["study", "--plan", &plan, "-o", out]).output();
        let output = output.unwrap();
        let said = messages(output.stderr);
        assert!(said.contains("raise reference_spp to about"), "{said}");
        let rows = rows(folder.path());
        let accurate = &rows[0];
        assert_eq!(accurate["verdict"], "undecided", "{accurate:#}");
        // It got four times the samples of the plan before that.
        assert_eq!(accurate["reference_spp"], 32, "{accurate:#}");
        let wanted = accurate["wanted_reference_spp"].as_f64().unwrap();
        assert!(wanted > 32.0, "{wanted}");
        // The number holds.
        let plan = write(
            folder.path(),
            &std::fs::read_to_string(&plan)
                .unwrap()
                .replace("reference_spp = 8", &format!("reference_spp = {wanted}")),
        );
        let enough = folder.path().join("enough");
        let study = ["study", "--plan", &plan, "-o", text(&enough)];
        let output = headwater(&study).output().unwrap();
        let said = messages(output.stderr);
        assert!(!said.contains("raise reference_spp"), "{said}");
    }

    #[test]
    fn a_study_keeps_a_reference_for_each_time() {
        let references = |settings: &str, scene: &str| {
            let folder = tempfile::tempdir().unwrap();
            let plan = PLAN
                .replace("seeds = 24", "seeds = 2")
                .replace("reference_spp = 64", "reference_spp = 4")
                .replace("\"cornell\"", scene);
            let plan = write(folder.path(), &format!("{settings}{plan}"));
            let said = succeed(&["study", "--plan", &plan, "-o", text(folder.path())]);
            let kept = std::fs::read_dir(folder.path().join("references")).unwrap();
            (kept.count(), said.contains("nothing in the scene moves"))
        };
        // Each reference of four samples has two blocks.
        assert_eq!(references("fps = 4", "\"motion\""), (6, false));
        assert_eq!(references("start_time = 0.3", "\"motion\""), (2, false));
        assert_eq!(references("fps = 4", "\"cornell\""), (2, true));
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

    /// A study continues with the runs and the blocks of references of its first look (`--quick`).
    #[test]
    fn a_study_goes_on_from_its_first_look() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let plan = write(folder.path(), &PLAN.replace("seeds = 24", "seeds = 8"));
        let study = ["study", "--plan", &plan, "-o", text(&out)];
        succeed(&[&study[..], &["--quick"]].concat());
        let first = std::fs::read(out.join("runs.jsonl")).unwrap();
        succeed(&study);
        assert!(rows(&out).iter().all(|row| row["replays"] == true));
        let all = std::fs::read(out.join("runs.jsonl")).unwrap();
        assert!(all.starts_with(&first));
        let lines = all.iter().filter(|byte| **byte == b'\n').count();
        // Of each configuration eight runs, one to repeat and one to count.
        assert_eq!(lines, 2 * 10);
    }
}
