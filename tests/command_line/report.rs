//! Tests of the times and the settings in reports.

use crate::{headwater, succeed, text};
use headwater::image::Image;
use std::path::Path;

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// The names of the timed passes in a report, in its order.
fn names(passes: &serde_json::Value) -> Vec<&str> {
    let passes = passes.as_array().unwrap().iter();
    passes.map(|pass| pass["name"].as_str().unwrap()).collect()
}

#[test]
fn settings_are_printed_as_they_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let [out, report] = ["a.exr", "a.json"].map(|name| folder.path().join(name));
    succeed(&[
        "reference",
        "cornell",
        "--width",
        "16",
        "--spp",
        "2",
        "--set",
        "roulette.floor=0.3",
        "-o",
        text(&out),
        "--report",
        text(&report),
    ]);
    let image = Image::read(&out).unwrap();
    let presets = crate::run(&["presets"]).stdout;
    for (said, number) in [
        (
            String::from_utf8(presets).unwrap(),
            "roulette.floor = 0.05 ",
        ),
        (
            std::fs::read_to_string(&report).unwrap(),
            "\"floor\": 0.3\n",
        ),
        (
            image.metadata["headwater.settings"].clone(),
            "\"floor\":0.3}",
        ),
    ] {
        assert!(said.contains(number), "{number}: {said}");
    }
    succeed(&[
        "reference",
        "cornell",
        "--width",
        "16",
        "--spp",
        "3",
        "--set",
        "roulette.floor=0.3",
        "-o",
        text(&out),
        "--resume",
    ]);
}

mod thorough {
    use super::*;

    /// `--verbose` prints what a scene requires of shaders and what its shaders leave out. The test also writes a sky as a
    /// file.
    #[test]
    fn verbose_runs_say_what_is_required_and_what_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let [out, sky] = ["a.png", "sky.exr"].map(|name| folder.path().join(name));
        let generated =
            headwater(&["scene", "generate", "sky:width=64", "-o", text(&sky)]).status();
        assert!(generated.unwrap().success());
        assert_eq!(Image::read(&sky).unwrap().height, 32);
        let mut arguments = vec!["render", "cornell", "--width", "16", "-o", text(&out)];
        arguments.extend(["--environment", text(&sky)]);
        let said = |more: &[&str]| {
            let output = headwater(&[&arguments[..], more].concat())
                .output()
                .unwrap();
            assert!(output.status.success());
            String::from_utf8(output.stderr).unwrap()
        };
        let quiet = said(&[]);
        assert!(!quiet.contains("required"), "{quiet}");
        let verbose = said(&["-v"]);
        let line = |begin: &str| verbose.lines().find(|line| line.contains(begin)).unwrap();
        let [required, left_out] = ["required: ", "left out: "].map(line);
        for (feature, is_required) in [
            ("environment", true),
            ("emissive triangles", true),
            ("specular lobes", false),
            ("motion", false),
        ] {
            assert_eq!(required.contains(feature), is_required, "{verbose}");
            assert_eq!(left_out.contains(feature), !is_required, "{verbose}");
        }
        assert!(line("passes ").contains("surfaces"), "{verbose}");
        let full = said(&["-v", "--set", "variant=full"]);
        assert!(
            full.contains("compiled all the same (variant=full)"),
            "{full}"
        );
    }

    /// Lavapipe compiles a pass when it runs for the first time, so a report must not count that time as time of a frame.
    #[test]
    fn first_runs_are_told_apart_from_frames() {
        let folder = tempfile::tempdir().unwrap();
        let [out, report] = ["a.exr", "a.json"].map(|name| folder.path().join(name));
        let cache = folder.path().join("cache");
        let render = |frames: &str, preset: &str| {
            let mut command = headwater(&[
                "render",
                "cornell",
                "--width",
                "16",
                "--preset",
                preset,
                "--frames",
                frames,
                "-o",
                text(&out),
                "--report",
                text(&report),
            ]);
            // Drivers that keep what they compiled would not compile it again.
            command.env("MESA_SHADER_CACHE_DIR", &cache);
            assert!(command.status().unwrap().success());
            json(&report)
        };
        let one = render("1", "accurate");
        assert!(names(&one["last_submission"]).is_empty(), "{one:#}");
        assert!(
            names(&one["first_runs"]).contains(&"initial_direct"),
            "{one:#}"
        );
        assert!(
            !names(&one["first_runs"]).contains(&"temporal_direct"),
            "{one:#}"
        );
        let four = render("4", "accurate");
        let frame = names(&four["last_submission"]);
        let mut first: Vec<&str> = names(&four["first_runs"]);
        assert!(frame.contains(&"temporal_direct"), "{four:#}");
        // Only the last frame is added to the sums, so this pass runs once.
        let last = first.pop();
        assert_eq!(last, Some("accumulate"), "{four:#}");
        first.sort_unstable();
        let mut sorted = frame.clone();
        sorted.sort_unstable();
        assert_eq!(first, sorted, "{four:#}");
        for passes in [&four["last_submission"], &four["first_runs"]] {
            let times = passes.as_array().unwrap().iter();
            assert!(times.clone().count() > 4);
            for pass in times {
                assert!(pass["milliseconds"].as_f64() >= Some(0.0), "{pass}");
            }
        }
        let path_traced = render("1", "path-tracing");
        assert_eq!(names(&path_traced["first_runs"]), ["path_trace"]);
    }
}
