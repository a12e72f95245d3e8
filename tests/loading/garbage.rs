//! Tests of broken scene files: they end in one line that names the file and the element, with status 2, and never in a
//! panic.

use crate::files::{Folder, Gltf, glb};
use crate::support::random::Random;
use headwater::scene_files::load;
use serde_json::{Value, json};

/// Changes the JSON of the triangle, asserts that the file is refused, and returns the message.
fn refuse(change: impl FnOnce(&mut Value)) -> String {
    Folder::new().refuse("bad.glb", Gltf::triangle().with(change).glb())
}

fn assert_names(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{text:?} names {part:?}");
    }
}

#[test]
fn files_that_are_no_scene() {
    let folder = Folder::new();
    let missing = load(&folder.path("missing.glb")).unwrap_err();
    assert_eq!(missing.exit_status(), 2);
    assert_names(&missing.to_string(), &["missing.glb", "No such file"]);
    for name in ["scene", "scene.png", "scene.glb.txt"] {
        assert_names(&folder.refuse(name, "x"), &[".gltf, .glb or .obj"]);
    }
    for garbage in [
        "",
        "{",
        "[]",
        "null",
        "glTF",
        "\u{0}\u{1}",
        "{\"asset\": 7}",
    ] {
        folder.refuse("a.gltf", garbage);
        folder.refuse("b.glb", garbage);
    }
    std::fs::create_dir(folder.path("dir.glb")).unwrap();
    assert_eq!(load(&folder.path("dir.glb")).unwrap_err().exit_status(), 2);
    let one_line = load(&folder.path("two\nlines.glb"))
        .unwrap_err()
        .to_string();
    assert_eq!(one_line.lines().count(), 1);
}

#[test]
fn a_sparse_file_of_terabytes_is_refused_at_once() {
    let folder = Folder::new();
    for name in ["sparse.glb", "sparse.gltf"] {
        let path = folder.write(name, Gltf::triangle().glb());
        let file = std::fs::File::options().write(true).open(&path).unwrap();
        file.set_len(8 << 40).unwrap();
        let error = load(&path).unwrap_err();
        assert_eq!(error.exit_status(), 2);
        assert_names(&error.to_string(), &[name, "8796093022208 bytes"]);
    }
}

#[test]
fn versions_and_extensions_that_are_not_supported() {
    let text = refuse(|json| json["asset"]["version"] = "1.0".into());
    assert_names(&text, &["version \"1.0\"", "glTF 2.0"]);
    let text = refuse(|json| json["asset"]["minVersion"] = "2.1".into());
    assert_names(&text, &["version \"2.1\""]);
    let text = refuse(|json| *json = json!({ "asset": { "version": "1.0" }, "nodes": {} }));
    assert_names(&text, &["version \"1.0\""]);
    let name = "KHR_materials_sheen";
    let text = refuse(|json| json["extensionsRequired"] = json!([name]));
    assert_names(&text, &[name, "not supported"]);
}

#[test]
fn cut_off_glb_files() {
    let whole = Gltf::triangle().glb();
    let folder = Folder::new();
    for length in 0..whole.len() {
        folder.refuse("cut.glb", &whole[..length]);
    }
    for (at, value, named) in [
        (4, 1, "version 1"),
        (8, 11, "length of 11 bytes"),
        (8, u32::MAX, "length of 4294967295 bytes"),
        (12, u32::MAX, "JSON chunk length"),
        (16, 0, "chunk 0 is not JSON"),
    ] {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        assert_names(&folder.refuse("header.glb", bytes), &[named]);
    }
    // An extension's chunk in the place of the binary one is legal: only its buffer is missing.
    let mut extended = whole.clone();
    let binary_chunk = 20 + u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    extended[binary_chunk + 4..][..4].copy_from_slice(b"MORE");
    let text = folder.refuse("extended.glb", extended);
    assert_names(&text, &["buffer 0 has no uri"]);
    // And nothing is read past the length in the header.
    let mut shortened = whole.clone();
    shortened[8..12].copy_from_slice(&(binary_chunk as u32).to_le_bytes());
    let text = folder.refuse("shortened.glb", shortened);
    assert_names(&text, &["buffer 0 has no uri"]);
    let json = Gltf::triangle().json.to_string();
    let text = folder.refuse("none.glb", glb(json.as_bytes(), &[]));
    assert_names(&text, &["buffer 0", "there are 0"]);
}

#[test]
fn indices_out_of_range() {
    type Change = fn(&mut Value);
    let changes: [(Change, &[&str]); 13] = [
        (|j| j["scene"] = 5.into(), &["scene 5"]),
        (
            |j| j["scenes"][0]["nodes"] = json!([9]),
            &["scene 0", "node 9"],
        ),
        (
            |j| j["nodes"][0]["children"] = json!([9]),
            &["node 0 \"root\"", "child 9"],
        ),
        (|j| j["nodes"][0]["mesh"] = 3.into(), &["node 0", "mesh 3"]),
        (
            |j| j["nodes"][1]["camera"] = 4_294_967_296_u64.into(),
            &["node 1", "camera 4294967296"],
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 77.into(),
            &["mesh 0 \"leaf\" primitive 0", "accessor 77", "POSITION"],
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 77.into(),
            &["accessor 77", "NORMAL"],
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["indices"] = u64::MAX.into(),
            &["accessor 18446744073709551615", "indices"],
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["material"] = 2.into(),
            &["primitive 0", "material 2"],
        ),
        (
            |j| j["accessors"][0]["bufferView"] = 9.into(),
            &["accessor 0", "bufferView 9"],
        ),
        (
            |j| j["bufferViews"][1]["buffer"] = 1.into(),
            &["bufferView 1", "buffer 1"],
        ),
        (|j| j["nodes"][0]["mesh"] = (-1).into(), &["-1", "line 1"]),
        (
            |j| j["meshes"][0]["primitives"][0]["mode"] = 7.into(),
            &["primitive 0", "mode 7"],
        ),
    ];
    for (change, named) in changes {
        assert_names(&refuse(change), named);
    }
    let mut file = Gltf::triangle();
    let indices = file.add_indices(5123, &[0, 1, 3]);
    file.primitive()["indices"] = indices.into();
    let text = Folder::new().refuse("bad.glb", file.glb());
    assert_names(&text, &["mesh 0 \"leaf\" primitive 0", "index 2 is 3"]);
}

#[test]
fn accessors_that_do_not_fit() {
    type Change = fn(&mut Value);
    let changes: [(Change, &[&str]); 14] = [
        (
            |j| j["accessors"][0]["count"] = 4.into(),
            &["accessor 0", "bufferView 0"],
        ),
        (
            |j| j["accessors"][0]["count"] = u64::MAX.into(),
            &["accessor 0"],
        ),
        (
            |j| j["accessors"][2]["count"] = u64::MAX.into(),
            &["accessor 2"],
        ),
        (
            |j| j["accessors"][1]["count"] = 2.into(),
            &["2 elements for 3 positions"],
        ),
        (
            |j| j["accessors"][0]["byteOffset"] = u64::MAX.into(),
            &["accessor 0"],
        ),
        (
            |j| j["accessors"][0]["componentType"] = 5125.into(),
            &["accessor 0", "5125", "floats"],
        ),
        (
            |j| j["accessors"][0]["type"] = "VEC2".into(),
            &["accessor 0", "VEC2"],
        ),
        (
            |j| j["accessors"][2]["componentType"] = 5126.into(),
            &["accessor 2", "5126"],
        ),
        (
            |j| j["accessors"][2]["type"] = "VEC3".into(),
            &["accessor 2", "SCALAR"],
        ),
        (
            |j| j["bufferViews"][0]["byteLength"] = u64::MAX.into(),
            &["bufferView 0", "buffer 0"],
        ),
        (
            |j| j["bufferViews"][0]["byteOffset"] = u64::MAX.into(),
            &["bufferView 0", "buffer 0"],
        ),
        (
            |j| j["bufferViews"][0]["byteStride"] = 8.into(),
            &["accessor 0", "byteStride 8"],
        ),
        (
            |j| j["bufferViews"][0]["byteStride"] = u64::MAX.into(),
            &["byteStride"],
        ),
        (
            |j| {
                j["accessors"][0] = json!({
                    "componentType": 5126, "type": "VEC3", "count": 3,
                    "sparse": {
                        "count": 3,
                        "indices": { "bufferView": 2, "componentType": 5123, "byteOffset": 1 },
                        "values": { "bufferView": 1 },
                    },
                })
            },
            &["accessor 0", "sparse indices"],
        ),
    ];
    for (change, named) in changes {
        assert_names(&refuse(change), named);
    }
}

#[test]
fn counts_that_nothing_backs_allocate_nothing() {
    for count in [u64::from(u32::MAX), u64::MAX / 16, u64::MAX] {
        let text = refuse(|json| {
            json["accessors"][0] = json!({ "componentType": 5126, "type": "VEC3", "count": count });
            let primitive = &mut json["meshes"][0]["primitives"][0];
            *primitive = json!({ "attributes": { "POSITION": 0 }, "mode": 5 });
        });
        assert_names(&text, &["mesh 0 \"leaf\" primitive 0", "unfolds"]);
    }
}

#[test]
fn numbers_that_are_not_finite() {
    for (accessor, kind) in [(0, "position 1"), (1, "normal 1")] {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut file = Gltf::triangle();
            let at = 36 * accessor + 12;
            file.binary[at..at + 4].copy_from_slice(&value.to_le_bytes());
            let text = Folder::new().refuse("bad.glb", file.glb());
            assert_names(&text, &["mesh 0 \"leaf\" primitive 0", kind]);
        }
    }
    let json = Gltf::triangle().json.to_string();
    for number in ["NaN", "1e999", "-Infinity"] {
        let bad = json.replace("0.8", number);
        assert_names(&Folder::new().refuse("nan.gltf", bad), &["JSON", "line 1"]);
    }
}

#[test]
fn transforms_and_hierarchies() {
    type Change = fn(&mut Value);
    let changes: [(Change, &[&str]); 7] = [
        (
            |j| j["nodes"][0]["scale"] = json!([1e300, 1e300, 1]),
            &["\"root\"", "scale the scene"],
        ),
        (
            |j| j["nodes"][0]["rotation"] = json!([0, 0, 0, 0]),
            &["node 0", "rotation"],
        ),
        (
            |j| j["nodes"][0]["matrix"] = json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            &["node 0", "last row"],
        ),
        (
            |j| j["nodes"][0]["children"] = json!([0]),
            &["node 0", "cycle"],
        ),
        (
            |j| {
                j["nodes"][0]["children"] = json!([1]);
                j["nodes"][1]["children"] = json!([0]);
            },
            &["cycle"],
        ),
        (
            |j| j["nodes"] = json!([{ "children": [2] }, { "children": [2] }, {}]),
            &["node 1", "node 2", "also a child of node 0"],
        ),
        (
            |j| {
                j["nodes"] = json!([
                    { "children": [1], "scale": [1e200, 1, 1] },
                    { "mesh": 0, "scale": [1e200, 1, 1] },
                ]);
                j["scenes"] = json!([{ "nodes": [0] }]);
            },
            &["node 1", "not finite"],
        ),
    ];
    for (change, named) in changes {
        assert_names(&refuse(change), named);
    }
}

#[test]
fn cameras_and_materials() {
    for fov in [json!(0), json!(-1), json!(3.2), json!(1e300)] {
        let text = refuse(|json| json["cameras"][0]["perspective"]["yfov"] = fov);
        assert_names(&text, &["camera 0 of node 1 \"eye\"", "yfov"]);
    }
    let text = refuse(|json| json["cameras"][0]["perspective"]["aspectRatio"] = 0.into());
    assert_names(&text, &["camera 0", "aspectRatio"]);
    let text = refuse(|json| json["cameras"][0]["type"] = "fisheye".into());
    assert_names(&text, &["camera 0", "neither"]);
    for (factor, value) in [
        ("emissiveFactor", json!([-1, 0, 0])),
        ("emissiveFactor", json!([1e30, 0, 0])),
        ("pbrMetallicRoughness", json!({ "roughnessFactor": 1.5 })),
        ("pbrMetallicRoughness", json!({ "metallicFactor": 1e30 })),
        (
            "extensions",
            json!({ "KHR_materials_ior": { "ior": -0.5 } }),
        ),
        (
            "extensions",
            json!({ "KHR_materials_specular": { "specularFactor": -1 } }),
        ),
    ] {
        let text = refuse(|json| json["materials"][0][factor] = value);
        assert_names(&text, &["material 0 \"paint\"", "must be"]);
    }
    // What f32 cannot hold, and what is of another type, is found while the JSON is read.
    for (factor, value) in [
        ("emissiveFactor", json!([1e300, 0, 0])),
        ("emissiveFactor", json!("red")),
        ("pbrMetallicRoughness", json!({ "metallicFactor": 1e300 })),
        (
            "pbrMetallicRoughness",
            json!({ "baseColorFactor": [1e300, 0, 0, 1] }),
        ),
        ("normalTexture", json!({ "scale": 2 })),
        ("normalTexture", json!({ "index": -1 })),
    ] {
        let text = refuse(|json| json["materials"][0][factor] = value);
        let path = format!("\"materials[0].{factor}");
        assert_names(&text, &["JSON", "line 1", &path]);
    }
}

#[test]
fn buffers_that_are_not_there() {
    let folder = Folder::new();
    let file = Gltf::triangle();
    folder.write("short.bin", "abc");
    std::fs::create_dir(folder.path("folder.bin")).unwrap();
    for (uri, named) in [
        ("lost.bin", "lost.bin"),
        ("short.bin", "there are 3"),
        ("folder.bin", "a folder"),
        ("", "a folder"),
        ("a%zz", "a%zz"),
        ("http://localhost/a.bin", "not a file beside"),
        ("data:;base64,*", "base64"),
        ("data:text/plain,hello", "base64"),
        ("data:;base64,AAAA", "there are 3"),
    ] {
        let text = folder.refuse("a.gltf", file.with_uri(uri));
        assert_names(&text, &["buffer 0", named]);
    }
    let text = folder.refuse("none.gltf", file.json.to_string());
    assert_names(&text, &["buffer 0 has no uri"]);
    let text = refuse(|json| json["buffers"][0]["byteLength"] = u64::MAX.into());
    assert_names(&text, &["buffer 0 should have 18446744073709551615 bytes"]);
}

#[test]
fn broken_obj_files() {
    for (text, named) in [
        ("hello world", "line 1, \"hello\""),
        ("\u{0}\u{1}\u{2}", "line 1"),
        ("v 0 0", "line 1, \"v\": three numbers"),
        ("v 0 0 x", "\"x\" is not a finite number"),
        ("\n\nv 0 nan 0", "line 3, \"v\": \"nan\""),
        ("v 0 1e99 0", "\"1e99\""),
        ("v 0 0 0\nf 1 1 2", "vertex 2 is out of range"),
        ("v 0 0 0\nf 1 1 0", "vertex 0 is out of range"),
        ("v 0 0 0\nf 1 1 -2", "vertex -2 is out of range"),
        ("v 0 0 0\nf 1 1 -9223372036854775808", "out of range"),
        (
            "v 0 0 0\nf 1 1 99999999999999999999",
            "is not a vertex index",
        ),
        ("v 0 0 0\nf 1 1 /", "is not a vertex index"),
        ("v 0 0 0\nf 1//1 1//1 1//1", "normal 1 is out of range"),
    ] {
        assert_names(&Folder::new().refuse("bad.obj", text), &[named]);
    }
}

/// Bytes with some of them changed at random, and some cut off at the end.
fn mutate(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.index(2) {
        let at = random.index(bytes.len());
        match random.index(4) {
            0 => bytes[at] ^= 1 << random.index(8),
            1 => bytes[at] = random.index(256) as u8,
            2 => bytes[at] = b"0123456789-[]{}\",:eE./ \n"[random.index(24)],
            _ => bytes.insert(at, b"0123456789"[random.index(10)]),
        }
    }
    if random.index(8) == 0 {
        bytes.truncate(random.index(bytes.len()));
    }
    bytes
}

/// Loads `rounds` random mutations of a file. None may panic, and each error must be one line that names the file. Returns
/// the numbers of loaded and of refused files.
fn fuzz(name: &str, bytes: &[u8], rounds: usize) -> (usize, usize) {
    let folder = Folder::new();
    let mut random = Random(7);
    let (mut good, mut bad) = (0, 0);
    for _ in 0..rounds {
        let path = folder.write(name, mutate(bytes, &mut random));
        match load(&path) {
            Ok(mut scene) => {
                let hash = scene.content_hash();
                scene.validate().unwrap();
                assert_eq!(scene.content_hash(), hash, "validated already");
                good += 1;
            }
            Err(error) => {
                let text = error.to_string();
                assert_eq!(
                    (error.exit_status(), text.lines().count()),
                    (2, 1),
                    "{text}"
                );
                assert!(text.contains(name), "{text}");
                bad += 1;
            }
        }
    }
    (good, bad)
}

#[test]
fn mutated_files_never_panic() {
    let mut file = Gltf::triangle();
    let indices = file.add_view(&[0, 2]);
    let values = file.add_view(&[1; 24]);
    file.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    let indices = file.add_indices(5121, &[0, 1, 2, 1]);
    let primitives = file.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({ "attributes": { "POSITION": 0 }, "indices": indices, "mode": 5 }));
    let (good, bad) = fuzz("mutated.glb", &file.glb(), 3000);
    assert!(good > 100 && bad > 100, "{good} load, {bad} do not");

    let moving = crate::animations::animated(
        "translation",
        "VEC3",
        "CUBICSPLINE",
        &[0.0, 1.0],
        &[0.5; 18],
    );
    let (good, bad) = fuzz("moving.glb", &moving.glb(), 2000);
    assert!(good > 100 && bad > 100, "{good} load, {bad} do not");

    let text = "mtllib mutated.obj\no a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv .2 .1 0\nv 0 1 0\n\
                vn 0 0 1\nvt 0 0\nusemtl x\nf 1/1/1 2/1/1 3/1/1 4/1/1 -1\nnewmtl x\nKd 1 1 1\n\
                Ke 0 0 1\nPr .5\ng b\nf 1 2 3\nf -1 -2 -3\nv 1 1 1 .5 0 1\ns 1\nf 1 2 3 4\nf 2 3 6\ns off\n\
                usemtl X\nf 4 5 6\nnewmtl y\nd .5\nTr 1\nmap_Bump -bm 1 lost.png -s 2\nmap_Kd -q 1\nPs 1\n";
    let (good, bad) = fuzz("mutated.obj", text.as_bytes(), 2000);
    assert!(good > 100 && bad > 100, "{good} load, {bad} do not");
}
