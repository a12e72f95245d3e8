//! Tests of limits: the memory that a small file may request, and data that is counted or read once however often a file
//! names it.

use crate::files::{Folder, Gltf};
use crate::textures::{encoded, textured};
use headwater::image::Image;
use headwater::scene::{Environment, Scene};
use headwater::scene_files::progress::Step;
use headwater::scene_files::{Options, load, load_watched};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// Extends a file to terabytes of zeros that occupy no space on the disk (a sparse file).
fn lengthen(path: &Path) {
    let file = std::fs::File::options().write(true).open(path).unwrap();
    file.set_len(8 << 40).unwrap();
}

/// The loaded scene, and the number of bytes that were read for it.
fn load_counted(path: &Path) -> (Scene, u64) {
    let mut read = 0;
    let mut expected = 0;
    let watch = &mut |step, done, total| {
        if step == Step::Reading {
            (read, expected) = (done, total);
        }
        Ok(())
    };
    let scene = load_watched(path, Options::default(), watch).unwrap();
    assert_eq!(read, expected, "bytes");
    (scene, read)
}

#[test]
fn an_mtl_file_is_read_once_however_it_is_called() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("sub")).unwrap();
    folder.write("a.mtl", "newmtl red\nKd 1 0 0\n");
    std::os::unix::fs::symlink("../a.mtl", folder.path("sub/link.mtl")).unwrap();
    std::fs::hard_link(folder.path("a.mtl"), folder.path("hard link.mtl")).unwrap();
    let mut text = SQUARE.to_owned();
    for i in 0..10_000 {
        text += "mtllib a.mtl\nmtllib lost.mtl\n";
        writeln!(text, "mtllib {}a.mtl", "./".repeat(i % 20)).unwrap();
        text += "mtllib sub/../a.mtl sub/link.mtl sub\\..\\a.mtl\nmtllib hard link.mtl\n";
    }
    text += "usemtl red\nf 1 2 3 4\n";
    let scene = folder.load("a.obj", text);
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(
        scene.notices,
        ["MTL files that cannot be read are left out: line 6: \"lost.mtl\""]
    );
}

#[test]
fn kinds_of_ignored_textures_are_listed_up_to_a_number() {
    let folder = Folder::new();
    let mut text = "newmtl red\n".to_owned();
    for i in 0..50_000 {
        writeln!(text, "map_{i} a.png").unwrap();
    }
    writeln!(text, "map_{} a.png", "x".repeat(1 << 20)).unwrap();
    folder.write("a.mtl", text);
    let scene = folder.load(
        "a.obj",
        format!("mtllib a.mtl\n{SQUARE}usemtl red\nf 1 2 3\n"),
    );
    let [notice] = &scene.notices[..] else {
        panic!("{:?}", scene.notices.len())
    };
    assert!(
        notice.contains("map_0, map_1, ") && notice.ends_with(" and others"),
        "{notice}"
    );
    assert!(notice.len() < 500, "{notice}");
}

#[test]
fn files_of_terabytes_are_refused_at_once() {
    let folder = Folder::new();
    let refused = |result: headwater::Result<()>, name: &str| {
        let error = result.expect_err(name);
        let text = error.to_string();
        assert_eq!(
            (error.exit_status(), text.lines().count()),
            (2, 1),
            "{text}"
        );
        assert!(text.contains(name) && text.contains("bytes"), "{text}");
    };
    for name in ["a.bin", "a.png", "a.mtl", "a.obj"] {
        lengthen(&folder.write(name, ""));
    }
    let buffer = Gltf::triangle().with(|json| {
        json["buffers"][0] = json!({ "uri": "a.bin", "byteLength": 8_u64 << 40 });
    });
    let path = folder.write("buffer.gltf", buffer.json.to_string());
    refused(load(&path).map(drop), "a.bin");
    let image = textured(json!({ "uri": "a.png" }));
    refused(
        load(&folder.write("image.glb", image.glb())).map(drop),
        "a.png",
    );
    refused(load(&folder.path("a.obj")).map(drop), "a.obj");
    let library = folder.write("library.obj", format!("mtllib a.mtl\n{SQUARE}f 1 2 3\n"));
    refused(load(&library).map(drop), "a.mtl");
    for name in ["a.exr", "b.png"] {
        let path = folder.write(name, "");
        lengthen(&path);
        refused(Image::read(&path).map(drop), name);
    }
    let path = folder.path("a.exr");
    refused(
        Environment::open(path.to_str().unwrap(), &mut Vec::new()).map(drop),
        "a.exr",
    );
}

#[test]
fn a_line_has_an_end() {
    let folder = Folder::new();
    for joined in ["", "\\\n"] {
        let line = format!("f 1 2 3 4{joined} ");
        let long = line.repeat((80 << 20) / line.len());
        let text = folder.refuse("a.obj", format!("{SQUARE}{long}"));
        assert!(text.contains("more than 67108864 bytes"), "{text}");
    }
    let corners = "1 2 3 4 ".repeat(50_000);
    let scene = folder.load("a.obj", format!("{SQUARE}f {corners}\n"));
    assert!(scene.triangle_count() > 0);
}

#[test]
fn a_file_of_many_buffers_is_read_once() {
    let folder = Folder::new();
    let triangle = Gltf::triangle();
    folder.write("a.bin", &triangle.binary);
    std::fs::hard_link(folder.path("a.bin"), folder.path("b.bin")).unwrap();
    let length = triangle.binary.len();
    let mut buffers = vec![json!({ "uri": "a.bin", "byteLength": length })];
    for (i, uri) in ["a.bin", "./a.bin", "%61.bin", "b.bin"]
        .iter()
        .cycle()
        .take(1000)
        .enumerate()
    {
        // The first of a file is not always the longest.
        buffers.push(json!({ "uri": uri, "byteLength": i % (length + 1) }));
    }
    buffers.swap(0, 4);
    let file = triangle.with(|json| {
        json["buffers"] = buffers.into();
        for view in json["bufferViews"].as_array_mut().unwrap() {
            view["buffer"] = 4.into();
        }
    });
    let text = file.json.to_string();
    let path = folder.write("a.gltf", &text);
    let (scene, read) = load_counted(&path);
    assert_eq!(scene.triangle_count(), 1);
    assert_eq!(read as usize, text.len() + length);
}

#[test]
fn images_of_one_file_are_read_once() {
    let folder = Folder::new();
    let png = encoded(image::ImageFormat::Png);
    folder.write("a.png", &png);
    std::fs::hard_link(folder.path("a.png"), folder.path("b.png")).unwrap();
    let uris = ["a.png", "./a.png", "%61.png", "b.png"];
    let file = textured(json!({})).with(|json| {
        json["images"] = uris.iter().map(|uri| json!({ "uri": uri })).collect();
        json["textures"] = (0..4).map(|i| json!({ "source": i })).collect();
        let slot = |i: u32| json!({ "index": i });
        json["materials"][0] = json!({
            "emissiveFactor": [1, 1, 1], "emissiveTexture": slot(0), "normalTexture": slot(1),
            "pbrMetallicRoughness": { "baseColorTexture": slot(2), "metallicRoughnessTexture": slot(3) },
        });
    });
    let bytes = file.glb();
    let (scene, read) = load_counted(&folder.write("a.glb", &bytes));
    assert_eq!(scene.images.len(), 1);
    assert_eq!(read as usize, bytes.len() + png.len());
}

/// A JSON array of `count` copies of a value.
fn copies(value: &Value, count: usize) -> Value {
    vec![value.clone(); count].into()
}

#[test]
fn keys_that_channels_share_have_a_limit() {
    let mut file = Gltf::triangle();
    let keys = 100_000_u32;
    let numbers = |number: &dyn Fn(u32) -> f32| -> Vec<u8> {
        (0..keys).flat_map(|i| number(i).to_le_bytes()).collect()
    };
    let view = file.add_view(&numbers(&|i| i as f32));
    let times = file.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": keys, "type": "SCALAR",
    }));
    let view = file.add_view(&vec![0; 12 * keys as usize]);
    let values = file.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": keys, "type": "VEC3",
    }));
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
    let with = |channels: usize| {
        file.with(|json| {
            json["animations"] = json!([{
                "samplers": [{ "input": times, "output": values }],
                "channels": copies(&channel, channels),
            }]);
        })
    };
    Folder::new().load("few.glb", with(10).glb());
    let text = Folder::new().refuse("many.glb", with(100_000).glb());
    assert!(text.contains("unfolds to more than 64 times"), "{text}");
}

#[test]
fn sparse_indices_that_primitives_share_have_a_limit() {
    let mut file = Gltf::triangle();
    let count = 1_000_000_u32;
    let indices: Vec<u8> = (0..count).flat_map(u32::to_le_bytes).collect();
    let indices = file.add_view(&indices);
    let values = file.add_view(&vec![0; 12 * count as usize]);
    file.json["accessors"][0]["count"] = count.into();
    file.json["accessors"][0]["bufferView"] = Value::Null;
    file.json["accessors"][0]["sparse"] = json!({
        "count": count,
        "indices": { "bufferView": indices, "componentType": 5125 },
        "values": { "bufferView": values },
    });
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 2 });
    let with = |primitives: usize| {
        file.with(|json| json["meshes"][0]["primitives"] = copies(&primitive, primitives))
    };
    Folder::new().load("few.glb", with(3).glb());
    let text = Folder::new().refuse("many.glb", with(10_000).glb());
    assert!(text.contains("unfolds to more than 64 times"), "{text}");
}

#[test]
fn names_that_nodes_share_are_cut() {
    let long = "n".repeat(100_000);
    let mut file = Gltf::triangle().with(|json| {
        json["cameras"][0]["name"] = long.clone().into();
        json["nodes"][1]["name"] = "".into();
        json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
        json["nodes"][0]["name"] = "".into();
        json["extensions"] = json!({
            "KHR_lights_punctual": { "lights": [{ "type": "point", "name": long }] },
        });
    });
    let scene = Folder::new().load("a.glb", file.glb());
    assert_eq!(scene.cameras[0].name, "n".repeat(256));
    assert_eq!(scene.punctual_lights[0].name, "n".repeat(256));
    file.json["nodes"][1]["name"] = "own".into();
    assert_eq!(
        Folder::new().load("a.glb", file.glb()).cameras[0].name,
        "own"
    );
}

/// Loads a scene in a process with 400 MB of address space, asserts that it is refused, and returns the message.
fn refuse_in_little_memory(path: &Path) -> String {
    let inspect = "ulimit -v 400000 && exec \"$0\" scene inspect \"$1\"";
    let output = Command::new("bash")
        .args(["-c", inspect, env!("CARGO_BIN_EXE_headwater")])
        .arg(path)
        // Each thread takes address space.
        .env("RAYON_NUM_THREADS", "2")
        .env_remove("RUST_BACKTRACE")
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{path:?}: {said}");
    assert!(said.contains("more than there is memory for"), "{said}");
    said
}

#[test]
fn small_files_that_take_much_memory_are_refused() {
    let folder = Folder::new();
    let json = |list: &str, item: &str| {
        let items = vec![item; 500_000].join(",");
        format!(r#"{{"asset":{{"version":"2.0"}},"{list}":[{items}]}}"#)
    };
    folder.write("nodes.gltf", json("nodes", "[]"));
    folder.write("materials.gltf", json("materials", "[ ]"));
    let name = format!(r#""{}""#, "a,".repeat(4)) + r#","","","","","","""#;
    folder.write("names.gltf", json("extensionsUsed", &name));
    folder.write(
        "meshes.obj",
        SQUARE.to_owned() + &"g\nf 1 1 1\n".repeat(1_000_000),
    );
    let corners = "1 ".repeat(5_000_000);
    folder.write("face.obj", format!("{SQUARE}f {corners}\n"));
    folder.write("a.mtl", "newmtl\n".repeat(500_000));
    folder.write("materials.obj", format!("mtllib a.mtl\n{SQUARE}f 1 2 3\n"));
    for (name, element) in [
        ("nodes.gltf", "JSON"),
        ("materials.gltf", "JSON"),
        ("names.gltf", "JSON"),
        ("meshes.obj", "line "),
        ("face.obj", "line 5, \"f\""),
        ("materials.obj", "\"a.mtl\""),
    ] {
        let said = refuse_in_little_memory(&folder.path(name));
        assert!(said.contains(name) && said.contains(element), "{said}");
    }
}

#[test]
fn what_a_small_file_unfolds_to_must_fit_the_memory() {
    let mut file = Gltf::triangle();
    let keys = 100_000_u32;
    let times: Vec<u8> = (0..keys).flat_map(|i| (i as f32).to_le_bytes()).collect();
    let view = file.add_view(&times);
    let times = file.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": keys, "type": "SCALAR",
    }));
    let view = file.add_view(&vec![0; 12 * keys as usize]);
    let values = file.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": keys, "type": "VEC3",
    }));
    let nodes = 200;
    file.json["nodes"] = vec![json!({ "mesh": 0 }); nodes].into();
    file.json["scenes"][0]["nodes"] = (0..nodes).collect();
    file.json["animations"] = json!([{
        "samplers": [{ "input": times, "output": values }],
        "channels": (0..nodes)
            .map(|node| json!({ "sampler": 0, "target": { "node": node, "path": "translation" } }))
            .collect::<Vec<_>>(),
    }]);
    let folder = Folder::new();
    let said = refuse_in_little_memory(&folder.write("a.glb", file.glb()));
    assert!(said.contains("accessor"), "{said}");
}
