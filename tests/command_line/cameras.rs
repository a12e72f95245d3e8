//! Tests of `--aperture`, `--focus` and orthographic cameras on the command line.

use crate::{fail, run, succeed, text, validated};
use headwater::image::Image;
use serde_json::json;

const RENDER: [&str; 6] = ["render", "cornell", "--width", "24", "--frames", "2"];

#[test]
fn wrong_lenses_are_one_line() {
    for (options, said) in [
        (vec!["--aperture", "-0.1"], "--aperture -0.1"),
        (vec!["--aperture", "nan"], "--aperture NaN"),
        (vec!["--aperture", "inf"], "--aperture inf"),
        (vec!["--aperture", "wide"], "wide"),
        (vec!["--aperture", "0.1", "--focus", "0"], "--focus 0"),
        (vec!["--aperture", "0.1", "--focus", "-2"], "--focus -2"),
        (vec!["--aperture", "0.1", "--focus", "nan"], "--focus NaN"),
        (vec!["--focus", "0"], "--focus 0"),
        (vec!["--aperture", "5", "--focus", "1e-9"], "thousandth"),
        (vec!["--aperture", "1e300"], "diameter"),
        (
            vec!["--aperture", "0.1", "--look-at=0,1,9,0,1,20"],
            "set --focus",
        ),
    ] {
        for command in [&RENDER[..], &["reference", "cornell", "--width", "24"]] {
            let line = fail(&[command, &["-o", "never.exr"], &options].concat(), 2);
            assert!(line.contains(said), "{options:?}: {line}");
        }
    }
}

#[test]
fn an_aperture_of_0_is_a_pinhole_with_every_bit() {
    let folder = tempfile::tempdir().unwrap();
    let [plain, zero, blurred] = ["a.exr", "b.exr", "c.exr"].map(|name| folder.path().join(name));
    let render = |path: &std::path::Path, more: &[&str]| {
        succeed(&[&RENDER[..], &["-o", text(path)], more].concat())
    };
    assert_eq!(render(&plain, &[]), "");
    assert_eq!(render(&zero, &["--aperture", "0"]), "");
    let said = render(&blurred, &["--aperture", "0.3"]);
    assert!(
        said.contains("focused at") && said.contains("--focus"),
        "{said}"
    );
    let [plain, zero, blurred] = [plain, zero, blurred].map(|path| Image::read(&path).unwrap());
    let camera = |image: &Image| image.metadata["headwater.camera"].clone();
    assert!(camera(&blurred).contains("aperture 0.3; focus "));
    assert_eq!(camera(&plain), camera(&zero));
    let [plain, zero, blurred] = [plain, zero, blurred].map(|image| image.rgb().unwrap());
    assert!(plain == zero && plain != blurred);
}

#[test]
fn a_focus_without_an_aperture_is_noted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let said = succeed(&[&RENDER[..], &["-o", text(&path), "--focus", "2"]].concat());
    assert!(said.contains("--focus has no effect"), "{said}");
}

#[test]
fn orthographic_cameras_of_files_are_chosen_and_described() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    let nodes = json!([
        { "mesh": 0 },
        { "name": "front", "camera": 0, "translation": [0, 0, 5] },
        { "name": "plan", "camera": 1, "translation": [0, 0, 5] },
    ]);
    let corners: Vec<u8> = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        .iter()
        .flatten()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    std::fs::write(folder.path().join("corners.bin"), &corners).unwrap();
    let file = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": nodes,
        "cameras": [
            { "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } },
            { "type": "orthographic", "orthographic": { "xmag": 2, "ymag": 1, "znear": 0, "zfar": 9 } },
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{
            "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0],
        }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "uri": "corners.bin", "byteLength": 36 }],
    });
    std::fs::write(&path, file.to_string()).unwrap();
    let output = run(&["scene", "inspect", text(&path), "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let plan = json!({ "name": "plan", "orthographic_height": 2.0, "aspect_ratio": 2.0 });
    assert_eq!(summary["cameras"][1], plan);
    let picture = folder.path().join("a.exr");
    let wanted = [
        "render",
        text(&path),
        "--camera",
        "plan",
        "--width",
        "40",
        "--frames",
        "2",
        "-o",
        text(&picture),
    ];
    let output = validated(&wanted).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let image = Image::read(&picture).unwrap();
    assert_eq!((image.width, image.height), (40, 20));
    assert!(image.metadata["headwater.camera"].ends_with("orthographic height 2.0"));
    let line = fail(&[&wanted[..], &["--aperture", "0.1"]].concat(), 2);
    assert!(line.contains("'plan' is orthographic"), "{line}");
}
