//! Tests of valid glTF files.

use crate::files::{Folder, Gltf, floats};
use base64::prelude::{BASE64_STANDARD, Engine};
use glam::{DVec3, Vec3, Vec4};
use headwater::scene::camera::Projection;
use headwater::scene::{AlphaMode, Material, Scene};
use serde_json::json;

/// The corners of every triangle in world space, instance by instance.
fn corners(scene: &Scene) -> Vec<[DVec3; 3]> {
    scene
        .instances
        .iter()
        .flat_map(|instance| {
            let mesh = &scene.meshes[instance.mesh as usize];
            mesh.triangles.iter().map(|t| {
                t.map(|i| {
                    let p = mesh.positions[i as usize].as_dvec3();
                    instance.object_to_world.transform_point3(p)
                })
            })
        })
        .collect()
}

fn load(file: &Gltf) -> Scene {
    Folder::new().load("scene.glb", file.glb())
}

#[test]
fn a_plain_file_is_read_in_full() {
    let scene = load(&Gltf::triangle());
    assert_eq!(scene.name, "scene");
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    assert_eq!(scene.meshes[0].name, "leaf");
    assert_eq!(scene.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(scene.meshes[0].normals, [Vec3::Z; 3]);
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]]);
    assert_eq!(scene.materials[0].name, "paint");
    assert_eq!(scene.instances[0].name, "root");
    assert_eq!(scene.cameras[0].name, "eye");
    assert_eq!(scene.cameras[0].projection, Projection::pinhole(0.8));
    assert_eq!(scene.cameras[0].aspect_ratio, Some(1.5));
    let eye = scene.cameras[0].camera_to_world.translation;
    assert_eq!(eye, DVec3::new(0.0, 0.0, 5.0));
}

#[test]
fn buffers_may_be_inside_beside_or_in_the_uri() {
    let file = Gltf::triangle();
    let folder = Folder::new();
    let expected = load(&file).content_hash();
    folder.write("data ä.bin", [&file.binary[..], b"more"].concat());
    let beside = folder.load("a.gltf", file.with_uri("data%20%C3%A4.bin"));
    assert_eq!(beside.content_hash(), expected);
    let uri = format!(
        "data:application/octet-stream;base64,{}",
        BASE64_STANDARD.encode(&file.binary)
    );
    let inside = folder.load("b.gltf", file.with_uri(&uri));
    assert_eq!(inside.content_hash(), expected);
    let binary_named_gltf = folder.load("c.gltf", file.glb());
    assert_eq!(binary_named_gltf.content_hash(), expected);
    let upper = folder.load("D.GLB", file.glb());
    assert_eq!(upper.content_hash(), expected);
}

#[test]
fn every_index_type_is_read() {
    for component in [5121, 5123, 5125] {
        let mut file = Gltf::triangle();
        let indices = file.add_indices(component, &[2, 0, 1]);
        file.primitive()["indices"] = indices.into();
        let triangle = corners(&load(&file))[0];
        assert_eq!(triangle, [DVec3::Y, DVec3::ZERO, DVec3::X]);
    }
    let mut file = Gltf::triangle();
    file.primitive().as_object_mut().unwrap().remove("indices");
    assert_eq!(corners(&load(&file)), [[DVec3::ZERO, DVec3::X, DVec3::Y]]);
}

#[test]
fn strips_and_fans_keep_their_winding() {
    // A hexagon's rim for the fan, a zigzag for the strip, both facing +Z.
    let fan: Vec<[f32; 3]> = (0..6)
        .map(|i| (i as f32).sin_cos())
        .map(|(s, c)| [c, s, 0.0])
        .collect();
    let strip: Vec<[f32; 3]> = (0..6)
        .map(|i| [i as f32, (1 - i % 2) as f32, 0.0])
        .collect();
    for (mode, points) in [(5, strip), (6, fan)] {
        let mut file = Gltf::triangle();
        let positions = file.add_vectors(&points);
        *file.primitive() = json!({ "attributes": { "POSITION": positions }, "mode": mode });
        let scene = load(&file);
        let triangles = corners(&scene);
        assert_eq!(triangles.len(), 4);
        for [a, b, c] in triangles {
            assert!((b - a).cross(c - a).z > 0.0, "mode {mode}: {a} {b} {c}");
        }
        assert!(scene.meshes[0].normals.is_empty());
        assert_eq!(scene.materials.len(), 2, "the default material");
        assert_eq!(scene.materials[1], Material::default());
    }
}

#[test]
fn strides_and_sparse_values_are_followed() {
    let mut file = Gltf::triangle();
    // Interleaved with 8 bytes of something else, after 4 bytes of offset.
    let mut bytes = vec![9; 4];
    for p in [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0_f32]] {
        bytes.extend(floats(&[p]));
        bytes.extend([7; 8]);
    }
    bytes.truncate(bytes.len() - 8);
    let view = file.add_view(&bytes);
    file.json["bufferViews"][view]["byteStride"] = 20.into();
    let values = file.add_view(&floats(&[[5.0, 0.0, 1.0]]));
    let indices = file.add_view(&[1]);
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    let positions = file.add_accessor(json!({
        "bufferView": view, "byteOffset": 4, "componentType": 5126, "count": 3, "type": "VEC3",
        "sparse": sparse,
    }));
    file.primitive()["attributes"]["POSITION"] = positions.into();
    let scene = load(&file);
    let expected = [[0.0, 0.0, 1.0], [5.0, 0.0, 1.0], [0.0, 1.0, 1.0]].map(Vec3::from_array);
    assert_eq!(scene.meshes[0].positions, expected);

    // Without a view the others are zero: here the triangle is without area then.
    file.json["accessors"][positions]["bufferView"] = json!(null);
    let scene = load(&file);
    assert!(scene.meshes.is_empty());
    assert_eq!(scene.notices.len(), 3, "{:?}", scene.notices);
    assert!(scene.notices[0].contains("without area"));
}

#[test]
fn nodes_are_composed_and_share_meshes() {
    let file = Gltf::triangle().with(|json| {
        json["nodes"] = json!([
            { "name": "all", "children": [2, 1], "scale": [-2, 1, 3], "translation": [10, 0, 0] },
            { "name": "one", "mesh": 0, "rotation": [0, 0, 1, 1] },
            { "name": "two", "mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,1e-3,1] },
        ]);
        json["scenes"] = json!([{ "nodes": [0] }]);
    });
    let scene = load(&file);
    assert_eq!(scene.meshes.len(), 1);
    let names: Vec<&str> = scene.instances.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(names, ["two", "one"]);
    let triangles = corners(&scene);
    assert_eq!(triangles[0][1], DVec3::new(8.0, 0.0, 3e-3));
    assert!((triangles[1][1] - DVec3::new(10.0, 1.0, 0.0)).length() < 1e-12);
    assert!(scene.instances[0].object_to_world.matrix3.determinant() < 0.0);
}

#[test]
fn positions_far_from_the_origin_keep_their_digits() {
    let far = DVec3::new(5_000_000.123, -4_999_999.877, 0.1);
    let file = Gltf::triangle().with(|json| {
        json["nodes"][0]["translation"] = json!(far.to_array());
        json["nodes"][1] = json!({
            "camera": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, far.x, far.y, far.z, 1],
        });
    });
    let scene = load(&file);
    assert_eq!(scene.instances[0].object_to_world.translation, far);
    assert_eq!(scene.cameras[0].camera_to_world.translation, far);
}

#[test]
fn what_is_ignored_may_be_anything() {
    let plain = load(&Gltf::triangle()).content_hash();
    let file = Gltf::triangle().with(|json| {
        json["animations"] = json!([{ "channels": [{ "target": { "path": "pointer" } }] }]);
        json["samplers"] = json!([{ "magFilter": -1 }]);
        json["extras"] = json!([null]);
        json["materials"][0]["extras"] = "text".into();
        json["materials"][0]["extensions"] = json!({ "KHR_materials_clearcoat": [] });
    });
    assert_eq!(load(&file).content_hash(), plain);
}

#[test]
fn flat_nodes_are_skipped() {
    let file = Gltf::triangle().with(|json| {
        json["nodes"][0]["scale"] = json!([1, 0, 1]);
        json["nodes"][1]["scale"] = json!([0, 0, 0]);
    });
    let scene = load(&file);
    assert!(scene.instances.is_empty() && scene.cameras.is_empty());
    assert_eq!(scene.notices.len(), 3, "{:?}", scene.notices);
    assert!(scene.notices[1].contains("instance 0 \"root\""));
}

#[test]
fn the_default_scene_is_the_named_or_the_first_or_all() {
    let nodes = json!([
        { "name": "a", "mesh": 0 }, { "name": "b", "mesh": 0, "children": [2] },
        { "name": "c", "mesh": 0 },
    ]);
    for (scene, scenes, count) in [
        (json!(1), json!([{ "nodes": [0] }, { "nodes": [1] }]), 2),
        (json!(null), json!([{ "nodes": [0] }, { "nodes": [1] }]), 1),
        (json!(null), json!([]), 3),
        (json!(0), json!([{ "name": "empty" }]), 0),
    ] {
        let file = Gltf::triangle().with(|json| {
            json["nodes"] = nodes.clone();
            json["scene"] = scene;
            json["scenes"] = scenes;
        });
        assert_eq!(load(&file).instances.len(), count);
    }
}

#[test]
fn very_deep_hierarchies_do_not_overflow_the_stack() {
    let depth = 100_000;
    let file = Gltf::triangle().with(|json| {
        let mut nodes: Vec<_> = (1..depth)
            .map(|child| json!({ "children": [child], "translation": [0, 0, 1] }))
            .collect();
        nodes.push(json!({ "mesh": 0 }));
        json["nodes"] = nodes.into();
        json["scenes"] = json!([{ "nodes": [0] }]);
    });
    let scene = load(&file);
    let z = scene.instances[0].object_to_world.translation.z;
    assert_eq!(z, f64::from(depth - 1));
}

#[test]
fn material_factors_are_read() {
    let file = Gltf::triangle().with(|json| {
        json["materials"] = json!([{
            "name": "lamp",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
                "metallicFactor": 0.5, "roughnessFactor": 0.25,
            },
            "emissiveFactor": [1, 0.5, 0],
            "doubleSided": true,
            "extensions": {
                "KHR_materials_emissive_strength": { "emissiveStrength": 8 },
                "KHR_materials_specular": {
                    "specularFactor": 0.75, "specularColorFactor": [2, 1, 0],
                },
                "KHR_materials_ior": { "ior": 1.25 },
            },
        }]);
        json["extensionsUsed"] = json!(["KHR_materials_ior"]);
        json["extensionsRequired"] = json!(["KHR_materials_ior"]);
    });
    let scene = load(&file);
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    let expected = Material {
        name: "lamp".into(),
        base_color: Vec3::new(0.1, 0.2, 0.3),
        alpha: 0.4,
        metallic: 0.5,
        roughness: 0.25,
        specular: 0.75,
        specular_color: Vec3::new(2.0, 1.0, 0.0),
        ior: 1.25,
        emission: Vec3::new(8.0, 4.0, 0.0),
        double_sided: true,
        ..Material::default()
    };
    assert_eq!(scene.materials[0], expected);
    assert_eq!(scene.emissive_triangle_count(), 1);
}

#[test]
fn primitives_become_parts_and_missing_normals_are_flat() {
    let mut file = Gltf::triangle();
    let primitives = json!([
        { "attributes": { "POSITION": 0 }, "indices": 2, "material": 0 },
        { "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2 },
        { "attributes": { "POSITION": 0 }, "mode": 0 },
        { "attributes": { "NORMAL": 1 } },
    ]);
    file.json["meshes"][0]["primitives"] = primitives;
    let scene = load(&file);
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.normals, [Vec3::Z; 6]);
    let materials: Vec<u32> = mesh.parts.iter().map(|part| part.material).collect();
    assert_eq!(materials, [0, 1]);
    assert_eq!(
        scene.notices,
        [
            "points and lines are skipped: mesh 0 \"leaf\" primitive 2",
            "primitives without positions are skipped: mesh 0 \"leaf\" primitive 3",
            "vertices without a usable normal take the geometric one: 3 times, first mesh 0 \"leaf\"",
        ]
    );
}

/// Loads a mesh of two primitives with the same three positions. The first one (or, if not `first`, the second one) also has
/// `attribute`.
fn mixed(attribute: &str, accessor: usize, first: bool, file: &Gltf) -> Scene {
    let with = json!({ "POSITION": 0, attribute: accessor });
    let without = json!({ "POSITION": 0 });
    let attributes = if first {
        [with, without]
    } else {
        [without, with]
    };
    load(&file.with(|json| {
        json["materials"] = json!([{ "name": "a" }, { "name": "b" }]);
        json["meshes"][0]["primitives"] = (attributes.into_iter().enumerate())
            .map(|(i, attributes)| json!({ "attributes": attributes, "indices": 2, "material": i }))
            .collect();
    }))
}

#[test]
fn normals_of_some_primitives_stay_with_them() {
    let mut file = Gltf::triangle();
    let tilted = Vec3::new(0.0, 0.6, 0.8);
    let normals = file.add_vectors(&[tilted.to_array(); 3]);
    for (first, expected) in [
        (true, [[tilted; 3], [Vec3::Z; 3]]),
        (false, [[Vec3::Z; 3], [tilted; 3]]),
    ] {
        let scene = mixed("NORMAL", normals, first, &file);
        let mesh = &scene.meshes[0];
        let normals = (mesh.triangles.iter()).map(|t| t.map(|i| mesh.normals[i as usize]));
        assert_eq!(normals.collect::<Vec<_>>(), expected);
    }
}

#[test]
fn colours_of_some_primitives_stay_with_them() {
    let mut file = Gltf::triangle();
    let view = file.add_view(&[255, 0, 51, 255].repeat(3));
    let colours = file.add_accessor(json!({
        "bufferView": view, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4",
    }));
    let red = Vec4::new(1.0, 0.0, 0.2, 1.0);
    for (first, expected) in [(true, [red, Vec4::ONE]), (false, [Vec4::ONE, red])] {
        let scene = mixed("COLOR_0", colours, first, &file);
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert_eq!(corners(&scene), [triangle, triangle]);
        let found = scene.meshes[0].colors.chunks(3);
        assert!(found.eq(expected.map(|color| [color; 3])));
    }
}

/// Attributes may be floats, or integers of every type that KHR_mesh_quantization has.
#[test]
fn attributes_may_be_integers() {
    let cases: [(u32, bool, [u8; 6], [f32; 3]); 6] = [
        (5120, true, [127, 0, 129, 0, 0, 0], [1.0, 0.0, -1.0]),
        (5120, false, [127, 0, 129, 0, 0, 0], [127.0, 0.0, -127.0]),
        (5121, true, [255, 0, 51, 0, 0, 0], [1.0, 0.0, 0.2]),
        (5122, true, [255, 127, 0, 0, 0, 128], [1.0, 0.0, -1.0]),
        (5123, true, [255, 255, 0, 0, 51, 51], [1.0, 0.0, 0.2]),
        (5123, false, [1, 1, 2, 0, 0, 0], [257.0, 2.0, 0.0]),
    ];
    for (component, normalized, bytes, expected) in cases {
        let mut file = Gltf::triangle();
        let size = if component < 5122 { 1 } else { 2 };
        // Each element begins at a multiple of four bytes.
        let stride = 4 * size;
        let mut points = vec![0; 3 * stride];
        points[..3 * size].copy_from_slice(&bytes[..3 * size]);
        points[stride] = 3;
        points[2 * stride + size] = 5;
        let view = file.add_view(&points);
        file.json["bufferViews"][view]["byteStride"] = stride.into();
        let positions = file.add_accessor(json!({
            "bufferView": view, "componentType": component, "normalized": normalized, "count": 3,
            "type": "VEC3",
        }));
        file.primitive()["attributes"] = json!({ "POSITION": positions });
        file.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let scene = load(&file);
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
        let found = scene.meshes[0].positions[0];
        assert_eq!(found.to_array(), expected, "{component} {normalized}");
    }
}

#[test]
fn unused_vertices_of_shared_accessors_are_left_out() {
    let mut file = Gltf::triangle();
    let mut points = vec![[9.0, 9.0, 9.0]; 1000];
    points.extend([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let positions = file.add_vectors(&points);
    let indices = file.add_indices(5123, &[1000, 1001, 1002]);
    *file.primitive() = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    assert_eq!(load(&file).meshes[0].positions.len(), 3);
}

#[test]
fn what_is_ignored_is_said_once() {
    let file = Gltf::triangle().with(|json| {
        json["extensionsUsed"] = json!(["KHR_materials_sheen", "KHR_materials_clearcoat"]);
        let textured = json!({
            "occlusionTexture": { "index": 0 },
        });
        json["materials"] = json!([
            { "name": "paint", "alphaMode": "GLASS" }, textured.clone(), textured,
        ]);
        json["nodes"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "camera": 1 }));
        json["scenes"][0]["nodes"] = json!([0, 1, 2]);
        json["cameras"].as_array_mut().unwrap().push(json!({
            "type": "orthographic",
            "orthographic": { "xmag": -1, "ymag": 1, "znear": 0, "zfar": 1 },
        }));
    });
    let scene = load(&file);
    assert_eq!(scene.cameras.len(), 1);
    assert_eq!(
        scene.notices,
        [
            "extensions that are not supported are ignored: KHR_materials_sheen, KHR_materials_clearcoat",
            "textures that are not supported are ignored: occlusion (2)",
            "alpha modes that are unknown are taken as OPAQUE: material 0 \"paint\" has \"GLASS\"",
            "cameras with a negative xmag or ymag, which mirrors the picture, are skipped: camera 1 of node 2",
        ]
    );
}

#[test]
fn orthographic_cameras_have_half_of_their_extents() {
    let with = |xmag: serde_json::Value, ymag: serde_json::Value| {
        Gltf::triangle().with(|json| {
            // Scale does not count, as with perspective cameras.
            json["nodes"][1]["scale"] = json!([3, 3, 3]);
            json["cameras"][0] = json!({
                "type": "orthographic",
                "orthographic": { "xmag": xmag, "ymag": ymag, "znear": 1, "zfar": 2 },
            });
        })
    };
    let scene = load(&with(json!(3), json!(1.5)));
    let camera = &scene.cameras[0];
    assert_eq!(camera.projection, Projection::Orthographic { height: 3.0 });
    assert_eq!(camera.aspect_ratio, Some(2.0));
    assert_eq!(
        camera.camera_to_world.translation,
        DVec3::new(0.0, 0.0, 5.0)
    );
    let folder = Folder::new();
    for (xmag, ymag, said) in [
        (json!(0), json!(1), "xmag is 0"),
        (json!(1), json!(0.0), "ymag is 0"),
        (json!(1), json!(1e300), "ymag is 1e300"),
        (json!(5e-324), json!(4), "xmag / ymag is 0"),
        (json!("wide"), json!(1), "f64"),
        (json!(1), json!(null), "f64"),
    ] {
        let text = folder.refuse("camera.glb", with(xmag, ymag).glb());
        assert!(text.contains(said), "{text}");
    }
}

#[test]
fn surfaces_of_an_unknown_alpha_mode_are_opaque() {
    let file = Gltf::triangle().with(|json| json["materials"][0]["alphaMode"] = "GLASS".into());
    assert_eq!(
        load(&file).notices,
        ["alpha modes that are unknown are taken as OPAQUE: material 0 \"paint\" has \"GLASS\""]
    );
}

#[test]
fn cameras_are_rigid_whatever_their_node() {
    let file = Gltf::triangle().with(|json| {
        json["nodes"][1] = json!({ "camera": 0, "scale": [3, -2, 5], "translation": [1, 2, 3] });
        json["cameras"][0]["name"] = "lens".into();
    });
    let camera = &load(&file).cameras[0];
    assert_eq!(camera.name, "lens");
    let axes = camera.camera_to_world.matrix3;
    assert!((axes.transpose() * axes).abs_diff_eq(glam::DMat3::IDENTITY, 1e-12));
    assert!((axes.determinant() - 1.0).abs() < 1e-12);
    assert_eq!(axes.z_axis, DVec3::Z);
    assert_eq!(
        camera.camera_to_world.translation,
        DVec3::new(1.0, 2.0, 3.0)
    );
}

#[test]
fn an_empty_file_is_an_empty_scene() {
    let folder = Folder::new();
    let scene = folder.load("empty.gltf", r#"{ "asset": { "version": "2.0" } }"#);
    assert!(scene.instances.is_empty());
    assert_eq!(scene.notices.len(), 1);
}

#[test]
fn alpha_is_read_with_its_cutoff() {
    let with = |material: serde_json::Value| {
        let file = Gltf::triangle().with(|json| json["materials"] = json!([material]));
        let scene = load(&file);
        (scene.materials[0].clone(), scene.notices)
    };
    let factor = json!({ "baseColorFactor": [1, 1, 1, 0.25] });
    for (mode, expected) in [
        (
            json!({ "alphaMode": "MASK" }),
            AlphaMode::Mask { cutoff: 0.5 },
        ),
        (
            json!({ "alphaMode": "MASK", "alphaCutoff": 0.1 }),
            AlphaMode::Mask { cutoff: 0.1 },
        ),
        // Nothing is cut out.
        (
            json!({ "alphaMode": "MASK", "alphaCutoff": 0 }),
            AlphaMode::Opaque,
        ),
        (json!({ "alphaMode": "BLEND" }), AlphaMode::Blend),
        (json!({ "alphaMode": "OPAQUE" }), AlphaMode::Opaque),
        (json!({}), AlphaMode::Opaque),
    ] {
        let mut material = mode;
        material["pbrMetallicRoughness"] = factor.clone();
        let (found, notices) = with(material);
        assert_eq!((found.alpha, found.alpha_mode), (0.25, expected));
        assert!(notices.is_empty(), "{notices:?}");
    }
    let (_, notices) = with(json!({ "alphaMode": "BLEND", "emissiveFactor": [1, 1, 1] }));
    assert!(notices.is_empty(), "{notices:?}");
    let file = Gltf::triangle().with(|json| {
        json["materials"] = json!([{ "alphaMode": "MASK", "alphaCutoff": -1 }]);
    });
    let text = Folder::new().refuse("scene.glb", file.glb());
    assert!(text.contains("alpha cutoff"), "{text}");
}

/// An unlit material keeps its base colour and alpha only. Its other values are for readers that do not know the extension.
#[test]
fn unlit_materials_keep_their_colour_only() {
    let file = Gltf::triangle().with(|json| {
        json["materials"] = json!([{
            "name": "sign",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
                "metallicFactor": 0.5, "roughnessFactor": 0.25,
                "metallicRoughnessTexture": { "index": 7 },
            },
            "normalTexture": { "index": 7 },
            "emissiveTexture": { "index": 7 },
            "emissiveFactor": [1, 0.5, 0],
            "alphaMode": "BLEND",
            "doubleSided": true,
            "extensions": { "KHR_materials_unlit": {} },
        }]);
        json["extensionsRequired"] = json!(["KHR_materials_unlit"]);
        // A light that is not one.
        json["animations"] = json!([{
            "channels": [{ "sampler": 0, "target": { "path": "pointer", "extensions": {
                "KHR_animation_pointer": { "pointer": "/materials/0/emissiveFactor" },
            } } }],
            "samplers": [{ "input": 0, "output": 0 }],
        }]);
    });
    let scene = load(&file);
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    let expected = Material {
        alpha: 0.4,
        alpha_mode: AlphaMode::Blend,
        double_sided: true,
        ..Material::unlit("sign", Vec3::new(0.1, 0.2, 0.3))
    };
    assert_eq!(scene.materials[0], expected);
    assert_eq!(scene.emissive_triangle_count(), 0);
    // It is seen without any light.
    assert_eq!(scene.why_black(true, [0.0]), None);
}
