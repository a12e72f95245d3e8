//! `KHR_draco_mesh_compression`. The streams were made by Google's Draco encoder with DracoPy 2.2.0: `DracoPy.encode` with
//! normals of 10 bits and texture coordinates of 12 bits, and the other arguments that each stream states.

use super::*;

/// Positions of 14 bits, `compression_level=7`: EdgeBreaker with predicted valences.
const HIGH: &[u8] = include_bytes!("high.drc");

/// Positions of 14 bits, `compression_level=1`: EdgeBreaker.
const LOW: &[u8] = include_bytes!("low.drc");

/// Positions of 11 bits, `compression_level=10, preserve_order=True`: no prediction of triangles.
const SEQUENTIAL: &[u8] = include_bytes!("sequential.drc");

/// The streams, each with the identifiers of positions, normals, texture coordinates and colours, and with the greatest error
/// of positions, half a step of the encoder, and a little for rounding.
const STREAMS: [(&[u8], [u32; 4], f32); 3] = [
    (HIGH, [3, 2, 1, 0], 2.0 / 16383.0 + 1e-6),
    (LOW, [3, 2, 1, 0], 2.0 / 16383.0 + 1e-6),
    (SEQUENTIAL, [3, 2, 1, 0], 2.0 / 2047.0 + 1e-6),
];

/// Greatest errors of normals of 10 bits and of texture coordinates of 12 bits.
const NORMAL_STEP: f32 = 0.005;
const UV_STEP: f32 = 0.0003;

/// A file whose primitive is the stream. Its accessors have no buffer views; its indices have the type `index_type`.
fn compressed(stream: &[u8], ids: [u32; 4], index_type: u32) -> Gltf {
    let mut file = base();
    let view = file.add_view(stream);
    let mut accessor = |kind: &str, component: u32, count: u32| {
        file.add_accessor(json!({
            "componentType": component, "count": count, "type": kind, "normalized": component == 5121,
        }))
    };
    let [positions, normals] = [0; 2].map(|_| accessor("VEC3", 5126, 20));
    let uvs = accessor("VEC2", 5126, 20);
    let colors = accessor("VEC3", 5121, 20);
    let indices = accessor("SCALAR", index_type, 72);
    file.json["accessors"][indices]["normalized"] = false.into();
    let [position, normal, uv, color] = ids;
    *file.primitive() = json!({
        "attributes": {
            "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs, "COLOR_0": colors,
        },
        "indices": indices,
        "material": 0,
        "extensions": { "KHR_draco_mesh_compression": {
            "bufferView": view,
            "attributes": {
                "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv, "COLOR_0": color,
            },
        } },
    });
    file.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    file
}

fn high() -> Gltf {
    let (stream, ids, _) = STREAMS[0];
    compressed(stream, ids, 5123)
}

fn compression(file: &mut Gltf) -> &mut serde_json::Value {
    &mut file.primitive()["extensions"]["KHR_draco_mesh_compression"]
}

#[test]
fn draco_meshes_equal_the_mesh_before_compression() {
    for (stream, ids, step) in STREAMS {
        for index_type in [5121, 5123, 5125] {
            let scene = load(&compressed(stream, ids, index_type));
            let [mesh] = &scene.meshes[..] else {
                panic!("one mesh")
            };
            assert_eq!(mesh.positions.len(), 20);
            check_triangles(mesh, step, 1);
            check_attributes(mesh, step, NORMAL_STEP, UV_STEP);
        }
    }
}

#[test]
fn draco_primitives_can_share_their_stream() {
    let mut file = high();
    let primitive = file.primitive().clone();
    // The second shares stream and accessors, the third only the stream, and the fourth is not compressed.
    let mut third = primitive.clone();
    third["attributes"]
        .as_object_mut()
        .unwrap()
        .remove("COLOR_0");
    let plain = json!({ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2 });
    file.json["meshes"][0]["primitives"] = json!([primitive, primitive, third, plain]);
    let scene = load(&file);
    let mesh = &scene.meshes[0];
    let counts: Vec<u32> = mesh.parts.iter().map(|part| part.triangle_count).collect();
    assert_eq!(counts, [24, 24, 24, 1]);
    assert_eq!(mesh.positions.len(), 63);
    let mut compressed = mesh.clone();
    compressed.triangles.truncate(72);
    check_triangles(&compressed, STREAMS[0].2, 3);
    assert_eq!(mesh.colors[60..], [Vec4::ONE; 3]);
}

#[test]
fn draco_data_precede_fallbacks_strips_and_counts() {
    let mut file = high();
    // The accessors of a fallback, which need not be right.
    for accessor in file.json["accessors"].as_array_mut().unwrap() {
        accessor["bufferView"] = 0.into();
        accessor["byteOffset"] = 4096.into();
    }
    for mode in [5, 6] {
        file.primitive()["mode"] = mode.into();
        check_triangles(&load(&file).meshes[0], STREAMS[0].2, 1);
    }
    // The data may have attributes that the primitive does not state.
    let mut file = high();
    let attributes = &mut compression(&mut file)["attributes"];
    *attributes = json!({ "POSITION": attributes["POSITION"] });
    let positions = file.primitive()["attributes"]["POSITION"].clone();
    file.primitive()["attributes"] = json!({ "POSITION": positions });
    file.json["materials"] = json!([{}]);
    check_triangles(&load(&file).meshes[0], STREAMS[0].2, 1);
    // The data decide how many vertices there are, but not without a limit.
    let stating = |count: u32| {
        high().with(|json| {
            let positions = json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].clone();
            json["accessors"][positions.as_u64().unwrap() as usize]["count"] = count.into();
        })
    };
    check_triangles(&load(&stating(10)).meshes[0], STREAMS[0].2, 1);
    let text = refuse(&stating(9));
    assert!(text.contains("more triangles or vertices than"), "{text}");
}

#[test]
fn draco_primitives_that_are_not_shown_are_not_decoded() {
    let mut file = high();
    let primitive = file.primitive().clone();
    let [mut points, mut without_positions] = [primitive.clone(), primitive.clone()];
    points["mode"] = 0.into();
    let attributes = without_positions["attributes"].as_object_mut().unwrap();
    attributes.remove("POSITION");
    for skipped in [&mut points, &mut without_positions] {
        skipped["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = 99.into();
    }
    file.json["meshes"][0]["primitives"] = json!([points, without_positions, primitive]);
    let scene = Folder::new().load("scene.glb", file.glb());
    check_triangles(&scene.meshes[0], STREAMS[0].2, 1);
    let expected = [
        "points and lines are skipped: mesh 0 \"leaf\" primitive 0",
        "primitives without positions are skipped: mesh 0 \"leaf\" primitive 1",
    ];
    assert_eq!(scene.notices, expected);
}

#[test]
fn wrong_draco_data_are_one_clear_line() {
    type Change = fn(&mut Gltf);
    let cases: [(Change, &str); 6] = [
        (
            |file| compression(file)["bufferView"] = 99.into(),
            "mesh 0 \"leaf\" primitive 0: bufferView 99 is out of range",
        ),
        (
            |file| compression(file)["bufferView"] = 0.into(),
            "its Draco data cannot be decoded",
        ),
        (
            |file| compression(file)["attributes"]["NORMAL"] = 77.into(),
            "its Draco data have no attribute 77, which should be its NORMAL",
        ),
        (
            |file| compression(file)["attributes"]["NORMAL"] = (1_u64 << 40).into(),
            "have no attribute 1099511627776",
        ),
        (
            |file| {
                let indices = file.primitive()["indices"].as_u64().unwrap() as usize;
                file.json["accessors"][indices]["count"] = 3.into();
            },
            "more triangles or vertices than its accessors state",
        ),
        (
            |file| {
                let indices = file.primitive()["indices"].as_u64().unwrap() as usize;
                file.json["accessors"][indices]["count"] = u64::MAX.into();
            },
            "unfolds to more than",
        ),
    ];
    for (change, named) in cases {
        let mut file = high();
        change(&mut file);
        let text = refuse(&file);
        assert!(text.contains(named), "{text:?} says {named:?}");
    }
}

#[test]
fn damaged_draco_data_are_refused_or_read() {
    for (stream, ids, _) in STREAMS {
        for length in 0..stream.len() {
            refuse(&compressed(&stream[..length], ids, 5123));
        }
        for at in 0..stream.len() {
            let mut changed = stream.to_vec();
            changed[at] ^= 0x5A;
            let file = compressed(&changed, ids, 5123);
            let folder = Folder::new();
            if let Err(error) = headwater::scene_files::load(&folder.write("scene.glb", file.glb()))
            {
                assert_eq!(error.exit_status(), 2, "{error}");
                assert_eq!(error.to_string().lines().count(), 1, "{error}");
            }
        }
    }
}
