//! Tests of scenes that are loaded without some of their data, which the user permits with `--allow-missing`.

use crate::animations::animated;
use crate::files::{Folder, Gltf};
use crate::textures::encoded;
use glam::Vec3;
use headwater::scene::Scene;
use headwater::scene_files::{Options, load_watched};
use image::ImageFormat;
use serde_json::json;

/// Loads a scene without some of its files, with and without the permission of missing files. Without it the error must
/// contain `named`; with it the scene is returned. `beside` are the files that are there.
fn load_without(file: &Gltf, beside: &[(&str, &[u8])], named: &str) -> Scene {
    let folder = Folder::new();
    for (name, bytes) in beside {
        folder.write(name, bytes);
    }
    let text = folder.refuse("scene.glb", file.glb());
    assert!(text.contains(named), "{text:?} says {named:?}");
    let options = Options {
        allow_missing: true,
        ..Options::default()
    };
    load_watched(&folder.path("scene.glb"), options, &mut |_, _, _| Ok(())).unwrap()
}

#[test]
fn images_that_cannot_be_read_may_be_left_out() {
    let mut file = Gltf::triangle();
    let png = encoded(ImageFormat::Png);
    let coordinates = file.add_view(&[0; 24]);
    let coordinates = file.add_accessor(json!({
        "bufferView": coordinates, "componentType": 5126, "count": 3, "type": "VEC2",
    }));
    let [good, text] = [&png[..], b"text"].map(|bytes| file.add_view(bytes));
    let file = file.with(|json| {
        json["images"] = json!([
            { "bufferView": text }, { "uri": "cut.png" }, { "uri": "data:;base64,*" },
            { "uri": "http://example.org/a.png" }, { "uri": "lost.png" }, { "bufferView": good },
        ]);
        // Texture 6 has no image. Two materials have the first texture, and the last one has a good one too.
        json["textures"] = (0..6).map(|image| json!({ "source": image })).collect();
        json["textures"].as_array_mut().unwrap().push(json!({}));
        let material = |texture: u32| {
            json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } })
        };
        json["materials"] = [0, 1, 2, 3, 4, 6, 0].map(material).into_iter().collect();
        json["materials"][6]["normalTexture"] = json!({ "index": 5 });
        json["materials"][6]["name"] = "last".into();
        let attributes = json!({ "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": coordinates });
        json["meshes"][0]["primitives"] = (0..7)
            .map(|material| json!({ "attributes": attributes, "material": material }))
            .collect();
    });
    let scene = load_without(
        &file,
        &[("cut.png", &png[..40])],
        "its data URI is not base64",
    );
    assert_eq!(scene.images.len(), 1);
    assert_eq!(scene.images[0].width, 2);
    for material in &scene.materials {
        assert_eq!(material.base_color_texture, None);
        let normal = material.normal_texture.map(|texture| texture.image);
        assert_eq!(normal, (material.name == "last").then_some(0));
    }
    assert_eq!(
        scene.notices,
        [
            "images that cannot be read are left out: 5 times, first image 2: its data URI is not base64; the file is damaged, export it again",
            "image files are missing, the plain factors are used: \"lost.png\" (image 4)",
        ]
    );
}

#[test]
fn a_material_whose_emissive_texture_is_lost_emits_nothing() {
    let file = Gltf::triangle().with(|json| {
        json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
        json["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
        json["textures"] = json!([{ "source": 0 }]);
        json["images"] = json!([{ "uri": "lost.png" }]);
    });
    let scene = load_without(&file, &[], "\"lost.png\"");
    assert_eq!(scene.materials[0].emission, Vec3::ZERO);
    assert_eq!(scene.emissive_triangle_count(), 0);
    let notice = "materials without their emissive texture emit nothing: material 0 \"paint\"";
    assert_eq!(scene.notices[1], notice);
    // Nor does it by an animation.
    let mut file = animated("pointer", "VEC3", "LINEAR", &[0.0, 1.0], &[1.0; 6]);
    file.json["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
    file.json["textures"] = json!([{ "source": 0 }]);
    file.json["images"] = json!([{ "uri": "lost.png" }]);
    file.json["animations"][0]["channels"][0]["target"] = json!({
        "path": "pointer",
        "extensions": { "KHR_animation_pointer": { "pointer": "/materials/0/emissiveFactor" } },
    });
    let scene = load_without(&file, &[], "\"lost.png\"");
    assert_eq!(scene.materials[0].emission, Vec3::ZERO);
    assert!(scene.motion.is_none());
}

#[test]
fn animations_may_lack_their_buffer_but_meshes_may_not() {
    let keys = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    let file = animated("translation", "VEC3", "LINEAR", &[0.0, 1.0], &keys).with(|json| {
        let length = json["buffers"][0]["byteLength"].clone();
        json["buffers"] = json!([
            json["buffers"][0], { "uri": "keys.bin", "byteLength": length },
        ]);
        let output = json["accessors"].as_array().unwrap().len() - 1;
        json["bufferViews"][output]["buffer"] = 1.into();
    });
    let missing = "buffer 1: there is no file \"keys.bin\" where the scene expects it";
    let compressed = file.with(|json| {
        let view = json["bufferViews"].as_array_mut().unwrap().last_mut();
        view.unwrap()["extensions"] = json!({ "EXT_meshopt_compression": {
            "buffer": 1, "byteLength": 9, "byteStride": 12, "count": 2, "mode": "ATTRIBUTES",
        } });
    });
    for file in [&file, &compressed] {
        let scene = load_without(file, &[], missing);
        assert!(scene.motion.is_none());
        let notice = "animations whose buffers are missing are left out: animations[0].channels[0] (buffer 1";
        assert!(scene.notices[0].starts_with(notice), "{:?}", scene.notices);
        assert_eq!(scene.notices.len(), 1);
    }

    let file = file.with(|json| json["bufferViews"][0]["buffer"] = 1.into());
    let folder = Folder::new();
    let options = Options {
        allow_missing: true,
        ..Options::default()
    };
    let path = folder.write("scene.glb", file.glb());
    let error = load_watched(&path, options, &mut |_, _, _| Ok(())).unwrap_err();
    assert!(error.to_string().contains(missing), "{error}");
}
