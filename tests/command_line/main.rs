//! Tests of the command line: exit statuses, one-line errors, no partly written files, equal bits of pictures.

mod advise;
mod arguments;
mod cameras;
mod compare;
mod inputs;
mod limits;
mod messages;
mod moments;
mod needs;
mod outputs;
mod reference;
mod report;
mod resume;
mod signals;
mod study;
#[path = "../support/mod.rs"]
mod support;

use headwater::image::{Image, Samples};
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn headwater(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_headwater"));
    command.args(arguments).env_remove("HEADWATER_VALIDATION");
    command
}

/// A Headwater command with the validation layers on, which fails if they report a message.
fn validated(arguments: &[&str]) -> Command {
    let mut command = headwater(arguments);
    command.env("HEADWATER_VALIDATION", "1");
    command
}

fn run(arguments: &[&str]) -> Output {
    headwater(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The stderr of a command without its lines of progress. These appear after five seconds, so they depend on the speed of
/// the machine.
fn messages(stderr: Vec<u8>) -> String {
    let said = String::from_utf8(stderr).unwrap();
    let is_progress =
        |line: &str| line.contains(" after ") && (line.ends_with(" s") || line.ends_with(" left"));
    let lines = said.split_inclusive('\n');
    lines.filter(|line| !is_progress(line.trim_end())).collect()
}

/// Runs a command, asserts that it succeeds, and returns its stderr without progress.
fn succeed(arguments: &[&str]) -> String {
    succeeded(headwater(arguments))
}

fn succeeded(mut command: Command) -> String {
    let output = command.output().unwrap();
    let errors = messages(output.stderr);
    assert!(output.status.success(), "{command:?}: {errors}");
    errors
}

/// Runs a command, asserts its exit status and that stderr has exactly one line, and returns this line.
fn fail(arguments: &[&str], status: i32) -> String {
    let output = run(arguments);
    let errors = messages(output.stderr);
    assert_eq!(
        output.status.code(),
        Some(status),
        "{arguments:?}: {errors}"
    );
    assert_eq!(
        errors.trim_end().lines().count(),
        1,
        "{arguments:?}: {errors}"
    );
    assert!(!errors.contains("panicked"), "{errors}");
    errors
}

#[test]
fn wrong_arguments_are_one_line_and_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr");
    let out = text(&out);
    let settings = [
        ("roulete.start=1", "roulette.start"),
        ("roulette.floor=7", "0.001 to 1"),
        ("light_bvh.scale=0", "1e-9 to 1e9"),
        ("light_bvh.scale=big", "auto"),
        ("light_bvh.uniform_share=0", "0.01 to 1"),
        ("light_bvh.tile=65", "1 to 64"),
        ("hash_grid.cell=0", "1 to 1024"),
        ("hash_grid.bins=17", "1 to 16"),
        ("hash_grid.candidates=65537", "1 to 65536"),
        ("hash_grid.merged=0", "1 to 16"),
        ("world_reservoirs.cell=0", "1 to 4096"),
        ("world_reservoirs.cell=4097", "1 to 4096"),
        ("world_reservoirs.bins=17", "1 to 16"),
        ("world_reservoirs.jitter=17", "0 to 16"),
        ("world_reservoirs.confidence_cap=0", "1 to 500"),
        ("world_reservoirs.merged=17", "1 to 16"),
        ("world_reservoirs.table=0", "0.000000001 to 1000"),
        ("world_reservoirs.depth=0", "1 to 1000"),
    ]
    .map(|(set, said)| (vec!["render", "cornell", "-o", out, "--set", set], said));
    for (arguments, said) in [
        (vec!["render", "cornell"], "--output"),
        (
            vec!["render", "cornell", "-o", out, "--no-such-option"],
            "--no-such-option",
        ),
        (vec!["render", "cornel", "-o", out], "cornell"),
        (
            vec!["render", "no/such/file.glb", "-o", out],
            "no/such/file.glb",
        ),
        (
            vec![
                "render", "cornell", "-o", out, "--width", "100000", "--height", "100000",
            ],
            "10000000000 pixels",
        ),
        (
            vec!["render", "cornell", "-o", out, "--width", "0"],
            "no pixels",
        ),
        (
            vec!["render", "cornell", "-o", out, "--frames", "0"],
            "--frames 0",
        ),
        (
            vec!["render", "cornell", "-o", out, "--device", "no such device"],
            "no such device",
        ),
        (
            vec!["render", "cornell", "-o", out, "--camera", "7"],
            "no camera '7'",
        ),
        (
            vec!["render", "cornell", "-o", out, "--preset", "pathtracing"],
            "path-tracing",
        ),
        (
            vec!["render", "cornell", "-o", out, "--look-at", "1,2,3"],
            "EX,EY,EZ",
        ),
        (
            vec!["render", "cornell", "-o", out, "--look-at", "1,2,3,1,2,3"],
            "same point",
        ),
        (
            vec!["render", "cornell", "-o", out, "--look-at", "0,0,1,0,0,0,0"],
            "field of view",
        ),
        (
            vec![
                "render",
                "cornell",
                "-o",
                out,
                "--look-at",
                "1e39,0,0,0,0,0",
            ],
            "1e15",
        ),
        (vec!["render", "motion", "-o", out, "--fps", "0"], "--fps 0"),
        (
            vec!["render", "motion", "-o", out, "--fps", "-24"],
            "--fps -24",
        ),
        (
            vec!["render", "motion", "-o", out, "--fps", "NaN"],
            "positive and finite",
        ),
        (
            vec!["reference", "motion", "-o", out, "--start-time", "inf"],
            "--start-time",
        ),
        (vec!["render", "cornell", "-o", "a.gif"], ".exr or .png"),
        (vec!["reference", "cornell", "-o", "a.png"], ".exr"),
        (
            vec!["reference", "cornell", "-o", out, "--spp", "0"],
            "--spp 0",
        ),
        (
            vec!["reference", "cornell", "-o", out, "--target-error", "-1"],
            "positive",
        ),
        (vec!["scene", "generate", "terrain", "-o", "a.obj"], ".glb"),
        (vec!["presets", "fast-and-good"], "path-tracing"),
        (
            vec!["render", "cornell", "-o", out, "--spp", "4"],
            "'--spp' found; use --frames",
        ),
        (
            vec!["reference", "cornell", "-o", out, "--frames", "4"],
            "'--frames' found; use --spp",
        ),
        (
            vec![
                "render",
                "cornell",
                "-o",
                out,
                "--set",
                "direct.neighbors=3",
            ],
            "'direct.spatial.neighbours'",
        ),
        (
            [
                vec!["render", "cornell", "-o", out, "--width", "1024"],
                vec!["--height", "1024", "--preset", "accurate", "--bounces", "2"],
                vec!["--set", "indirect.secondary=world-reservoirs"],
                vec!["--set", "world_reservoirs.min_lights=0"],
                vec!["--set", "world_reservoirs.table=1000"],
            ]
            .concat(),
            "8594133016 bytes for its world_cells",
        ),
        (
            [
                vec!["render", "cornell", "-o", out, "--width", "8192"],
                vec!["--height", "8192", "--preset", "accurate", "--bounces", "9"],
                vec!["--set", "indirect.secondary=world-reservoirs"],
                vec!["--set", "world_reservoirs.min_lights=0"],
                vec!["--set", "world_reservoirs.depth=8"],
            ]
            .concat(),
            "536870912 path vertices are too many",
        ),
        (
            [
                vec!["render", "cornell", "-o", out, "--width", "1920"],
                vec!["--height", "1080", "--preset", "accurate", "--bounces", "1"],
                vec!["--set", "direct.candidates=light-bvh"],
                vec!["--set", "light_bvh.tile=2", "--set", "light_bvh.list=1024"],
            ]
            .concat(),
            "lower light_bvh.list, raise light_bvh.tile",
        ),
    ]
    .into_iter()
    .chain(settings)
    {
        let line = fail(&arguments, 2);
        assert!(line.contains(said), "{arguments:?}: {line}");
    }
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        0,
        "files were left"
    );
}

#[test]
fn what_cannot_be_written_is_status_1() {
    fail(&["render", "cornell", "-o", "no/such/folder/a.exr"], 1);
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.exr", "a.png"] {
        // The device on which every write finds the disk full.
        let out = folder.path().join(name);
        std::os::unix::fs::symlink("/dev/full", &out).unwrap();
        let line = fail(&["render", "cornell", "--width", "64", "-o", text(&out)], 1);
        assert!(line.contains("No space left"), "{line}");
    }
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        2,
        "files were left"
    );
}

#[test]
fn without_vulkan_it_says_so() {
    let nowhere = "/nowhere.json";
    let output = headwater(&["info"])
        .env("VK_DRIVER_FILES", nowhere)
        .env("VK_ICD_FILENAMES", nowhere)
        .env_remove("VK_ADD_DRIVER_FILES")
        .output()
        .unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("Vulkan"), "{errors}");
}

#[test]
fn assumptions_are_one_notice_and_status_0() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, out) = (folder.path().join("a.obj"), folder.path().join("a.exr"));
    std::fs::write(
        &mesh,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 1 2 2\n",
    )
    .unwrap();
    let said = succeed(&["render", text(&mesh), "-o", text(&out), "--width", "32"]);
    for part in ["no camera", "no light", "without area"] {
        assert_eq!(said.matches(part).count(), 1, "{part}: {said}");
    }
    // The neutral environment lights it; nothing is brighter than 1.1.
    let lit = |path: &Path| Image::read(path).unwrap().rgb().unwrap();
    let values = lit(&out);
    assert!(values.iter().flatten().all(|v| (0.1..1.2).contains(v)));
    let render = ["render", text(&mesh), "-o", text(&out), "--width", "32"];
    let said = succeed(&[&render[..], &["--environment", "none"]].concat());
    assert_eq!(said.matches("so the picture is black").count(), 1, "{said}");
    assert!(lit(&out).iter().flatten().all(|v| *v == 0.0));
    let said = succeed(&[&render[..], &["--environment", "neutral"]].concat());
    assert!(!said.contains("no light"), "{said}");
    assert_eq!(lit(&out), values);
}

#[test]
fn a_light_too_close_to_a_surface_is_one_notice() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, out) = (folder.path().join("a.obj"), folder.path().join("a.exr"));
    std::fs::write(
        folder.path().join("a.mtl"),
        "newmtl floor\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 1 1 1\n",
    )
    .unwrap();
    let floor = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nusemtl floor\nf 1 2 3 4\n";
    for (height, notices) in [(1e-6, 1), (1e-4, 0)] {
        let [low, high] = [-1.0, 1.0].map(|side| side * height);
        let emitter = format!(
            "v {low} {height} {low}\nv {high} {height} {low}\nv {high} {height} {high}\nusemtl lamp\nf 5 6 7\n"
        );
        std::fs::write(&mesh, format!("mtllib a.mtl\n{floor}{emitter}")).unwrap();
        let arguments = ["--look-at", "0,4,0.001,0,0,0", "--width", "16"];
        let said = succeed(&[&["render", text(&mesh), "-o", text(&out)], &arguments[..]].concat());
        assert_eq!(
            said.matches("close to a surface").count(),
            notices,
            "{said}"
        );
    }
}

#[test]
fn json_is_one_object_and_help_is_no_error() {
    for arguments in [
        vec!["info", "--json"],
        vec!["presets", "--json"],
        vec!["scene", "list", "--json"],
        vec!["scene", "inspect", "cornell", "--json"],
    ] {
        let output = run(&arguments);
        assert!(output.status.success());
        let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(value.is_object());
    }
    assert!(run(&["--help"]).status.success());
}

#[test]
fn shells_and_manuals_know_commands_and_options() {
    for shell in ["bash", "zsh", "fish"] {
        let output = run(&["completions", shell]);
        assert!(output.status.success());
        let said = String::from_utf8(output.stdout).unwrap();
        assert!(
            said.contains("accumulate") && said.contains("ray-query"),
            "{shell}"
        );
        // Nothing in it is escaped as the text of other commands is.
        assert!(!said.contains("\\u00"), "{shell}");
    }
    let folder = tempfile::tempdir().unwrap();
    succeed(&["man", "-o", text(folder.path())]);
    let page = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(page("headwater.1").contains("headwater\\-render"));
    assert!(page("headwater-render.1").contains("\\-\\-accumulate"));
    assert!(page("headwater-scene-generate.1").contains("\\-\\-set"));
    fail(&["man", "-o", text(&folder.path().join("none"))], 1);
}

#[test]
fn a_generated_scene_renders_with_every_aov() {
    let folder = tempfile::tempdir().unwrap();
    let (glb, exr, png, report) = (
        folder.path().join("a.glb"),
        folder.path().join("a.exr"),
        folder.path().join("a.png"),
        folder.path().join("a.json"),
    );
    succeed(&["scene", "generate", "cornell", "-o", text(&glb)]);
    succeeded(validated(&[
        "render",
        text(&glb),
        "-o",
        text(&exr),
        "-o",
        text(&png),
        "--width",
        "48",
        "--aov",
        "albedo,normal,depth,instance",
        "--report",
        text(&report),
    ]));
    let image = Image::read(&exr).unwrap();
    assert_eq!((image.width, image.height), (48, 48));
    for channel in ["R", "albedo.G", "normal.X", "normal.Z", "depth.Z"] {
        assert!(image.floats(channel).is_some(), "{channel}");
    }
    let Some(Samples::U32(ids)) = image.channels.get("instance.id") else {
        panic!("no instance ids");
    };
    assert!(ids.contains(&0) && ids.contains(&u32::MAX));
    // The floor lies at the bottom: row 0 is the top.
    let normals = image.floats("normal.Y").unwrap();
    assert!(normals[44 * 48 + 24] > 0.9, "{}", normals[44 * 48 + 24]);
    assert_eq!(Image::read(&png).unwrap().width, 48);
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(report).unwrap()).unwrap();
    assert_eq!(report["rejected_values"], 0);
    assert_eq!(report["rejected_by_pass"], serde_json::json!({}));
}

#[test]
fn reservoirs_are_shown_where_there_are_any() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr");
    let arguments = [
        "render",
        "motion",
        "-o",
        text(&out),
        "--width",
        "40",
        "--frames",
        "3",
        "--fps",
        "8",
        "--bounces",
        "1",
        "--aov",
        "direct",
    ];
    let path_traced = [&arguments[..], &["--preset", "path-tracing"]].concat();
    assert!(fail(&path_traced, 2).contains("--aov direct"));
    let no_light = arguments.map(|word| if word == "1" { "0" } else { word });
    assert!(fail(&no_light, 2).contains("--bounces of at least 1"));
    let direct_alone = [&arguments[..], &["--aov", "indirect"]].concat();
    assert!(fail(&direct_alone, 2).contains("--aov indirect"));
    succeeded(validated(
        &[
            &arguments[..],
            &["--preset", "accurate", "--set"],
            &[
                "direct.spatial.neighbours=2",
                "--set",
                "direct.spatial.neighbours_without_history=4",
            ],
        ]
        .concat(),
    ));
    let image = Image::read(&out).unwrap();
    let channels = image
        .channels
        .keys()
        .filter(|name| name.starts_with("direct."));
    assert_eq!(
        channels.collect::<Vec<_>>(),
        [
            "direct.age",
            "direct.confidence",
            "direct.jacobian",
            "direct.light",
            "direct.neighbours",
            "direct.source.X",
            "direct.source.Y",
            "direct.weight"
        ]
    );
    let most = |name: &str| {
        image
            .floats(name)
            .unwrap()
            .iter()
            .copied()
            .fold(0.0, f32::max)
    };
    // 4: surfaces that came into view in the last frame have more neighbours.
    assert_eq!((most("direct.age"), most("direct.neighbours")), (2.0, 4.0));
    let Some(Samples::U32(lights)) = image.channels.get("direct.light") else {
        panic!("no lights");
    };
    let weights = image.floats("direct.weight").unwrap();
    for (light, weight) in lights.iter().zip(weights) {
        assert_eq!(*light == u32::MAX, *weight == 0.0);
        assert!(*light == u32::MAX || *light < 102, "light {light}");
    }
}

#[test]
fn what_the_validation_layers_say_makes_a_command_fail() {
    let folder = tempfile::tempdir().unwrap();
    let shaders = folder.path().join("glsl");
    // A memory model that the device was not opened with, and that changes nothing.
    let (plain, other) = (
        "#version 460\n",
        "#version 460\n#pragma use_vulkan_memory_model\n",
    );
    support::planted(&shaders, &[("restir/passes/surfaces.comp", plain, other)]);
    let out = folder.path().join("a.exr");
    let mut command = validated(&["render", "cornell", "--width", "32", "-o", text(&out)]);
    let output = command.env("HEADWATER_GLSL", &shaders).output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    // A slow device says before how far it is.
    let last = errors.lines().last().unwrap_or_default();
    assert!(last.contains("validation layers"), "{errors}");
    assert!(last.contains("VulkanMemoryModel"), "{errors}");
}

/// Renders with a copy of the shaders in which `text` in `file` is replaced; path tracing does not include that file.
fn render_with_changed_shader(file: &str, text: &str, replacement: &str) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let shaders = folder.path().join("glsl");
    support::planted(&shaders, &[(file, text, replacement)]);
    let picture = folder.path().join("a.png");
    let picture = picture.to_str().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_headwater"));
    command.args(["render", "cornell", "--width", "8", "--frames", "1"]);
    command.args(["--preset", "path-tracing", "-o", picture]);
    command.env("HEADWATER_GLSL", &shaders).output().unwrap()
}

#[test]
fn the_pass_that_refuses_values_is_named() {
    let radiance = "                radiance = accept_radiance(radiance);";
    let negative = "                radiance = accept_radiance(vec3(-1.0));";
    let output = render_with_changed_shader("path_tracing/path_trace.comp", radiance, negative);
    let said = support::said(&output);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("note: pass path_trace: 64 values were refused because they were NaN"),
        "{said}"
    );
}

#[test]
fn changed_shaders_that_a_run_does_not_use_are_named() {
    let output = render_with_changed_shader("restir/shade.glsl", "#pragma once", "#pragma once\n");
    let errors = support::said(&output);
    assert!(output.status.success(), "{errors}");
    assert!(
        errors.contains("no pass of this run uses restir/shade.glsl"),
        "{errors}"
    );
    let output = render_with_changed_shader("core/math.glsl", "#pragma once", "#pragma once\n");
    assert!(
        !support::said(&output).contains("no pass"),
        "{}",
        support::said(&output)
    );
}

#[test]
fn shaders_that_a_run_does_not_use_must_compile() {
    let output = render_with_changed_shader("restir/shade.glsl", "void shade()", "void shade((");
    assert_eq!(output.status.code(), Some(2));
    let errors = support::said(&output);
    assert!(errors.contains("restir/shade.glsl"), "{errors}");
    assert_eq!(errors.lines().count(), 1, "{errors}");
}

#[test]
fn compare_measures_and_checks() {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["a.exr", "b.exr", "small.exr", "diff.png"].map(|n| folder.path().join(n));
    let [a, b, small, diff] = paths.each_ref().map(|p| text(p));
    for (path, value, side) in [(a, 0.5_f32, 16), (b, 0.4, 16), (small, 0.4, 8)] {
        let mut image = Image::new(side, side);
        image.set_vectors("", ["R", "G", "B"], &vec![[value; 3]; image.pixels()]);
        image.write(Path::new(path), 0.0).unwrap();
    }
    let output = run(&["compare", a, b, "--json", "--diff", diff]);
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!((value["rmse"].as_f64().unwrap() - 0.1).abs() < 1e-6);
    assert!((value["mean_ratio"].as_f64().unwrap() - 1.25).abs() < 1e-6);
    assert!(Path::new(diff).exists());
    assert!(fail(&["compare", a, b, "--max-rmse", "0.05"], 1).contains("rmse"));
    assert!(
        run(&["compare", a, b, "--max-rmse", "0.2"])
            .status
            .success()
    );
    assert!(fail(&["compare", a, small], 2).contains("8 × 8"));
    assert!(fail(&["compare", a, b, "--max-rmse", "NaN"], 2).contains("max-rmse"));
    assert!(fail(&["compare", a, "none.exr"], 2).contains("none.exr"));
}

#[test]
fn compare_refuses_damaged_pictures_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let good = folder.path().join("good.exr");
    let mut image = Image::new(40, 40);
    let values: Vec<[f32; 3]> = (0..1600).map(|i| [i as f32 * 1e-3; 3]).collect();
    image.set_vectors("", ["R", "G", "B"], &values);
    image.write(&good, 0.0).unwrap();
    for name in ["bad.exr", "bad.png"] {
        let bad = folder.path().join(name);
        image.write(&bad, 0.0).unwrap();
        let whole = std::fs::read(&bad).unwrap();
        for content in [
            &b""[..],
            b"no picture",
            &whole[..40],
            &whole[..whole.len() / 2],
        ] {
            std::fs::write(&bad, content).unwrap();
            for pair in [[text(&bad), text(&good)], [text(&good), text(&bad)]] {
                let line = fail(&["compare", pair[0], pair[1]], 2);
                assert!(line.contains(name), "{line}");
            }
        }
    }
}

#[test]
fn compare_minds_a_full_disk_but_no_closed_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut image = Image::new(4, 4);
    image.set_vectors("", ["R", "G", "B"], &[[0.5; 3]; 16]);
    image.write(&path, 0.0).unwrap();
    let compare = |stdout: Stdio| {
        headwater(&["compare", text(&path), text(&path)])
            .stdout(stdout)
            .stderr(Stdio::piped())
            .output()
            .unwrap()
    };
    let full = std::fs::File::options().write(true).open("/dev/full");
    let output = compare(full.unwrap().into());
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("No space left"), "{errors}");
    assert_eq!(errors.lines().count(), 1, "{errors}");
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = compare(writer.into());
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && errors.is_empty(), "{errors}");
}

mod thorough {
    use super::*;

    #[test]
    fn the_same_seed_gives_the_same_file_with_one_thread_and_with_all() {
        let folder = tempfile::tempdir().unwrap();
        let make = |name: &str, threads: Option<&str>, seed: &str| {
            let path = folder.path().join(name);
            let mut command = headwater(&[
                "render",
                "cornell-glossy",
                "-o",
                text(&path),
                "--width",
                "64",
                "--seed",
                seed,
                "--accumulate",
                "--frames",
                "3",
                "--jitter",
            ]);
            if let Some(threads) = threads {
                command
                    .env("LP_NUM_THREADS", threads)
                    .env("RAYON_NUM_THREADS", threads);
            }
            assert!(command.status().unwrap().success());
            std::fs::read(path).unwrap()
        };
        let all = make("all.exr", None, "5");
        assert!(all == make("again.exr", None, "5"), "two runs differ");
        assert!(all == make("one.exr", Some("1"), "5"), "one thread differs");
        assert!(all != make("other.exr", None, "6"), "the seed does nothing");
    }
}
