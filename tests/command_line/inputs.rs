//! Tests of inputs that are not regular files, such as pipes and devices: commands refuse them at once.

use crate::{fail, headwater, succeed, text};
use std::ffi::CString;
use std::path::Path;
use std::process::Command;

fn make_pipe(path: &Path) {
    let name = CString::new(text(path)).unwrap();
    // SAFETY: the name ends with a zero byte.
    assert_eq!(unsafe { libc::mkfifo(name.as_ptr(), 0o600) }, 0);
}

#[test]
fn pipes_folders_and_devices_are_refused_as_every_input() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let out = at("out.exr");
    let out = text(&out);
    succeed(&[
        "scene",
        "generate",
        "sky:width=64",
        "-o",
        text(&at("a.exr")),
    ]);
    let good = at("a.exr");
    let render = ["render", "cornell", "--width", "8", "-o", out];
    for (name, kind) in [
        ("pipe", "a pipe"),
        ("folder", "a folder"),
        ("device", "a device"),
    ] {
        let make = |file: &str| {
            let path = at(&format!("{name}.{file}"));
            match name {
                "pipe" => make_pipe(&path),
                "folder" => std::fs::create_dir(&path).unwrap(),
                _ => std::os::unix::fs::symlink("/dev/zero", &path).unwrap(),
            }
            path
        };
        let [glb, gltf, obj, exr, hdr, png, toml, json] =
            ["glb", "gltf", "obj", "exr", "hdr", "png", "toml", "json"].map(make);
        for scene in [&glb, &gltf, &obj] {
            check(&["scene", "inspect", text(scene)], kind);
            check(&["render", text(scene), "-o", out], kind);
            check(&["study", text(scene), "-o", text(&at("study"))], kind);
        }
        for sky in [&exr, &hdr] {
            check(&[&render[..], &["--environment", text(sky)]].concat(), kind);
        }
        check(&[&render[..], &["--config", text(&toml)]].concat(), kind);
        check(
            &["study", "--plan", text(&toml), "-o", text(&at("study"))],
            kind,
        );
        for picture in [&exr, &png] {
            check(&["compare", text(picture), text(&good)], kind);
            check(&["compare", text(&good), text(picture)], kind);
        }
        for command in [["profile", "cornell"], ["statistics", "furnace"]] {
            check(&[&command[..], &["--against", text(&json)]].concat(), kind);
        }
        if name == "pipe" {
            check(
                &["reference", "cornell", "-o", text(&exr), "--resume"],
                kind,
            );
        }
        assert!(!at("study").exists() && !Path::new(out).exists());
    }
}

/// Asserts that a command refuses its input in one line that names its kind, without waiting for the input.
fn check(arguments: &[&str], kind: &str) {
    let line = fail(arguments, 2);
    assert!(line.contains(kind), "{arguments:?}: {line}");
}

#[test]
fn a_process_substitution_is_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new("bash")
        .arg("-c")
        .arg("exec \"$0\" render cornell -o a.png --config <(echo 'direct.reuse = \"none\"')")
        .arg(headwater(&[]).get_program())
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("a pipe, and only plain files"), "{said}");
}
