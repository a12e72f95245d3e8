//! Tests that capture tools see the frames that Headwater presents, and replay the same pictures.
//!
//! `tools/capture-tools` makes the tools, and `tools/test --all` lets the tests use them. Otherwise the tests check only the
//! commands without tools.

mod support;

use image::ImageReader;
use std::path::Path;
use std::process::{Command, Output};
use support::{said, takes_largest};

fn assert_succeeded(what: &str, output: &Output) {
    assert!(output.status.success(), "{what}: {}", said(output));
}

/// Captures the frames `range` of `cornell` with a tool to `file`; the presented pictures are written to `folder`.
fn capture(tool: &str, folder: &Path, file: &str, range: &str) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    Command::new(root.join("tools/capture"))
        .arg(tool)
        .arg(folder.join(file))
        .args(["render", "cornell", "--width", "320", "--height", "180"])
        .args(["--frames", "3", "--capture", range, "-o"])
        .arg(folder.join("last.png"))
        .arg("--presented")
        .arg(folder)
        // Both layers would be in each other's way.
        .env_remove("HEADWATER_VALIDATION")
        .output()
        .unwrap()
}

/// True if the driver is too old to present to a headless surface. The version of Mesa decides, since Headwater's own
/// decision is under test.
fn cannot_present() -> bool {
    let output = Command::new(env!("CARGO_BIN_EXE_headwater"))
        .arg("info")
        .output()
        .unwrap();
    assert_succeeded("info", &output);
    said(&output).contains("llvmpipe Mesa 22.")
}

/// Runs a shell command in `folder`, in the environment that `tools/capture-tools` prints, which finds the capture tools.
fn with_tools(command: &str, folder: &Path) -> Output {
    let tools = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/capture-tools");
    Command::new("bash")
        .args([
            "-ec",
            &format!("environment=$(\"$0\"); eval \"$environment\"; {command}"),
        ])
        .arg(tools)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn picture(path: &Path) -> image::RgbImage {
    let reader = ImageReader::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    reader.decode().unwrap().to_rgb8()
}

/// The pixels of an uncompressed bitmap of 24 or 32 bits, as GFXReconstruct writes it: rows from the bottom, blue first.
fn bitmap(path: &Path) -> image::RgbImage {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let word = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let (start, width, height) = (word(10) as usize, word(18) as usize, word(22));
    let step = usize::from(bytes[28]) / 8;
    let stride = (width * step).next_multiple_of(4);
    let rows = height.unsigned_abs() as usize;
    image::RgbImage::from_fn(width as u32, rows as u32, |x, y| {
        let row = if height > 0 {
            rows - 1 - y as usize
        } else {
            y as usize
        };
        let at = start + row * stride + x as usize * step;
        image::Rgb([bytes[at + 2], bytes[at + 1], bytes[at]])
    })
}

#[test]
fn without_a_tool_nothing_is_captured() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_headwater"))
            .args(["render", "cornell", "--width", "16", "-o"])
            .arg(&picture)
            .args(arguments)
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), said)
    };
    for (arguments, status, expected) in [
        (
            &["--capture", "0..0"][..],
            2,
            "tools/capture starts Headwater with one of them",
        ),
        (
            &["--frames", "3", "--capture", "1..3"],
            2,
            "ends with frame 2",
        ),
        (&["--capture", "1..0"], 2, "both included"),
        (&["--presented", "."], 2, "--capture"),
        (
            &["--capture", "0..0", "--presented", "/no/folder"],
            1,
            "/no/folder",
        ),
    ] {
        let (code, said) = run(arguments);
        assert_eq!(code, Some(status), "{said}");
        assert!(
            said.contains(expected) && said.lines().count() == 1,
            "{said}"
        );
        assert!(!picture.exists());
    }
}

/// A capture of all frames, and one that begins later and contains what it needs of earlier frames, must replay the same
/// pictures.
#[test]
fn gfxreconstruct_replays_the_same_pictures() {
    if !takes_largest() {
        return;
    }
    let refused = cannot_present();
    for (range, frames) in [("0..2", 0..3), ("1..2", 1..3)] {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let output = capture("gfxreconstruct", folder, "trace.gfxr", range);
        if refused {
            assert_eq!(output.status.code(), Some(1));
            assert!(
                said(&output).contains("no VK_EXT_headless_surface"),
                "{}",
                said(&output)
            );
            assert!(!folder.join("trace.gfxr").exists());
            continue;
        }
        assert_succeeded("gfxreconstruct", &output);
        let printed = String::from_utf8(output.stdout).unwrap();
        assert_eq!(
            printed.trim_end(),
            folder.join("trace.gfxr").to_str().unwrap()
        );
        let bytes = folder.join("trace.gfxr").metadata().unwrap().len();
        println!("frames {range}: {bytes} bytes");
        assert!(bytes <= 25_000_000, "{bytes} bytes");
        let output = with_tools(
            "gfxrecon-replay --wsi headless --screenshot-all trace.gfxr",
            folder,
        );
        assert_succeeded("replay", &output);
        for (replayed, frame) in frames.enumerate() {
            let presented = picture(&folder.join(format!("frame_{frame:04}.png")));
            let shown = bitmap(&folder.join(format!("screenshot_frame_{}.bmp", replayed + 1)));
            assert_eq!(presented.dimensions(), (320, 180));
            assert!(
                presented == shown,
                "frame {frame} of {range} is another picture"
            );
            assert!(
                presented.pixels().any(|pixel| pixel.0[0] > 200),
                "it is dark"
            );
        }
        let last = picture(&folder.join("last.png"));
        let presented = picture(&folder.join("frame_0002.png"));
        // The device rounds powers otherwise than the CPU.
        let apart = last
            .iter()
            .zip(presented.iter())
            .map(|(a, b)| a.abs_diff(*b))
            .max();
        assert!(apart <= Some(1), "{apart:?}");
    }
}

/// A captured frame must show the names of its passes and buffers.
#[test]
fn renderdoc_shows_passes_and_buffers() {
    if !takes_largest() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let output = capture("renderdoc", folder, "a.rdc", "1..2");
    assert_succeeded("renderdoc", &output);
    for file in ["a_frame1.rdc", "a_frame2.rdc"] {
        let output = with_tools(
            &format!("renderdoccmd convert -f {file} -o a.xml -c xml"),
            folder,
        );
        assert_succeeded("convert", &output);
        let text = std::fs::read_to_string(folder.join("a.xml")).unwrap();
        let mut passes = Vec::new();
        let mut names = Vec::new();
        for line in text.lines() {
            let inside = |list: &mut Vec<String>| {
                let value = line
                    .split_once('>')
                    .and_then(|(_, rest)| rest.split_once('<'));
                list.extend(value.map(|(value, _)| value.to_owned()));
            };
            if line.contains("\"pLabelName\"") {
                inside(&mut passes);
            }
            if line.contains("\"ObjectName\"") || line.contains("\"pObjectName\"") {
                inside(&mut names);
            }
        }
        println!("{file}: passes {passes:?}, objects {names:?}");
        let frame = file.trim_start_matches("a_frame").trim_end_matches(".rdc");
        let frame = format!("frame {frame}");
        for pass in [
            &frame,
            "surfaces",
            "initial_direct",
            "spatial_indirect",
            "tone_map",
        ] {
            assert!(passes.iter().any(|name| name == pass), "{pass}: {passes:?}");
        }
        for buffer in ["sample_data", "reservoirs", "color", "display", "materials"] {
            assert!(
                names.iter().any(|name| name == buffer),
                "{buffer}: {names:?}"
            );
        }
    }
}
