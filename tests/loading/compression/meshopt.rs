//! `EXT_meshopt_compression` and `KHR_meshopt_compression`. Most streams are encoded here; some were made by the reference
//! implementation with the package `meshoptimizer` 0.2.30a0 for Python.

use super::*;
use glam::Quat;
use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{
    ExpMode, IndexEncoding, VertexEncoding, encode_filter_color, encode_filter_exp,
    encode_filter_oct, encode_filter_quat, encode_index_buffer, encode_index_sequence,
    encode_vertex_buffer,
};

/// The positions of the grid, by `encode_vertex_buffer` of the reference.
const REFERENCE_POSITIONS: &str = "\
    oAAABQDAwMD//4DAAAAAgAEAwIAAfgAABwD//4B///+Af///gH///4D/AAAAf///gAU4+Pj4fn9+f35/fvgAAAB/fgAABQAP////gID//4B/f/\
    +gzwAAAOD/gAUAMPj4fHt8fXzwAAAAfX4AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA==";

/// The triangles of the grid, by `encode_index_buffer` of the reference.
const REFERENCE_TRIANGLES: &str = "\
    4f4eAB4AHp4OBB4DHp4OAx4DHp4OAx4DHvAIAHaHVmd4qYZliWiYAWkAAA==";

/// The triangles of the grid, by `encode_index_sequence` of the reference.
const REFERENCE_SEQUENCE: &str = "\
    0QAQCgAMBA4QCgAMBA4QCgAMBAoQCgAMBA4QCgAMBA4QCgAMBAoQCgAMBA4QCgAMBA4QCgAMBAoQCgAMBA4QCgAMBA4QCgAMBAAAAAA=";

const EXT: &str = "EXT_meshopt_compression";
const KHR: &str = "KHR_meshopt_compression";

/// A compressed list of elements.
struct Compressed {
    bytes: Vec<u8>,
    mode: &'static str,
    filter: Option<&'static str>,
    count: usize,
    stride: usize,
}

/// Elements in the first version of the codec, after the conversion of a filter.
fn attributes(elements: &[u8], stride: usize, filter: Option<&'static str>) -> Compressed {
    let count = elements.len() / stride;
    let version = VertexEncoding::new(0, 0).unwrap();
    let bytes = encode_vertex_buffer(elements, count, stride, version, &mut Workspace::default());
    Compressed {
        bytes: bytes.unwrap(),
        mode: "ATTRIBUTES",
        filter,
        count,
        stride,
    }
}

fn positions() -> Vec<u8> {
    let numbers = vertices().flat_map(|of| position(of).to_array());
    numbers.flat_map(f32::to_le_bytes).collect()
}

fn triangles(stride: usize) -> Compressed {
    let bytes = encode_index_buffer(
        &indices(),
        IndexEncoding::DEFAULT,
        &mut Workspace::default(),
    );
    Compressed {
        bytes: bytes.unwrap(),
        mode: "TRIANGLES",
        filter: None,
        count: 72,
        stride,
    }
}

/// A file with a second buffer, which is only a fallback: it has no bytes.
fn with_fallback(extension: &str) -> Gltf {
    let mut file = base();
    let buffers = file.json["buffers"].as_array_mut().unwrap();
    buffers.push(json!({
        "byteLength": 1_u64 << 40, "extensions": { extension: { "fallback": true } },
    }));
    file.json["extensionsUsed"] = json!([extension]);
    file.json["extensionsRequired"] = json!([extension]);
    file
}

impl Compressed {
    /// Appends the list to the file, with an accessor of this type, and returns the index of the accessor.
    fn add(&self, file: &mut Gltf, extension: &str, kind: &str, component: u32) -> usize {
        let source = file.add_view(&self.bytes);
        let source = file.json["bufferViews"][source].clone();
        let view = file.add_view(&[]);
        let mut compression = json!({
            "buffer": 0, "byteOffset": source["byteOffset"], "byteLength": source["byteLength"],
            "byteStride": self.stride, "count": self.count, "mode": self.mode,
        });
        if let Some(filter) = self.filter {
            compression["filter"] = filter.into();
        }
        let found = &mut file.json["bufferViews"][view];
        *found = json!({
            "buffer": 1, "byteOffset": 4096, "byteLength": self.stride * self.count,
            "extensions": { extension: compression },
        });
        if self.mode == "ATTRIBUTES" {
            found["byteStride"] = self.stride.into();
        }
        file.add_accessor(json!({
            "bufferView": view, "componentType": component, "count": self.count, "type": kind,
            "normalized": !matches!(component, 5125 | 5126) && self.mode == "ATTRIBUTES",
        }))
    }
}

/// The grid with compressed positions and indices.
fn grid(extension: &str, positions: &Compressed, indices: &Compressed) -> Gltf {
    let mut file = with_fallback(extension);
    let positions = positions.add(&mut file, extension, "VEC3", 5126);
    let index_type = if indices.stride == 2 { 5123 } else { 5125 };
    let indices = indices.add(&mut file, extension, "SCALAR", index_type);
    *file.primitive() = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    file
}

#[test]
fn meshopt_modes_equal_the_mesh_before_compression() {
    let version_1 = encode_vertex_buffer(
        &positions(),
        20,
        12,
        VertexEncoding::DEFAULT,
        &mut Workspace::default(),
    );
    let version_1 = Compressed {
        bytes: version_1.unwrap(),
        ..attributes(&positions(), 12, None)
    };
    let reference = Compressed {
        bytes: BASE64.decode(REFERENCE_POSITIONS).unwrap(),
        ..attributes(&positions(), 12, Some("NONE"))
    };
    let sequence = |bytes: Vec<u8>, stride| Compressed {
        bytes,
        mode: "INDICES",
        filter: None,
        count: 72,
        stride,
    };
    let own = encode_index_sequence(
        &indices(),
        IndexEncoding::DEFAULT,
        &mut Workspace::default(),
    );
    let reference_triangles = Compressed {
        bytes: BASE64.decode(REFERENCE_TRIANGLES).unwrap(),
        ..triangles(4)
    };
    for positions in [&attributes(&positions(), 12, None), &version_1, &reference] {
        for indices in [
            &triangles(2),
            &triangles(4),
            &reference_triangles,
            &sequence(own.clone().unwrap(), 2),
            &sequence(BASE64.decode(REFERENCE_SEQUENCE).unwrap(), 4),
        ] {
            for extension in [EXT, KHR] {
                let scene = load(&grid(extension, positions, indices));
                check_triangles(&scene.meshes[0], 0.0, 1);
                assert_eq!(scene.meshes[0].positions.len(), 20);
            }
        }
    }
}

#[test]
fn meshopt_index_sequences_keep_the_order_of_strips() {
    let strip = [0, 1, 4, 5, 8, 9];
    let bytes = encode_index_sequence(&strip, IndexEncoding::DEFAULT, &mut Workspace::default());
    let strip = Compressed {
        bytes: bytes.unwrap(),
        mode: "INDICES",
        filter: None,
        count: 6,
        stride: 2,
    };
    let mut file = grid(EXT, &attributes(&positions(), 12, None), &strip);
    file.primitive()["mode"] = 5.into();
    let mesh = &load(&file).meshes[0];
    let identities = identify(mesh, 0.0);
    let found = mesh
        .triangles
        .iter()
        .map(|t| t.map(|i| identities[i as usize]));
    let expected = vec![[0, 1, 4], [1, 5, 4], [4, 5, 8], [5, 9, 8]];
    assert_eq!(sorted(found.collect()), expected);
}

#[test]
fn meshopt_filters_give_normals_colors_and_positions() {
    let workspace = &mut Workspace::default();
    let normals: Vec<f32> = vertices()
        .flat_map(|of| normal(of).extend(0.0).to_array())
        .collect();
    let colors: Vec<f32> = vertices()
        .flat_map(|of| {
            color(of)
                .map(|byte| f32::from(byte) / 255.0)
                .into_iter()
                .chain([1.0])
        })
        .collect();
    let floats: Vec<f32> = vertices().flat_map(|of| position(of).to_array()).collect();
    let exponential = encode_filter_exp(20, 12, 15, &floats, ExpMode::Separate, workspace).unwrap();
    for (stride, component, step) in [(4, 5120, 0.02), (8, 5122, 1e-4)] {
        let bits = 2 * stride as u32;
        let octahedral = encode_filter_oct(20, stride, bits, &normals, workspace).unwrap();
        let rgba = encode_filter_color(20, stride, bits, &colors, workspace).unwrap();
        let positions = attributes(&exponential, 12, Some("EXPONENTIAL"));
        let mut file = grid(KHR, &positions, &triangles(2));
        let octahedral = attributes(&octahedral, stride, Some("OCTAHEDRAL"));
        let octahedral = octahedral.add(&mut file, KHR, "VEC3", component);
        let rgba = attributes(&rgba, stride, Some("COLOR"));
        let rgba = rgba.add(&mut file, KHR, "VEC4", component + 1);
        file.primitive()["attributes"]["NORMAL"] = octahedral.into();
        file.primitive()["attributes"]["COLOR_0"] = rgba.into();
        let mesh = &load(&file).meshes[0];
        check_triangles(mesh, 0.0, 1);
        let all: Vec<_> = vertices().collect();
        for (vertex, identity) in identify(mesh, 0.0).into_iter().enumerate() {
            let of = all[identity];
            let error = mesh.normals[vertex].distance(normal(of));
            assert!(error <= step, "normal of {of:?}: {error}");
            let [r, g, b] = color(of).map(|byte| f32::from(byte) / 255.0);
            let error = mesh.colors[vertex].distance(Vec4::new(r, g, b, 1.0));
            assert!(error <= step, "colour of {of:?}: {error}");
        }
    }
}

#[test]
fn meshopt_quaternions_turn_instances() {
    let rotations = [
        Quat::IDENTITY,
        Quat::from_rotation_x(1.0),
        Quat::from_xyzw(-0.5, 0.5, -0.5, 0.5),
        Quat::from_rotation_y(-3.0),
    ];
    let numbers: Vec<f32> = rotations.iter().flat_map(|q| q.to_array()).collect();
    let encoded = encode_filter_quat(4, 8, 16, &numbers, &mut Workspace::default()).unwrap();
    let mut file = grid(EXT, &attributes(&positions(), 12, None), &triangles(2));
    let encoded = attributes(&encoded, 8, Some("QUATERNION"));
    let rotation = encoded.add(&mut file, EXT, "VEC4", 5122);
    file.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "ROTATION": rotation } } });
    let scene = load(&file);
    assert_eq!(scene.instances.len(), 4);
    for (instance, rotation) in scene.instances.iter().zip(rotations) {
        let found = instance.object_to_world.matrix3.as_mat3();
        let error = (found - glam::Mat3::from_quat(rotation))
            .abs()
            .to_cols_array();
        let error = error.into_iter().fold(0.0, f32::max);
        assert!(error < 2e-4, "{rotation}: {error}");
    }
}

#[test]
fn wrong_meshopt_data_are_one_clear_line() {
    let whole = grid(EXT, &attributes(&positions(), 12, None), &triangles(2));
    let positions = whole.json["bufferViews"].as_array().unwrap().len() - 3;
    for (key, value, named) in [
        ("mode", json!("POINTS"), "has the unknown mode \"POINTS\""),
        ("filter", json!("BLUR"), "has the unknown filter \"BLUR\""),
        ("filter", json!("QUATERNION"), "cannot be decoded"),
        ("buffer", json!(9), "buffer 9 is out of range"),
        ("buffer", json!(1), "but buffer 1 has 0"),
        ("byteLength", json!(1 << 20), "but buffer 0 has"),
        ("byteLength", json!(40), "cannot be decoded"),
        ("byteStride", json!(13), "cannot be decoded"),
        ("byteStride", json!(0), "cannot be decoded"),
        ("count", json!(1 << 20), "cannot be decoded"),
        ("count", json!(1_u64 << 60), "unfolds to more than"),
        ("count", json!(19), "bufferView"),
    ] {
        let text = refuse(&whole.with(|json| {
            json["bufferViews"][positions]["extensions"][EXT][key] = value.clone();
        }));
        assert!(
            text.contains(named),
            "{key} {value}: {text:?} says {named:?}"
        );
        assert!(text.contains("bufferView"), "{text}");
    }
    // Only compressed views may refer to a fallback.
    let text = refuse(&whole.with(|json| {
        json["bufferViews"][positions]["extensions"] = json!({});
    }));
    assert!(text.contains("but buffer 1 has 0"), "{text}");
}

#[test]
fn damaged_meshopt_data_are_refused_or_read() {
    let whole = grid(EXT, &attributes(&positions(), 12, None), &triangles(2));
    let first = whole.json["bufferViews"].as_array().unwrap().len() - 4;
    let first = whole.json["bufferViews"][first]["byteOffset"]
        .as_u64()
        .unwrap() as usize;
    for at in first..whole.binary.len() {
        let mut file = whole.clone();
        file.binary[at] ^= 0x5A;
        let folder = Folder::new();
        if let Err(error) = headwater::scene_files::load(&folder.write("scene.glb", file.glb())) {
            assert_eq!(error.exit_status(), 2, "{error}");
            assert_eq!(error.to_string().lines().count(), 1, "{error}");
        }
    }
}
