//! Tests of combinations of arguments: a combination that would overwrite a file is refused, a wrong one is explained, and
//! one without effect gives a notice.

use crate::{fail, headwater, messages, run, succeed, succeeded, text};
use headwater::image::Image;
use std::path::Path;

fn grey(path: &Path) {
    let mut image = Image::new(8, 8);
    image.set_vectors("", ["R", "G", "B"], &[[0.5; 3]; 64]);
    image.write(path, 0.0).unwrap();
}

#[test]
fn no_file_has_two_purposes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    let [a, b, link, config] = ["a.exr", "b.exr", "link.exr", "c.toml"].map(at);
    let detour = at("./a.exr");
    std::fs::write(&config, "energy = \"gltf\"\n").unwrap();
    grey(Path::new(&a));
    std::os::unix::fs::symlink(&a, &link).unwrap();
    let before = std::fs::read(&a).unwrap();
    let render = ["render", "cornell", "--width", "16", "-o", &a];
    for (more, said) in [
        (vec!["-o", &a], "twice"),
        (vec!["-o", &b, "-o", &detour], "one file"),
        (vec!["--report", &a], "--output and --report"),
        (vec!["--report", &link], "one file"),
        (vec!["--config", &config, "--report", &config], "--config"),
    ] {
        for command in [&render[..], &[&["reference"], &render[1..]].concat()] {
            let line = fail(&[command, &more].concat(), 2);
            assert!(line.contains(said), "{more:?}: {line}");
        }
    }
    let other = at("other.exr");
    grey(Path::new(&other));
    for [picture, reference] in [[&a, &other], [&other, &a]] {
        for diff in [&a, &link, &detour] {
            let line = fail(&["compare", picture, reference, "--diff", diff], 2);
            assert!(line.contains("overwritten"), "{line}");
        }
    }
    assert!(
        std::fs::read(&a).unwrap() == before,
        "the file was overwritten"
    );
    assert!(!Path::new(&b).exists());
    // A procedural scene is no file, and none that has its name is read.
    let mut command = headwater(&["render", "cornell", "--width", "16", "-o", "a.exr"]);
    command.args(["--report", "cornell"]);
    command.current_dir(folder.path());
    succeeded(command);
    let scene = at("scene.glb");
    succeed(&["scene", "generate", "cornell", "-o", &scene]);
    let line = fail(&["render", &scene, "-o", &a, "--report", &scene], 2);
    assert!(line.contains("the scene"), "{line}");
    // Devices are no files.
    succeed(&[&render[..], &["-o", &b, "--report", "/dev/null"]].concat());
}

#[test]
fn a_negative_number_is_told_what_it_may_be() {
    for (command, option) in [
        ("render", "--width"),
        ("render", "--height"),
        ("render", "--seed"),
        ("render", "--bounces"),
        ("render", "--frames"),
        ("reference", "--spp"),
    ] {
        let line = fail(&[command, "cornell", "-o", "a.exr", option, "-5"], 2);
        assert!(
            line.contains(option) && line.contains("-5 is not in 0..") && !line.contains("tip"),
            "{line}"
        );
    }
    let line = fail(&["render", "cornell", "-o", "a.exr", "--camera", "-1"], 2);
    assert!(line.contains("no camera '-1'"), "{line}");
}

#[test]
fn a_wrong_key_names_its_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let [config, plan, out] = ["c.toml", "p.toml", "out"].map(|n| folder.path().join(n));
    let render = [
        "render",
        "cornell",
        "-o",
        "a.exr",
        "--config",
        text(&config),
    ];
    for (content, said) in [
        (
            "[direct]\nmiss = 1\n",
            "c.toml, line 2, 'miss = 1': unknown setting 'direct.miss'",
        ),
        (
            "# floors\n\nroulette.floor = 7\n",
            "c.toml, line 3, 'roulette.floor = 7': setting roulette.floor=7",
        ),
    ] {
        std::fs::write(&config, content).unwrap();
        let line = fail(&render, 2);
        assert!(line.contains(said), "{line}");
    }
    let study = ["study", "--plan", text(&plan), "-o", text(&out)];
    let right = "scenes = [\"cornell\"]\n[[configurations]]\nname = \"a\"\npreset = \"fast\"\n";
    for (wrong, said) in [
        ("set = { \"direct.miss\" = 1 }", "p.toml, line 5, 'set"),
        (
            "[configurations.set.direct]\nmiss = 1",
            "p.toml, line 6, 'miss",
        ),
        (
            "[[configurations]]\nname = \"b\"\npreset = \"fats\"",
            "p.toml, line 7, 'preset",
        ),
        (
            "[[sweeps]]\npreset = \"fast\"\n[sweeps.over]\n\"direct.miss\" = [1]",
            "p.toml, line 8, '\"direct.miss",
        ),
        (
            "set = { \"indirect.mis\" = \"balance\" }",
            "p.toml, line 5, 'set",
        ),
        ("seed = 3", "p.toml, line 5, 'seed = 3': unknown field"),
        ("scenes = [\"garage\"]", "p.toml: a configuration is for"),
    ] {
        std::fs::write(&plan, format!("{right}{wrong}\n")).unwrap();
        let line = fail(&study, 2);
        assert!(line.contains(said), "{wrong}: {line}");
    }
    assert!(!out.exists(), "a refused study left a folder");
}

#[test]
fn resuming_names_the_setting_that_differs() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr");
    let arguments = ["reference", "cornell", "--width", "16", "-o", text(&out)];
    succeed(&[&arguments[..], &["--spp", "2"]].concat());
    let other = ["--resume", "--set", "roulette.start=7"];
    let line = fail(&[&arguments[..], &other].concat(), 2);
    assert!(line.contains("roulette.start was 3 and is now 7"), "{line}");
    assert!(!line.contains("floor"), "{line}");
}

#[test]
fn without_a_command_there_is_help() {
    for (arguments, listed) in [(&[][..], "presets"), (&["scene"], "generate")] {
        let output = run(arguments);
        let help = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && output.stderr.is_empty());
        assert!(help.contains("Usage:") && help.contains(listed), "{help}");
    }
}

#[test]
fn a_path_is_named_once() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, status) in [
        (["render", "LOCATION/a.glb", "-o", "a.exr"], 2),
        (["render", "LOCATION/a.gltf", "-o", "a.exr"], 2),
        (["render", "LOCATION/a.obj", "-o", "a.exr"], 2),
        (["render", "cornell", "-o", "LOCATION/a.exr"], 1),
        (["scene", "generate", "cornell", "-oLOCATION/a.glb"], 1),
        (["study", "--plan", "LOCATION/a.toml", "-oout"], 2),
    ] {
        let location = folder.path().join("no");
        let given = arguments.map(|word| word.replace("LOCATION", text(&location)));
        let line = fail(&given.each_ref().map(String::as_str), status);
        assert_eq!(line.matches(text(&location)).count(), 1, "{line}");
    }
}

#[test]
fn the_help_of_reference_offers_what_it_takes() {
    let help = |command: &str| String::from_utf8(run(&[command, "--help"]).stdout).unwrap();
    let reference = help("reference");
    for not_taken in [
        "--preset",
        "- direct:",
        "- indirect:",
        "- motion:",
        "--fps",
        "--accumulate",
    ] {
        assert!(!reference.contains(not_taken), "{not_taken}: {reference}");
    }
    for taken in ["--spp", "--resume", "--config", "- albedo:", "- instance:"] {
        assert!(reference.contains(taken), "{taken}: {reference}");
    }
    for taken in [
        "--preset",
        "balanced",
        "- direct:",
        "- indirect:",
        "- motion:",
    ] {
        assert!(help("render").contains(taken), "{taken}");
    }
    for aov in ["direct", "motion"] {
        let line = fail(&["reference", "cornell", "-o", "a.exr", "--aov", aov], 2);
        assert!(line.contains("albedo"), "{line}");
    }
}

#[test]
fn environments_are_checked_and_light_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    let picture = at("a.exr");
    let render = |environment: &str, more: &[&str]| {
        let first = [
            "render",
            "cornell",
            "--width",
            "16",
            "-o",
            &picture,
            "--preset",
            "path-tracing",
        ];
        let named = ["--environment", environment];
        [&first[..], &named, more]
            .concat()
            .iter()
            .map(|a| (*a).to_owned())
            .collect::<Vec<_>>()
    };
    for (environment, said) in [
        ("sky:sum=40", "sun"),
        ("sky:sun=400", "0 to 90"),
        ("nowhere.exr", "nowhere.exr"),
        ("Cargo.toml", ".exr or .hdr"),
    ] {
        let arguments = render(environment, &[]);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let line = fail(&arguments, 2);
        assert!(line.contains(said), "{line}");
    }
    let own = at("sky.exr");
    grey(Path::new(&own));
    let arguments = render(&own, &["--report", &own]);
    let line = fail(&arguments.iter().map(String::as_str).collect::<Vec<_>>(), 2);
    assert!(line.contains("--environment"), "{line}");
    // Through the open front of the room, and behind it.
    let mean = |more: &[&str]| {
        let arguments = render("sky:sun=40", more);
        succeed(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        let rgb = Image::read(Path::new(&picture)).unwrap().rgb().unwrap();
        rgb.iter().flatten().sum::<f32>() / rgb.len() as f32
    };
    let dark = mean(&["--set", "environment.intensity=0"]);
    let lit = mean(&[]);
    let turned = mean(&["--set", "environment.rotation=120"]);
    assert!(
        lit > 1.02 * dark && (turned - lit).abs() > 1e-3 * lit,
        "{dark} {lit} {turned}"
    );
    // Without an environment its settings have no effect.
    let line = messages(
        run(&[
            "render",
            "cornell",
            "--width",
            "16",
            "-o",
            &picture,
            "--set",
            "environment.rotation=3",
        ])
        .stderr,
    );
    assert!(
        line.contains("environment.rotation has no effect"),
        "{line}"
    );
}

mod thorough {
    use super::*;

    #[test]
    fn what_has_no_effect_is_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let [exr, png] = ["a.exr", "a.png"].map(|name| text(&folder.path().join(name)).to_owned());
        let look_at = "0,1,3,0,1,0";
        for (command, more, said) in [
            (
                "render",
                vec!["--camera", "0", "--look-at", look_at, "-o", &exr],
                "--camera 0 has no effect",
            ),
            (
                "render",
                vec![
                    "--preset",
                    "path-tracing",
                    "--set",
                    "direct.mis=balance",
                    "-o",
                    &exr,
                ],
                "direct.mis has no effect",
            ),
            (
                "render",
                vec![
                    "--bounces",
                    "1",
                    "--set",
                    "indirect.mis=balance",
                    "--set",
                    "indirect.reuse=none",
                    "-o",
                    &exr,
                ],
                "indirect.mis, indirect.reuse have no effect",
            ),
            (
                "render",
                vec![
                    "--set",
                    "indirect.mode=path",
                    "--set",
                    "indirect.secondary=ris",
                    "--set",
                    "indirect.shift=biased",
                    "--set",
                    "indirect.temporal.confidence_cap=3",
                    "-o",
                    &exr,
                ],
                "indirect.mode=path does not resample, so indirect.shift, indirect.temporal.confidence_cap have no effect",
            ),
            (
                "render",
                vec![
                    "--set",
                    "indirect.mode=off",
                    "--set",
                    "indirect.secondary=ris",
                    "-o",
                    &exr,
                ],
                "indirect.mode=off has no indirect light, so indirect.secondary has no effect",
            ),
            (
                "render",
                vec!["--aov", "albedo", "-o", &png],
                "no --output is an .exr file",
            ),
            (
                "render",
                vec!["--exposure", "1", "-o", &exr],
                "no --output is a .png file",
            ),
            (
                "render",
                vec!["--set", "world_reservoirs.cell=8", "-o", &exr],
                "no indirect.secondary=world-reservoirs, so world_reservoirs.cell has no effect",
            ),
            (
                "render",
                [
                    vec!["--set", "direct.candidates=light-bvh", "-o", &exr],
                    vec!["--set", "light_bvh.boxes=visibility"],
                ]
                .concat(),
                "light_bvh.boxes has no effect",
            ),
            (
                "render",
                [
                    vec!["--set", "direct.candidates=hash-grid", "-o", &exr],
                    vec!["--set", "hash_grid.cells=16", "--set", "hash_grid.cell=8"],
                ]
                .concat(),
                "hash_grid.mode=unbiased measures cells in pixels, so hash_grid.cells has no effect",
            ),
            (
                "render",
                vec!["--set", "indirect.candidates=hash-grid", "-o", &exr],
                "indirect.candidates=hash-grid draws by power",
            ),
            (
                "render",
                vec!["--textures", "images", "-o", &exr],
                "--textures images has no effect",
            ),
            (
                "reference",
                vec!["--spp", "2", "--preset", "accurate", "-o", &exr],
                "--preset accurate",
            ),
            (
                "reference",
                vec!["--spp", "2", "--set", "direct.mis=balance", "-o", &exr],
                "direct.mis has no effect",
            ),
        ] {
            let arguments = [&[command, "cornell", "--width", "16"], &more[..]].concat();
            let lines = succeed(&arguments);
            assert_eq!(lines.lines().count(), 1, "{arguments:?}: {lines}");
            assert!(lines.contains(said), "{arguments:?}: {lines}");
        }
        for more in [
            vec!["--aov", "albedo", "--exposure", "1", "-o", &exr, "-o", &png],
            vec!["--set", "direct.mis=balance", "-o", &exr],
            vec!["--set", "indirect.mode=off", "-o", &exr],
            vec!["--set", "integrator=path-tracing", "-o", &exr],
            vec!["--set", "light_bvh.tile=8", "-o", &exr],
            vec![
                "--set",
                "indirect.mode=path",
                "--set",
                "indirect.light_samples=2",
                "-o",
                &exr,
            ],
            vec!["--look-at", look_at, "-o", &exr],
        ] {
            let arguments = [&["render", "cornell", "--width", "16"], &more[..]].concat();
            assert_eq!(succeed(&arguments), "", "{arguments:?}");
        }
    }
}

#[test]
fn material_variants_are_listed_and_chosen_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("shoe.gltf");
    let variants = serde_json::json!([{ "name": "day" }, { "name": "by night" }]);
    let document = serde_json::json!({
        "asset": { "version": "2.0" },
        "extensionsRequired": ["KHR_materials_variants"],
        "extensions": { "KHR_materials_variants": { "variants": variants } },
    });
    std::fs::write(&scene, document.to_string()).unwrap();
    let inspect = ["scene", "inspect", text(&scene), "--material-variant"];
    let listed = run(&[&inspect[..], &["by night", "--json"]].concat());
    let listed: serde_json::Value = serde_json::from_slice(&listed.stdout).unwrap();
    assert_eq!(
        listed["material_variants"],
        serde_json::json!(["day", "by night"])
    );
    let line = fail(&[&inspect[..], &["dusk"]].concat(), 2);
    assert!(
        line.contains(r#""dusk"; choose one of "day", "by night""#),
        "{line}"
    );
}
