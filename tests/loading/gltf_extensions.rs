//! Tests of glTF extensions that decide which meshes a scene shows, how often, and with which materials.

use crate::files::{Folder, Gltf};
use glam::Vec3;
use headwater::scene::layers::{Anisotropy, Coat, Transmission, Volume};
use headwater::scene::{Layers, Scene};
use headwater::scene_files::{Options, load_watched};
use serde_json::{Value, json};

fn load(file: &Gltf) -> Scene {
    Folder::new().load("scene.glb", file.glb())
}

/// Three instances: their translations, and their rotations as normalized integers of 16 bits.
const PLACES: [[f32; 3]; 3] = [[1.0, 2.0, 3.0], [0.5, 0.0, -4.0], [0.0, 0.0, 0.1]];
const ROTATIONS: [[i16; 4]; 3] = [[0, 0, 0, 32767], [0, 23170, 0, 23170], [32767, 0, 0, 0]];
const SIZES: [[f32; 3]; 3] = [[1.0, 1.0, 1.0], [2.0, 3.0, 4.0], [-1.0, 0.5, 0.25]];

/// The triangle at three places relative to the node 0, which is turned, moved and scaled: by the extension if `instanced`,
/// and otherwise by children of the node.
fn copies(instanced: bool) -> Gltf {
    let mut file = Gltf::triangle();
    let translations = file.add_vectors(&PLACES);
    let bytes = ROTATIONS
        .as_flattened()
        .iter()
        .flat_map(|c| c.to_le_bytes());
    let view = file.add_view(&bytes.collect::<Vec<u8>>());
    let rotations = file.add_accessor(json!({
        "bufferView": view, "componentType": 5122, "normalized": true, "count": 3, "type": "VEC4",
    }));
    let scales = file.add_vectors(&SIZES);
    file.with(|json| {
        let mut node = json!({
            "name": "leaf", "translation": [10, 20, 30], "rotation": [0.6, 0, 0, 0.8], "scale": [1, 2, 1],
        });
        if instanced {
            node["mesh"] = 0.into();
            node["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": {
                "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": 99,
            } } });
            json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
            json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
        } else {
            let parts = PLACES.iter().zip(ROTATIONS).zip(SIZES);
            json["nodes"].as_array_mut().unwrap().extend(parts.map(|((place, rotation), size)| {
                json!({
                    "name": "leaf", "mesh": 0, "translation": place, "scale": size,
                    "rotation": rotation.map(|c| f64::from(c) / 32767.0),
                })
            }));
            node["children"] = json!([2, 3, 4]);
        }
        json["nodes"][0] = node;
    })
}

#[test]
fn instances_are_as_children_of_their_node() {
    let scene = load(&copies(true));
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    assert_eq!((scene.instances.len(), scene.meshes.len()), (3, 1));
    let by_nodes = load(&copies(false));
    assert_eq!(scene.content_hash(), by_nodes.content_hash());
    for (instance, other) in scene.instances.iter().zip(&by_nodes.instances) {
        assert_eq!(instance.object_to_world, other.object_to_world);
        assert_eq!(instance.name, other.name);
    }
}

#[test]
fn instances_move_with_their_node() {
    let moving = |instanced| {
        let mut file = copies(instanced);
        let times = file.add_view(&[0.0_f32, 2.0].map(f32::to_le_bytes).concat());
        let times = file.add_accessor(json!({
            "bufferView": times, "componentType": 5126, "count": 2, "type": "SCALAR",
        }));
        let places = file.add_vectors(&[[0.0, 0.0, 0.0], [6.0, 4.0, 2.0]]);
        load(&file.with(|json| {
            json["animations"] = json!([{
                "samplers": [{ "input": times, "output": places }],
                "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
            }]);
        }))
    };
    let (scene, by_nodes) = (moving(true), moving(false));
    for time in [0.0, 0.7, 2.0] {
        let [found, expected] = [&scene, &by_nodes].map(|scene| scene.pose_at(time).unwrap());
        assert_eq!(found.instances.len(), 3);
        for (instance, other) in found.instances.iter().zip(&expected.instances) {
            assert_eq!(instance.object_to_world, other.object_to_world, "{time}");
        }
    }
    let [start, end] =
        [0.0, 2.0].map(|time| scene.pose_at(time).unwrap().instances[1].object_to_world);
    assert_eq!(
        (end.translation - start.translation).to_array(),
        [6.0, 4.0, 2.0]
    );
}

/// Replaces the attributes of the instances by `attributes`.
fn with_attributes(file: &Gltf, attributes: Value) -> Gltf {
    file.clone().with(|json| {
        let extension = &mut json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"];
        extension["attributes"] = attributes;
    })
}

#[test]
fn instances_may_lack_attributes_but_not_elements() {
    let mut file = copies(true);
    let two = file.add_vectors(&[[1.0, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]]);
    let zeros = file.add_accessor(json!({ "componentType": 5126, "count": 2, "type": "VEC4" }));
    let none = file.add_accessor(json!({ "componentType": 5126, "count": 0, "type": "VEC3" }));
    let many =
        file.add_accessor(json!({ "componentType": 5126, "count": 1u64 << 40, "type": "VEC3" }));
    for (attributes, count) in [
        (json!({ "TRANSLATION": 3 }), 3),
        (json!({ "_ID": 99 }), 1),
        (json!({}), 1),
        (json!({ "TRANSLATION": none }), 0),
    ] {
        let scene = load(&with_attributes(&file, attributes.clone()));
        assert_eq!(scene.instances.len(), count, "{attributes}");
    }
    for (attributes, named) in [
        (
            json!({ "TRANSLATION": 3, "SCALE": two }),
            "has 2 elements, another attribute has 3",
        ),
        (
            json!({ "TRANSLATION": two }),
            "instance 1: its transform is not finite",
        ),
        (
            json!({ "ROTATION": zeros }),
            "instance 0: its rotation is not a unit quaternion",
        ),
        (
            json!({ "SCALE": 99 }),
            "accessor 99 (SCALE of the instances of node 0 \"leaf\")",
        ),
        (json!({ "ROTATION": 3 }), "it must be VEC4"),
        (
            json!({ "TRANSLATION": many }),
            "1099511627776 elements, but no bufferView",
        ),
    ] {
        let text = Folder::new().refuse("scene.glb", with_attributes(&file, attributes).glb());
        assert!(text.contains(named), "{text:?} says {named:?}");
    }
    // A long name is stored once per instance.
    let mut file = file;
    let view = file.add_view(&vec![0; 12 << 16]);
    let places = file.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": 1 << 16, "type": "VEC3",
    }));
    let mut file = with_attributes(&file, json!({ "TRANSLATION": places }));
    file.json["nodes"][0]["name"] = "x".repeat(1 << 16).into();
    let text = Folder::new().refuse("scene.glb", file.glb());
    assert!(text.contains("unfolds to more than"), "{text}");
}

/// Three triangles: the first has its own material in both variants, the second only in the variant `night`, and the third in
/// none.
fn varied() -> Gltf {
    Gltf::triangle().with(|json| {
        let names = ["plain", "red", "blue", "black"].map(|name| json!({ "name": name }));
        json["materials"] = json!(names);
        let primitive = |mappings: Value| {
            json!({
                "attributes": { "POSITION": 0 }, "indices": 2, "material": 0,
                "extensions": { "KHR_materials_variants": { "mappings": mappings } },
            })
        };
        json["meshes"][0]["primitives"] = json!([
            primitive(json!([{ "material": 1, "variants": [0] }, { "material": 3, "variants": [2, 1] }])),
            primitive(json!([{ "material": 2, "variants": [1] }, { "material": 3, "variants": [1] }])),
            { "attributes": { "POSITION": 0 }, "indices": 2 },
        ]);
        json["extensions"] = json!({ "KHR_materials_variants": {
            "variants": [{ "name": "day" }, { "name": "night" }, { "name": "day" }],
        } });
        json["extensionsUsed"] = json!(["KHR_materials_variants"]);
        json["extensionsRequired"] = json!(["KHR_materials_variants"]);
    })
}

fn in_variant(file: &Gltf, variant: Option<&str>) -> headwater::Result<Scene> {
    let folder = Folder::new();
    let options = Options {
        material_variant: variant.map(str::to_owned),
        ..Options::default()
    };
    load_watched(
        &folder.write("scene.glb", file.glb()),
        options,
        &mut |_, _, _| Ok(()),
    )
}

#[test]
fn a_material_variant_can_be_chosen() {
    let mut hashes = Vec::new();
    for (variant, expected) in [
        (None, ["plain", "plain", ""]),
        (Some("day"), ["red", "plain", ""]),
        (Some("night"), ["black", "blue", ""]),
    ] {
        let scene = in_variant(&varied(), variant).unwrap();
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
        assert_eq!(scene.material_variants, ["day", "night", "day"]);
        let parts = scene.meshes[0].parts.iter();
        let names: Vec<&str> = parts
            .map(|part| scene.materials[part.material as usize].name.as_str())
            .collect();
        assert_eq!(names, expected);
        hashes.push(scene.content_hash());
    }
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), 3, "each variant is another scene");
}

#[test]
fn an_unknown_material_variant_lists_the_known_ones() {
    let refusal = |file: &Gltf, name: &str| {
        let error = in_variant(file, Some(name)).unwrap_err();
        assert_eq!(error.exit_status(), 2);
        error.to_string()
    };
    let text = refusal(&varied(), "dusk");
    let expected =
        "there is no material variant \"dusk\"; choose one of \"day\", \"night\", \"day\"";
    assert!(text.ends_with(expected), "{text}");
    let text = refusal(&Gltf::triangle(), "dusk");
    assert!(
        text.contains("\"dusk\"") && text.contains("the scene has no variants"),
        "{text}"
    );
    let file = varied().with(|json| {
        json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"][0]
            ["material"] = 9.into();
    });
    assert!(refusal(&file, "day").contains("material 9 is out of range"));
}

#[test]
fn hidden_nodes_hide_meshes_and_lights_below_them() {
    let hidden = json!({ "KHR_node_visibility": { "visible": false } });
    let shown = json!({ "KHR_node_visibility": { "visible": true } });
    let file = Gltf::triangle().with(|json| {
        json["extensions"] = json!({ "KHR_lights_punctual": {
            "lights": [{ "type": "point", "name": "a" }, { "type": "point", "name": "b" }],
        } });
        let light = |index: u32| json!({ "light": index });
        json["nodes"] = json!([
            { "name": "top", "mesh": 0, "children": [1, 4] },
            { "name": "hidden", "mesh": 0, "children": [2, 3], "extensions": hidden },
            { "name": "below", "mesh": 0, "extensions": shown },
            { "name": "eye", "camera": 0, "extensions": { "KHR_lights_punctual": light(0) } },
            { "name": "last", "mesh": 0, "extensions": {
                "KHR_node_visibility": {}, "KHR_lights_punctual": light(1),
            } },
        ]);
        json["scenes"] = json!([{ "nodes": [0] }]);
        json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_node_visibility"]);
        json["extensionsRequired"] = json!(["KHR_node_visibility"]);
    });
    let scene = load(&file);
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    let instances: Vec<&str> = scene.instances.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(instances, ["top", "last"]);
    let lights: Vec<&str> = scene
        .punctual_lights
        .iter()
        .map(|l| l.name.as_str())
        .collect();
    assert_eq!(lights, ["last"]);
    let cameras: Vec<&str> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(cameras, ["eye"], "visibility does not affect cameras");
}

#[test]
fn the_finest_level_of_detail_is_shown() {
    let file = Gltf::triangle().with(|json| {
        json["nodes"] = json!([
            { "name": "fine", "mesh": 0, "extensions": { "MSFT_lod": { "ids": [1, 2, 99] } } },
            { "name": "coarse", "mesh": 0 },
            { "name": "coarsest", "mesh": 0 },
        ]);
        json["scenes"] = json!([]);
        json.as_object_mut().unwrap().remove("scene");
        json["extensionsUsed"] = json!(["MSFT_lod"]);
        json["extensionsRequired"] = json!(["MSFT_lod"]);
    });
    let scene = load(&file);
    let instances: Vec<&str> = scene.instances.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(instances, ["fine"]);
    let notice = "of several levels of detail only the finest is shown: MSFT_lod";
    assert_eq!(scene.notices, [notice]);
}

#[test]
fn levels_of_detail_hide_nodes_only_for_a_finer_one_in_the_scene() {
    let file = Gltf::triangle().with(|json| {
        json["nodes"] = json!([
            { "name": "own", "mesh": 0, "extensions": { "MSFT_lod": { "ids": [0] } } },
            { "name": "coarse", "mesh": 0 },
            { "name": "elsewhere", "mesh": 0, "extensions": { "MSFT_lod": { "ids": [1] } } },
        ]);
        json["scenes"] = json!([{ "nodes": [0, 1] }, { "nodes": [2] }]);
    });
    let instances = load(&file).instances;
    let names: Vec<&str> = instances.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(names, ["own", "coarse"]);
}

/// The triangle with layers of its material, from the extensions in `extensions`.
fn layered(extensions: Value) -> Gltf {
    Gltf::triangle().with(|json| json["materials"][0]["extensions"] = extensions)
}

#[test]
fn layers_of_materials_are_read() {
    let file = layered(json!({
        "KHR_materials_clearcoat": { "clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25 },
        "KHR_materials_anisotropy": { "anisotropyStrength": 0.75, "anisotropyRotation": 1.5 },
        "KHR_materials_transmission": { "transmissionFactor": 0.125 },
        "KHR_materials_volume": {
            "thicknessFactor": 2, "attenuationDistance": 3, "attenuationColor": [0.5, 1, 0.25],
        },
        "KHR_materials_dispersion": { "dispersion": 0.1 },
        "KHR_materials_ior": { "ior": 1.75 },
    }));
    let scene = load(&file);
    let expected = Layers {
        coat: Coat {
            factor: 0.5,
            roughness: 0.25,
            ..Coat::default()
        },
        anisotropy: Anisotropy {
            strength: 0.75,
            rotation: 1.5,
            texture: None,
        },
        transmission: Transmission {
            factor: 0.125,
            texture: None,
        },
        volume: Volume {
            thickness: 2.0,
            attenuation_distance: 3.0,
            attenuation_color: Vec3::new(0.5, 1.0, 0.25),
        },
        dispersion: 0.1,
    };
    assert_eq!(scene.materials[0].layers, expected);
    assert_eq!(scene.materials[0].ior, 1.75);
}

/// Rays find the thickness, so that its texture is not read: here its file is missing, and so are its texture coordinates.
#[test]
fn a_thickness_texture_is_not_read() {
    let file = layered(json!({
        "KHR_materials_transmission": { "transmissionFactor": 1 },
        "KHR_materials_volume": {
            "thicknessFactor": 2, "thicknessTexture": { "index": 0, "texCoord": 7 },
        },
    }));
    let scene = load(&file.with(|json| {
        json["images"] = json!([{ "uri": "lost.png" }]);
        json["textures"] = json!([{ "source": 0 }]);
    }));
    assert_eq!(scene.materials[0].layers.volume.thickness, 2.0);
    assert!(scene.images.is_empty());
}

#[test]
fn layers_out_of_range_are_clamped_with_one_notice() {
    let scene = load(&layered(json!({
        "KHR_materials_clearcoat": { "clearcoatFactor": 2, "clearcoatRoughnessFactor": -1 },
        "KHR_materials_volume": {
            "thicknessFactor": 1, "attenuationDistance": 0, "attenuationColor": [2, 1, 1],
        },
        "KHR_materials_ior": { "ior": 0.5 },
    })));
    let layers = &scene.materials[0].layers;
    assert_eq!((layers.coat.factor, layers.coat.roughness), (1.0, 0.0));
    assert_eq!(layers.volume.attenuation_color, Vec3::ONE);
    assert_eq!(layers.volume.attenuation_distance, f32::INFINITY);
    assert_eq!(scene.materials[0].ior, 1.0);
    let notices = scene.notices.join("\n");
    for expected in [
        "outside of their range are clamped: 3 times, first clear coat factor of material 0",
        "attenuation distances of 0 count as infinite: material 0",
        "indices of refraction below 1 become 1: material 0",
    ] {
        assert!(notices.contains(expected), "{notices}");
    }
    assert_eq!(scene.notices.len(), 3, "{notices}");
    let scene = load(&layered(json!({ "KHR_materials_ior": { "ior": 1e9 } })));
    assert_eq!(scene.materials[0].ior, 1e4);
    assert_eq!(
        scene.notices,
        ["indices of refraction above 10000 become 10000: material 0 \"paint\""]
    );
}
