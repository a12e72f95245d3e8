//! Tests of `--resume` with files whose metadata or sums are wrong.

use crate::support::planted;
use crate::{fail, headwater, succeed, text};
use headwater::image::{Image, Samples};
use std::path::Path;

const ARGUMENTS: [&str; 8] = [
    "reference",
    "cornell",
    "--width",
    "16",
    "--bounces",
    "1",
    "--spp",
    "6",
];

/// A change that makes a valid file invalid, and a text that the error message must contain.
type Damage = (fn(&mut Image), &'static str);

fn channel<'a>(image: &'a mut Image, name: &str) -> &'a mut Vec<f32> {
    match image.channels.get_mut(name) {
        Some(Samples::F32(values)) => values,
        _ => panic!("no {name}"),
    }
}

fn set(image: &mut Image, key: &str, value: &str) {
    image.metadata.insert(key.into(), value.into());
}

/// A change that sets one value of the channel `$name` to `$value`.
macro_rules! pixel {
    ($name:expr, $value:expr) => {
        |image| channel(image, $name)[17] = $value
    };
}

macro_rules! metadata {
    ($key:expr, $value:expr) => {
        |image| set(image, $key, $value)
    };
}

const DAMAGE: [Damage; 33] = [
    (metadata!("headwater.samples", "-1"), "'-1', not 1 to"),
    (metadata!("headwater.samples", "0"), "'0', not 1 to"),
    (metadata!("headwater.samples", "NaN"), "'NaN', not 1 to"),
    (metadata!("headwater.samples", "6.5"), "'6.5', not 1 to"),
    (
        metadata!("headwater.samples", "18446744073709551616"),
        "'18446744073709551616'",
    ),
    (
        metadata!("headwater.samples", "6\u{1b}[31m\n"),
        "'6\\u001b[31m\\n'",
    ),
    (metadata!("headwater.samples", "1"), "of 1 samples"),
    (
        |image| drop(image.metadata.remove("headwater.samples")),
        "no headwater.samples",
    ),
    (|image| image.metadata.clear(), "it has no headwater."),
    (metadata!("headwater.seed", "7"), "headwater.seed was '7'"),
    (
        metadata!("headwater.scene", "another"),
        "headwater.scene was 'another'",
    ),
    (metadata!("headwater.device", "another"), "headwater.device"),
    (metadata!("headwater.driver", "another"), "headwater.driver"),
    (
        metadata!("headwater.settings", "{\"energy\":\"compensated\"}"),
        "headwater.settings",
    ),
    (
        metadata!("headwater.settings", "no JSON"),
        "headwater.settings",
    ),
    (metadata!("headwater.settings", "0"), "headwater.settings"),
    (
        |image| set(image, "headwater.settings", &"x\n\u{1b}".repeat(4000)),
        "headwater.settings",
    ),
    (
        |image| set(image, "headwater.settings", &"[".repeat(4000)),
        "headwater.settings",
    ),
    (
        |image| drop(image.channels.remove("resume.sum.G")),
        "no channel resume.sum.G",
    ),
    (
        |image| {
            image
                .channels
                .retain(|name, _| !name.starts_with("resume."))
        },
        "no channel resume.",
    ),
    (
        |image| {
            let pixels = image.pixels();
            let values = Samples::U32(vec![1; pixels]);
            image.channels.insert("resume.square.B".into(), values);
        },
        "no channel resume.square.B",
    ),
    (
        |image| {
            (image.width, image.height) = (image.width / 2, image.height * 2);
        },
        "it is 8 × 32",
    ),
    (pixel!("resume.sum.R", f32::NAN), "pixel 1, 1"),
    (pixel!("resume.sum.G", f32::INFINITY), "pixel 1, 1"),
    (pixel!("resume.sum.B", -1.0), "pixel 1, 1"),
    (pixel!("resume.sum.B", 1e30), "pixel 1, 1"),
    (pixel!("resume.sum_low.R", f32::NAN), "pixel 1, 1"),
    (pixel!("resume.sum_low.R", -1e9), "pixel 1, 1"),
    (pixel!("resume.square.R", f32::NEG_INFINITY), "pixel 1, 1"),
    (pixel!("resume.square.R", -1.0), "pixel 1, 1"),
    (pixel!("resume.square_low.G", f32::NAN), "pixel 1, 1"),
    (pixel!("resume.square_low.G", 1e9), "pixel 1, 1"),
    (
        |image| channel(image, "resume.square.G").fill(0.0),
        "of 6 samples",
    ),
];

#[test]
fn sums_of_other_shaders_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let glsl = folder.path().join("glsl");
    planted(&glsl, &[]);
    let arguments = [&ARGUMENTS[..], &["-o", text(&path)]].concat();
    let resume = [&arguments[..], &["--resume"]].concat();
    let edited = |arguments: &[&str]| {
        let mut command = headwater(arguments);
        command.env("HEADWATER_GLSL", &glsl).output().unwrap()
    };
    succeed(&arguments);
    let output = edited(&resume);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("it has no headwater.shaders"), "{said}");
    assert!(edited(&arguments).status.success());
    let line = fail(&resume, 2);
    assert!(line.contains("it has headwater.shaders"), "{line}");
    assert!(edited(&resume).status.success());
}

#[test]
fn a_file_that_lies_is_refused_in_one_readable_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let arguments = [&ARGUMENTS[..], &["-o", text(&path)]].concat();
    succeed(&arguments);
    let good = Image::read(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let resume = [&arguments[..], &["--resume"]].concat();
    for (damage, said) in DAMAGE {
        let mut image = good.clone();
        damage(&mut image);
        image.write(&path, 0.0).unwrap();
        let before = std::fs::read(&path).unwrap();
        let line = fail(&resume, 2);
        assert!(line.contains(said), "no '{said}' in {line}");
        assert!(line.contains("start again without --resume"), "{line}");
        assert!(line.trim_end().chars().count() <= 500, "{line}");
        assert!(!line.trim_end().chars().any(char::is_control), "{line:?}");
        assert!(std::fs::read(&path).unwrap() == before, "{said}");
    }
    std::fs::write(&path, &whole).unwrap();
    succeed(&resume);
    assert!(std::fs::read(&path).unwrap() == whole);
}

#[test]
fn a_picture_with_alpha_is_resumed_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole.exr", "parts.exr"].map(|name| folder.path().join(name));
    // From so far away, the box is a few pixels wide.
    let scene = [
        "reference",
        "cornell",
        "--look-at=0,1,12,0,1,0",
        "--width=16",
        "--alpha",
    ];
    let run = |path: &Path, more: &[&str]| {
        succeed(&[&scene[..], &["-o", text(path), "--spp"], more].concat());
        Image::read(path).unwrap()
    };
    let expected = run(&whole, &["7"]);
    run(&parts, &["3"]);
    let image = run(&parts, &["7", "--resume"]);
    assert_eq!(image, expected);
    let alpha = image.floats("A").unwrap();
    assert!(alpha.iter().any(|a| *a > 0.0 && *a < 1.0), "{alpha:?}");
    let refused = |more: &[&str]| {
        let rest = ["-o", text(&parts), "--spp", "9", "--resume"];
        fail(&[&scene[..4], more, &rest].concat(), 2)
    };
    let line = refused(&[]);
    assert!(line.contains("it has headwater.alpha"), "{line}");
    for (value, said) in [(None, "no channel A"), (Some(1.5), "channel A has values")] {
        let mut image = expected.clone();
        match value {
            None => drop(image.channels.remove("A")),
            Some(value) => channel(&mut image, "A")[3] = value,
        }
        image.write(&parts, 0.0).unwrap();
        let line = refused(&["--alpha"]);
        assert!(line.contains(said), "no '{said}' in {line}");
    }
}

/// An EXR file whose header has a size that its channels do not have must be refused.
#[test]
fn a_header_of_another_size_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let arguments = [&ARGUMENTS[..], &["-o", text(&path)]].concat();
    succeed(&arguments);
    let good = std::fs::read(&path).unwrap();
    for (right, bottom) in [(15, 7), (7, 15), (31, 31), (i32::MAX, i32::MAX), (-1, -1)] {
        let mut bad = good.clone();
        resize(&mut bad, right, bottom);
        std::fs::write(&path, &bad).unwrap();
        let line = fail(&[&arguments[..], &["--resume"]].concat(), 2);
        assert!(line.contains("cannot resume"), "{line}");
    }
}

/// Sets the last column and the last row of the data window in the bytes of an EXR file.
fn resize(exr: &mut [u8], right: i32, bottom: i32) {
    let name = b"dataWindow\0box2i\0";
    let found = exr.windows(name.len()).position(|w| w == name).unwrap();
    let at = found + name.len() + 4 + 8;
    exr[at..at + 4].copy_from_slice(&right.to_le_bytes());
    exr[at + 4..at + 8].copy_from_slice(&bottom.to_le_bytes());
}

/// The file of another command cannot be resumed and must be refused.
#[test]
fn a_picture_that_cannot_be_resumed_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path: &Path = &folder.path().join("a.exr");
    let mut image = Image::new(16, 16);
    image.set_vectors("", ["R", "G", "B"], &[[0.5; 3]; 256]);
    image.write(path, 0.0).unwrap();
    let line = fail(
        &[&ARGUMENTS[..], &["-o", text(path), "--resume"]].concat(),
        2,
    );
    assert!(line.contains("it has no headwater."), "{line}");
}
