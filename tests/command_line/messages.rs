//! Tests of messages that quote a file: control characters are escaped, and each message is one line of limited length.

use crate::{fail, run, succeed, text};
use headwater::image::Image;
use std::path::Path;

/// The maximum number of characters of a line on stderr.
const MOST: usize = 500;

/// Writes a file with this content to a folder and returns its path.
fn file(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> String {
    let path = folder.join(name);
    std::fs::write(&path, content).unwrap();
    text(&path).to_owned()
}

/// Panics unless a text consists of printable characters and line breaks.
fn assert_printable(shown: &str) {
    let wrong = |c: &char| {
        (c.is_control() && *c != '\n')
            || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    assert_eq!(shown.chars().find(wrong), None, "{shown:?}");
}

/// Runs a command, asserts status 2 and one short printable line on stderr, and returns the line.
fn refused(arguments: &[&str]) -> String {
    let line = fail(arguments, 2);
    assert_printable(&line);
    assert!(line.trim_end().chars().count() <= MOST, "{line}");
    line
}

#[test]
fn what_a_picture_or_scene_contains_is_escaped() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let out = text(&folder.join("a.exr")).to_owned();
    for (format, said) in [
        (
            &b"\x1b[31mRED\x1b]0;title\x07\r"[..],
            r"\u{1b}[31mRED\u{1b}]0;title\u{7}",
        ),
        (&[0x9b, 0xff, 1, 2, b'\r'], r"\u{1}\u{2}"),
    ] {
        let bytes = [b"#?RADIANCE\nFORMAT=", format, b"\n\n-Y 8 +X 16\n"].concat();
        let sky = file(folder, "sky.hdr", bytes);
        let line = refused(&["render", "cornell", "-o", &out, "--environment", &sky]);
        assert!(line.contains(said), "{line}");
    }

    let mut layers = Image::new(1, 1);
    for layer in ["a\u{1b}[31m", "b\n"] {
        layers.set_vectors(&format!("{layer}."), ["R", "G", "B"], &[[0.5; 3]]);
    }
    let picture = folder.join("layers.exr");
    layers.write(&picture, 0.0).unwrap();
    // The first layer is compared, with a note that names it.
    let output = run(&["compare", text(&picture), text(&picture)]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    assert_printable(&said);
    assert!(said.contains("a\\u") && said.contains("[31m"), "{said}");

    // Names in plain text stay on their line; in JSON they remain what they are.
    let name = "a\n\u{1b}[31m\u{9b}\u{202e}";
    let scene = serde_json::json!({
        "asset": { "version": "2.0" },
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 }, "name": name }],
        "nodes": [{ "camera": 0, "name": name }],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    });
    let scene = file(folder, "\u{1b}[2Jscene\n.gltf", scene.to_string());
    let plain = run(&["scene", "inspect", &scene]);
    assert!(plain.status.success(), "{plain:?}");
    let plain = String::from_utf8(plain.stdout).unwrap();
    assert_printable(&plain);
    assert!(plain.contains(r"\u001b[2Jscene\n"), "{plain}");
    assert!(plain.contains(r"a\n\u001b[31m\u009b\u202e"), "{plain}");
    let json = run(&["scene", "inspect", &scene, "--json"]);
    let json = String::from_utf8(json.stdout).unwrap();
    assert_printable(&json);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["cameras"][0]["name"], name);
}

/// Notices have the length limit of errors; the output of `--json` has no limit.
#[test]
fn json_is_never_cut() {
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..200).map(|i| format!("camera {i}")).collect();
    let cameras = names.iter().map(|name| {
        let lens = serde_json::json!({ "yfov": 1, "znear": 0.1 });
        serde_json::json!({ "type": "perspective", "perspective": lens, "name": name })
    });
    let cameras: Vec<_> = cameras.collect();
    let nodes: Vec<_> = (0..200)
        .map(|i| serde_json::json!({ "camera": i }))
        .collect();
    let scene = serde_json::json!({
        "asset": { "version": "2.0" },
        "cameras": cameras,
        "nodes": nodes,
        "scenes": [{ "nodes": (0..200).collect::<Vec<_>>() }],
        "scene": 0,
    });
    let scene = file(folder.path(), "a.gltf", scene.to_string());
    let json = run(&["scene", "inspect", &scene, "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["cameras"].as_array().unwrap().len(), 200);
    let out = text(&folder.path().join("a.exr")).to_owned();
    let output = run(&["render", &scene, "-o", &out, "--camera", "no such camera"]);
    let said = String::from_utf8(output.stderr).unwrap();
    let line = said.lines().last().unwrap_or_default();
    assert!(line.contains("no such camera"), "{line}");
    assert!(line.contains('…') && line.chars().count() <= MOST, "{line}");
    let long = "x".repeat(5000);
    let line = refused(&["render", "cornell", "-o", &out, &format!("--{long}")]);
    assert!(line.contains("see 'headwater --help'"), "{line}");
    let said = succeed(
        &[
            &[
                "render",
                "cornell",
                "-o",
                &out,
                "--width",
                "8",
                "--look-at",
                "0,1,3,0,1,0",
            ],
            &["--camera", &long][..],
        ]
        .concat(),
    );
    assert!(
        said.contains('…') && said.trim_end().chars().count() <= MOST,
        "{said}"
    );
}

/// A scene whose contrast is beyond the tested range gives a notice; a scene close to the limit does not.
#[test]
fn limits_that_a_scene_passes_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let out = text(&folder.path().join("a.exr")).to_owned();
    for (contrast, is_past) in [("4e9", true), ("1e8", false)] {
        let scene = text(&folder.path().join("a.glb")).to_owned();
        let set = format!("contrast={contrast}");
        let generated = run(&[
            "scene",
            "generate",
            "divided-room",
            "-o",
            &scene,
            "--set",
            &set,
        ]);
        assert!(generated.status.success(), "{generated:?}");
        let inspected = run(&["scene", "inspect", &scene]).stdout;
        let inspected = String::from_utf8(inspected).unwrap();
        let line = inspected.lines().find(|line| line.contains("contrast: "));
        let key = if is_past {
            "past a limit"
        } else {
            "near a limit"
        };
        assert!(
            line.is_some_and(|line| line.starts_with(key)),
            "{inspected}"
        );
        let said = succeed(&["render", &scene, "-o", &out, "--width", "8"]);
        assert_eq!(said.contains("note: contrast: "), is_past, "{said}");
    }
}

/// A picture that is the mean of several moments of a moving scene gives a notice, because its blur is easily taken for
/// noise or for a fault; the mean of several frames of one moment gives none.
#[test]
fn a_mean_of_moments_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let out = text(&folder.path().join("a.exr")).to_owned();
    let still = [
        "render",
        "motion",
        "-o",
        &out,
        "--width",
        "8",
        "--frames",
        "2",
        "--accumulate",
    ];
    let said = succeed(&still);
    assert!(!said.contains("mean of"), "{said}");
    let said = succeed(&[&still[..], &["--fps", "4", "--start-time", "0.5"]].concat());
    let expected = "note: the picture is the mean of 2 moments of the scene, from 0.5 to 0.75 s,";
    assert!(said.contains(expected), "{said}");
}

mod thorough {
    use super::*;

    #[test]
    fn what_a_settings_file_or_plan_contains_is_escaped() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let out = text(&folder.join("a.exr")).to_owned();
        for (content, said) in [
            (
                "\"a\\u001b[31mb\\nc\" = 1",
                "unknown setting 'a\\u001b[31mb\\nc'",
            ),
            ("energy = \"\\u009b2J\\u202egltf\"", "\\u009b2J\\u202egltf"),
            ("in\u{ff}\0\0\u{1}\n = 1", "line 1, 'in"),
            ("\"\\u2028\\u007f\" = 1", "'\\u2028\\u007f'"),
        ] {
            let config = file(folder, "a.toml", content);
            let line = refused(&["render", "cornell", "-o", &out, "--config", &config]);
            assert!(line.contains(said), "{line}");
        }
        let config = file(folder, "a.toml", format!("{} = 1", "key".repeat(100_000)));
        let line = refused(&["render", "cornell", "-o", &out, "--config", &config]);
        assert!(line.contains("see 'headwater presets' for all"), "{line}");

        let studied = text(&folder.join("out")).to_owned();
        for content in [
            "width = 16\n[[sweeps]\u{7f}\0\u{c2}\u{80}\0",
            "scenes = [\"cornell\\u001b]0;title\\u0007\"]\n[[configurations]]\nname = \"a\"",
            "scenes = [\"cornell\"]\n[[configurations]]\nname = \"a\\nb\\u001b[2J\"\npreset = \"no\"",
        ] {
            let plan = file(folder, "plan.toml", content);
            refused(&["study", "--plan", &plan, "-o", &studied]);
        }
        let set = ["--set", "direct.mis=\u{1b}[31m\n"];
        refused(&[&["render", "cornell", "-o", &out], &set[..]].concat());
    }
}
