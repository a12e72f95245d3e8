//! Tests of output files: they are checked before any work, no two outputs may be the same file, and no unfinished file is
//! left.

use crate::{fail, succeed, text};
use headwater::image::Image;
use std::path::Path;

/// The name of a scene that does not exist. A command must refuse wrong outputs before it notices this.
const NO_SCENE: &str = "no-such-scene.glb";

/// All commands that write a file: each is the arguments, with the option that names the file last.
fn writers(folder: &Path) -> Vec<Vec<String>> {
    let good = |name: &str| text(&folder.join(name)).to_owned();
    let plan = "scenes = [\"cornell\"]\n[[configurations]]\nname = \"a\"\npreset = \"fast\"\n";
    std::fs::write(folder.join("plan.toml"), plan).unwrap();
    let a = good("a.exr");
    let commands: [(&[&str], &[&str]); 9] = [
        (&["render", NO_SCENE, "-o", &a], &["-o", "--report"]),
        (&["reference", NO_SCENE, "-o", &a], &["-o", "--report"]),
        (&["render", NO_SCENE], &["-o"]),
        (&["reference", NO_SCENE], &["-o"]),
        (&["profile", NO_SCENE], &["-o", "--trace"]),
        (&["compare", "no-a.exr", "no-b.exr"], &["--diff"]),
        (&["scene", "generate", "cornell"], &["-o"]),
        (&["regress", "no-golden-frames"], &["--junit"]),
        (&["statistics", NO_SCENE], &["-o"]),
    ];
    let with = |command: &[&str], option: &str| -> Vec<String> {
        let words = command.iter().copied().chain([option]);
        words.map(String::from).collect()
    };
    let all = commands.into_iter();
    all.flat_map(|(command, options)| options.iter().map(move |option| with(command, option)))
        .collect()
}

/// The file name ending that the last option of the arguments requires.
fn ending(arguments: &[String]) -> &'static str {
    match (
        arguments[0].as_str(),
        arguments[arguments.len() - 1].as_str(),
    ) {
        ("scene", _) => "glb",
        ("profile" | "statistics", _) | (_, "--report") => "json",
        (_, "--junit") => "xml",
        _ => "exr",
    }
}

#[test]
fn every_output_is_checked_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for arguments in writers(folder) {
        let ending = ending(&arguments);
        let directory = folder.join(format!("folder.{ending}"));
        std::fs::create_dir_all(&directory).unwrap();
        for wrong in [
            directory,
            // Where not even root can create files.
            format!("/proc/a.{ending}").into(),
            folder.join(format!("no/such/folder/a.{ending}")),
            folder.join(format!("{}.{ending}", "x".repeat(300))),
            folder.join(format!("plan.toml/a.{ending}")),
        ] {
            let mut arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            arguments.push(text(&wrong));
            let line = fail(&arguments, 1);
            assert!(line.contains("cannot write"), "{arguments:?}: {line}");
            assert!(!line.contains(".headwater-"), "{arguments:?}: {line}");
        }
    }
    // A study finds it before its first frame too.
    let out = folder.join("out");
    std::fs::create_dir_all(out.join("results.csv")).unwrap();
    let plan = folder.join("plan.toml");
    let line = fail(&["study", "--plan", text(&plan), "-o", text(&out)], 1);
    assert!(line.contains("results.csv"), "{line}");
    for (name, in_way) in [("golden", "golden"), ("golden/inner", "golden")] {
        std::fs::write(folder.join(in_way), "").unwrap();
        let line = fail(&["regress", text(&folder.join(name)), "--bless"], 1);
        assert!(line.contains("it is a file; name a folder"), "{line}");
    }
}

#[test]
fn every_folder_for_outputs_is_checked_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("file"), "").unwrap();
    let golden = at("golden");
    std::fs::create_dir_all(golden.join("driver")).unwrap();
    let list = r#"{"version": 2, "device": "a", "driver": "a", "commit": "a", "cases": {}}"#;
    std::fs::write(golden.join("driver/golden.json"), list).unwrap();
    let (a, golden) = (at("a.exr"), text(&golden));
    let (a, file) = (text(&a), at("file"));
    for wrong in [file.clone(), file.join("inner"), "/proc/a".into()] {
        let wrong = text(&wrong);
        let capture = ["--capture", "0..0", "--presented", wrong];
        for arguments in [
            &["regress", golden, "-o", wrong][..],
            &[&["render", NO_SCENE, "-o", a], &capture[..]].concat(),
        ] {
            let line = fail(arguments, 1);
            assert!(line.contains("cannot write"), "{arguments:?}: {line}");
        }
    }
}

#[test]
fn no_output_overwrites_another_file_of_the_same_command() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    let (a, profile) = (at("a.exr"), at("a.json"));
    for arguments in [
        vec!["render", "cornell", "-o", &a, "-o", &a],
        vec!["render", "cornell", "-o", &a, "--report", &a],
        vec!["reference", "cornell", "-o", &a, "--environment", &a],
        vec!["profile", "cornell", "-o", &profile, "--trace", &profile],
        vec!["profile", "cornell", "-o", &profile, "--against", &profile],
        vec!["compare", &a, "b.exr", "--diff", &a],
    ] {
        let line = fail(&arguments, 2);
        assert!(
            line.contains("overwritten") || line.contains("twice"),
            "{line}"
        );
    }
}

#[test]
fn no_file_of_a_sequence_overwrites_an_input() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    let (sky, all) = (at("sky_3.exr"), at("sky_%d.exr"));
    std::fs::write(&sky, "a sky").unwrap();
    let render = |frames: &str| {
        fail(
            &[
                "render",
                "cornell",
                "--environment",
                &sky,
                "-o",
                &all,
                "--frames",
                frames,
            ],
            2,
        )
    };
    assert!(render("4").contains("overwritten"), "{}", render("4"));
    assert!(!render("3").contains("overwritten"), "{}", render("3"));
    assert_eq!(std::fs::read(&sky).unwrap(), b"a sky");
}

/// A temporary file that a killed program has left must not disturb a later run, which removes it.
#[test]
fn a_file_is_written_beside_what_a_killed_program_left() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr");
    let arguments = ["render", "cornell", "--width", "8", "-o", text(&out)];
    succeed(&arguments);
    let picture = std::fs::read(&out).unwrap();
    // The name under which a complete file waits for its place.
    let hash = blake3::hash(b"a.exr").to_hex();
    let left = folder.path().join(format!(".headwater-{}", &hash[..16]));
    std::fs::write(&left, "half").unwrap();
    std::fs::write(&out, "old").unwrap();
    succeed(&arguments);
    assert!(std::fs::read(&out).unwrap() == picture);
    assert!(!left.exists());
}

/// Each file of a sequence is what `render` writes for as many frames, and a name without a pattern gets the last one.
#[test]
fn a_sequence_has_one_file_per_frame() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let read = |name: &str| Image::read(Path::new(&file(name))).unwrap().rgb().unwrap();
    for mean in [&[][..], &["--accumulate"]] {
        let render = |frames: &str, output: &[&str]| {
            let scene = ["render", "cornell", "--width", "16", "--frames", frames];
            succeed(&[&scene, mean, output].concat())
        };
        let (all, last) = (file("frame_%03d.exr"), file("last.exr"));
        render("3", &["-o", &all, "-o", &last]);
        let one = file("one.exr");
        for (frames, name) in [
            ("1", "frame_000.exr"),
            ("2", "frame_001.exr"),
            ("3", "frame_002.exr"),
        ] {
            render(frames, &["-o", &one]);
            assert_eq!(read(name), read("one.exr"), "{name} {mean:?}");
        }
        assert_eq!(read("last.exr"), read("frame_002.exr"));
        assert!(!folder.path().join("frame_003.exr").exists());
    }
}

/// Without a curve, a PNG file shows each value as sRGB, and clamps what is above 1.
#[test]
fn a_png_can_do_without_a_tone_curve() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let read = |name: &str| Image::read(Path::new(&file(name))).unwrap().rgb().unwrap();
    let (exr, png) = (file("a.exr"), file("a.png"));
    let render = [
        "render",
        "cornell",
        "--width",
        "32",
        "--exposure",
        "1",
        "-o",
        &exr,
        "-o",
        &png,
    ];
    succeed(&[&render[..], &["--tonemap", "none"]].concat());
    let mut clamped = 0;
    let (radiance, shown) = (read("a.exr"), read("a.png"));
    for (radiance, shown) in radiance.iter().flatten().zip(shown.iter().flatten()) {
        let expected = (2.0 * radiance).min(1.0);
        // Half a step of 8 bits, where the encoding is steepest in linear values.
        assert!((shown - expected).abs() < 0.005, "{shown} {expected}");
        clamped += u32::from(2.0 * radiance > 1.1);
    }
    assert!(clamped > 10, "{clamped}");
    succeed(&render);
    assert!(read("a.png") != shown);
}
