//! Tests of glTF files with harmless faults: they load as they are meant, and a notice reports what was changed.

use crate::files::{Folder, Gltf, glb};
use base64::prelude::{BASE64_STANDARD, Engine};
use headwater::scene::Instance;
use serde_json::{Value, json};

/// Loads a file whose scene must have the content of [`Gltf::triangle`] and the notices `notices`.
fn assert_is_triangle(name: &str, content: impl AsRef<[u8]>, notices: &[&str]) {
    let scene = Folder::new().load(name, content);
    let plain = Folder::new().load("scene.glb", Gltf::triangle().glb());
    assert_eq!(scene.content_hash(), plain.content_hash(), "{name}");
    assert_eq!(scene.notices, notices, "{name}");
}

/// The file with its buffer in a data URI, whose base64 has a `separator` after every 20 characters.
fn inside(file: &Gltf, separator: &str) -> String {
    let text = BASE64_STANDARD.encode(&file.binary);
    let lines: Vec<&str> = (0..text.len())
        .step_by(20)
        .map(|start| &text[start..text.len().min(start + 20)])
        .collect();
    file.with_uri(&format!("data:;base64,{}", lines.join(separator)))
}

#[test]
fn marks_before_and_zeros_after_the_json_are_left_out() {
    let file = Gltf::triangle();
    let text = inside(&file, "");
    assert_is_triangle("mark.gltf", format!("\u{feff}{text}"), &[]);
    assert_is_triangle("zeros.gltf", format!("{text}\0\0\0"), &[]);
    let marked = format!("\u{feff}{}", file.json);
    assert_is_triangle("mark.glb", glb(marked.as_bytes(), &file.binary), &[]);
    let zeros = format!("{}\0\0", file.json);
    assert_is_triangle("zeros.glb", glb(zeros.as_bytes(), &file.binary), &[]);
    // Texts of other encodings are refused, and so is nothing at all.
    for other in [&b"\xFF\xFE{\0}\0"[..], b"\xEF\xBB\xBF", b"\0\0"] {
        Folder::new().refuse("other.gltf", other);
    }
}

#[test]
fn base64_may_have_line_breaks_and_blanks() {
    for separator in ["\n", "\r\n", " ", "\t", "%0A", "%20"] {
        assert_is_triangle("lines.gltf", inside(&Gltf::triangle(), separator), &[]);
    }
    // JSON forbids plain line breaks in texts, but they do no harm.
    let broken = inside(&Gltf::triangle(), "|").replace('|', "\n");
    let notice = "control characters in texts of the JSON count as blanks: 5 times, first the JSON";
    assert_is_triangle("broken.gltf", broken, &[notice]);
}

/// Writes every integer of the JSON with a fraction of zeros.
fn with_fractions(json: &str) -> String {
    let mut text = String::new();
    let mut rest = json;
    while let Some(start) = rest.find([':', '[', ',']) {
        let (before, after) = rest.split_at(start + 1);
        let digits = after.bytes().take_while(u8::is_ascii_digit).count();
        text += before;
        text += &after[..digits];
        if digits > 0 && !after[digits..].starts_with('.') {
            text += ".0";
        }
        rest = &after[digits..];
    }
    text + rest
}

#[test]
fn integers_may_have_a_fraction_of_zeros() {
    let file = Gltf::triangle();
    let text = with_fractions(&inside(&file, ""));
    for part in [
        "\"count\":3.0",
        "\"componentType\":5123.0",
        "\"nodes\":[0.0,1.0]",
    ] {
        assert!(text.contains(part), "{text}");
    }
    assert_is_triangle("fractions.gltf", &text, &[]);
    assert_is_triangle("exponent.gltf", text.replace("5123.0", "5.123e3"), &[]);
    let text = Folder::new().refuse("half.gltf", text.replace("\"count\":3.0", "\"count\":2.5"));
    assert!(
        text.contains("2.5") && text.contains("accessors[0].count"),
        "{text}"
    );
}

#[test]
fn extensions_without_effect_may_be_required() {
    let names = ["KHR_xmp_json_ld", "KHR_audio_emitter"];
    let file = Gltf::triangle().with(|json| {
        json["extensionsUsed"] = json!(["KHR_materials_unlit", names[0]]);
        json["extensionsRequired"] = json!(names);
    });
    let notice =
        "extensions that are not supported are ignored: KHR_xmp_json_ld, KHR_audio_emitter";
    assert_is_triangle("required.glb", file.glb(), &[notice]);
}

/// The corners x of the triangles that a scene with the nodes `nodes` and the roots `roots` shows, instance by instance, and
/// its notices.
fn shown(nodes: Value, roots: Value) -> (Vec<f64>, Vec<String>) {
    let file = Gltf::triangle().with(|json| {
        json["nodes"] = nodes;
        json["scenes"] = json!([{ "nodes": roots }]);
    });
    let scene = Folder::new().load("scene.glb", file.glb());
    let x = |instance: &Instance| instance.object_to_world.translation.x;
    (scene.instances.iter().map(x).collect(), scene.notices)
}

#[test]
fn roots_that_are_children_too_are_shown_once() {
    let nodes = json!([
        { "mesh": 0, "children": [1], "translation": [1, 0, 0] },
        { "mesh": 0, "children": [2], "translation": [10, 0, 0] },
        { "name": "leaf", "mesh": 0, "translation": [100, 0, 0] },
        { "mesh": 0, "translation": [1000, 0, 0] },
    ]);
    let child = "roots of the scene that are children too are shown once, as children";
    let outside = "roots whose parents are outside of the scene are shown without them";
    let twice = "nodes that the scene lists twice are shown once";
    let leaf = "node 2 \"leaf\"";
    for (roots, x, notices) in [
        (json!([0, 3]), vec![1.0, 11.0, 111.0, 1000.0], vec![]),
        (
            json!([0, 2]),
            vec![1.0, 11.0, 111.0],
            vec![format!("{child}: {leaf}")],
        ),
        (
            json!([2, 1, 0]),
            vec![1.0, 11.0, 111.0],
            vec![format!("{child}: 2 times, first {leaf}")],
        ),
        (
            json!([3, 2]),
            vec![1000.0, 100.0],
            vec![format!("{outside}: {leaf}")],
        ),
        (
            json!([2, 1, 2]),
            vec![10.0, 110.0],
            vec![
                format!("{twice}: {leaf}"),
                format!("{child}: {leaf}"),
                format!("{outside}: node 1"),
            ],
        ),
    ] {
        assert_eq!(shown(nodes.clone(), roots.clone()), (x, notices), "{roots}");
    }
}
