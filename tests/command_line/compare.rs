//! Tests of the command `compare` with pictures of other programs.

use crate::{fail, run, text};
use headwater::image::{Image, Samples};
use std::path::Path;

/// Writes an EXR picture whose channels, of these names, all have the value `value`.
fn grey(path: &Path, channels: &[&str], value: f32) {
    let mut image = Image::new(8, 8);
    for name in channels {
        let samples = Samples::F32(vec![value; 64]);
        image.channels.insert((*name).to_owned(), samples);
    }
    image.write(path, 0.0).unwrap();
}

/// The stderr of `compare` for two pictures that differ by one half.
fn compared(a: &Path, b: &Path) -> String {
    let output = run(&["compare", text(a), text(b), "--json"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(value["rmse"], 0.5, "{value}");
    said
}

#[test]
fn layers_and_grey_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let [plain, other] = ["plain.exr", "other.exr"].map(|name| folder.path().join(name));
    grey(&plain, &["R", "G", "B"], 0.25);
    for (channels, said) in [
        (&["R", "G", "B", "A", "Z"][..], ""),
        (
            &[
                "ViewLayer.Combined.A",
                "ViewLayer.Combined.B",
                "ViewLayer.Combined.G",
                "ViewLayer.Combined.R",
                "ViewLayer.Depth.Z",
            ],
            "its picture is the layer ViewLayer.Combined",
        ),
        (&["Y"], "its picture is grey"),
    ] {
        grey(&other, channels, 0.75);
        let said = match said {
            "" => String::new(),
            said => format!("headwater: note: {}: {said}\n", text(&other)),
        };
        assert_eq!(compared(&other, &plain), said, "{channels:?}");
        assert_eq!(compared(&plain, &other), said, "{channels:?}");
    }
    grey(&other, &["Depth.Z", "Normal.X"], 0.75);
    let line = fail(&["compare", text(&plain), text(&other)], 2);
    assert!(line.contains("Depth.Z, Normal.X"), "{line}");
}

#[test]
fn a_png_beside_an_exr_is_said_to_be_of_another_kind() {
    let folder = tempfile::tempdir().unwrap();
    let [exr, png] = ["a.exr", "a.png"].map(|name| folder.path().join(name));
    for path in [&exr, &png] {
        grey(path, &["R", "G", "B"], 0.25);
    }
    for [a, b] in [[&exr, &png], [&png, &exr]] {
        let output = run(&["compare", text(a), text(b)]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(
            said.contains("a.png has 8 bits") && said.contains("linear"),
            "{said}"
        );
    }
    for path in [&exr, &png] {
        let output = run(&["compare", text(path), text(path)]);
        assert!(output.status.success() && output.stderr.is_empty());
    }
}

#[test]
fn exposure_is_printed_as_it_was_given() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    grey(&path, &["R", "G", "B"], 0.25);
    let output = run(&[
        "compare",
        text(&path),
        text(&path),
        "--exposure",
        "0.1",
        "--json",
    ]);
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(printed.contains("\"flip_exposure\": 0.1,"), "{printed}");
}

/// A path-traced picture and a reference with the same seed share samples, so their difference is too small. Two seeds, equal
/// numbers of samples and resampled pictures share none, or are compared on purpose.
#[test]
fn shared_samples_are_noted() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, integrator: &str, seed: &str, samples: &str| {
        let path = folder.path().join(name);
        let mut image = Image::new(8, 8);
        for channel in ["R", "G", "B"] {
            let values = Samples::F32(vec![1.0; 64]);
            image.channels.insert(channel.to_owned(), values);
        }
        for (key, value) in [
            ("scene", "abc"),
            ("settings", &format!("{{\"integrator\": \"{integrator}\"}}")),
            ("seed", seed),
            ("samples", samples),
        ] {
            let key = format!("headwater.{key}");
            image.metadata.insert(key, value.to_owned());
        }
        image.write(&path, 0.0).unwrap();
        path
    };
    let reference = write("reference.exr", "path-tracing", "0", "1024");
    for (integrator, seed, samples, is_noted) in [
        ("path-tracing", "0", "30", true),
        ("path-tracing", "1", "30", false),
        ("path-tracing", "0", "1024", false),
        ("restir", "0", "30", false),
    ] {
        let picture = write("picture.exr", integrator, seed, samples);
        let output = run(&["compare", text(&picture), text(&reference)]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said.contains("share samples"), is_noted, "{said}");
    }
}
