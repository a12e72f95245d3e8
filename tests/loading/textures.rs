//! Tests of textures in glTF files: their transforms and wrap modes, and values out of range.

use crate::files::{Folder, Gltf};
use glam::Vec2;
use headwater::scene::texture::{Wrap, linear};
use image::{ImageFormat, RgbaImage};
use serde_json::{Value, json};

/// An image of two by three texels of different colours.
pub fn picture() -> RgbaImage {
    RgbaImage::from_fn(2, 3, |x, y| {
        image::Rgba([x as u8 * 200, y as u8 * 100, 50, 255])
    })
}

pub fn encoded(format: ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    match format {
        // JPEG has no alpha. Of one colour, so that compression changes nothing.
        ImageFormat::Jpeg => {
            image::RgbImage::from_pixel(8, 8, image::Rgb([255; 3])).write_to(&mut bytes, format)
        }
        _ => picture().write_to(&mut bytes, format),
    }
    .unwrap();
    bytes.into_inner()
}

/// A triangle whose material has a texture from an image with this JSON.
pub fn textured(image: Value) -> Gltf {
    let mut file = Gltf::triangle();
    let coordinates: Vec<u8> = ([0.0_f32, 0.0, 1.0, 0.0, 0.0, 2.0].iter())
        .flat_map(|number| number.to_le_bytes())
        .collect();
    let view = file.add_view(&coordinates);
    let uvs = file.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC2",
    }));
    file.primitive()["attributes"]["TEXCOORD_0"] = uvs.into();
    file.with(|json| {
        json["images"] = json!([image]);
        json["textures"] = json!([{ "source": 0 }]);
        json["materials"][0]["pbrMetallicRoughness"] =
            json!({ "baseColorTexture": { "index": 0 } });
    })
}

fn info(file: &mut Gltf) -> &mut Value {
    &mut file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
}

fn refuse(file: &Gltf) -> String {
    Folder::new().refuse("scene.glb", file.glb())
}

#[test]
fn samplers_transforms_and_the_second_set_are_followed() {
    let mut file = textured(json!({ "uri": "wall.png" }));
    let view = file.add_view(&[0, 0, 255, 0, 51, 255]);
    let uvs = file.add_accessor(json!({
        "bufferView": view, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2",
    }));
    file.primitive()["attributes"]["TEXCOORD_1"] = uvs.into();
    file.json["samplers"] = json!([{ "magFilter": 9728, "wrapS": 33648, "wrapT": 33071 }]);
    file.json["textures"][0]["sampler"] = 0.into();
    file.json["extensionsUsed"] = json!(["KHR_texture_transform"]);
    file.json["extensionsRequired"] = json!(["KHR_texture_transform"]);
    let placed = json!({ "offset": [0.5, 0.25], "scale": [2, 4], "texCoord": 1 });
    *info(&mut file) = json!({ "index": 0, "extensions": { "KHR_texture_transform": placed } });
    let folder = Folder::new();
    folder.write("wall.png", encoded(ImageFormat::Png));
    let scene = folder.load("scene.glb", file.glb());
    let texture = scene.materials[0].base_color_texture.unwrap();
    assert_eq!(texture.wrap, [Wrap::Mirror, Wrap::Clamp]);
    assert!(texture.nearest && texture.set == 1);
    let found = texture.transform.transform_point2(Vec2::ONE);
    assert_eq!(found, Vec2::new(2.5, 4.25));
    assert_eq!(scene.meshes[0].uvs[1][2], Vec2::new(0.2, 1.0));
    assert!(scene.meshes[0].uvs[0].is_empty(), "no texture uses it");
    let seen = texture.at(&scene.images[0], Vec2::new(0.0, 0.0), linear);
    assert_eq!(seen * 255.0, glam::Vec4::new(200.0, 0.0, 50.0, 255.0));
}

/// A file may number its sets as it likes; a material needs at most two of them.
#[test]
fn any_two_sets_of_coordinates_are_read() {
    let folder = Folder::new();
    folder.write("wall.png", encoded(ImageFormat::Png));
    let with_sets = |base: u64, rough: u64, specular: u64| {
        let mut file = textured(json!({ "uri": "wall.png" }));
        // The coordinates of set n are n, n for all corners, those of set 0 are not.
        for set in 1..5_u8 {
            let view = file.add_view(&[set; 6]);
            let uvs = file.add_accessor(json!({
                "bufferView": view, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2",
            }));
            file.primitive()["attributes"][format!("TEXCOORD_{set}")] = uvs.into();
        }
        let used = |set: u64| json!({ "index": 0, "texCoord": set });
        file.with(|json| {
            json["materials"][0] = json!({
                "pbrMetallicRoughness": { "baseColorTexture": used(base), "metallicRoughnessTexture": used(rough) },
                "extensions": { "KHR_materials_specular": { "specularTexture": used(specular) } },
            });
        })
    };
    for (sets, places) in [
        ([0, 1, 0], [0, 1, 0]),
        ([3, 3, 3], [0, 0, 0]),
        ([0, 4, 0], [0, 1, 0]),
        ([2, 1, 2], [0, 1, 0]),
        ([4, 2, 2], [0, 1, 1]),
    ] {
        let scene = folder.load("scene.glb", with_sets(sets[0], sets[1], sets[2]).glb());
        let material = &scene.materials[0];
        let textures = [
            material.base_color_texture,
            material.metallic_roughness_texture,
            material.specular_texture,
        ];
        for ((texture, set), place) in textures.into_iter().zip(sets).zip(places) {
            assert_eq!(texture.unwrap().set, place, "{sets:?}");
            let corner = scene.meshes[0].uvs[place as usize][2];
            let expected = if set == 0 { 2.0 } else { set as f32 / 255.0 };
            assert!((corner.y - expected).abs() < 1e-6, "{sets:?}: {corner}");
        }
    }
    let said = folder.refuse("scene.glb", with_sets(0, 1, 2).glb());
    assert!(said.contains("specular texture of material 0"), "{said}");
    assert!(said.contains("texture coordinates 2"), "{said}");
}

#[test]
fn unknown_wrap_modes_count_as_repeat() {
    let mut file = textured(json!({ "uri": "wall.png" }));
    file.json["samplers"] = json!([{ "wrapS": 5, "wrapT": 33071 }]);
    file.json["textures"][0]["sampler"] = 0.into();
    let folder = Folder::new();
    folder.write("wall.png", encoded(ImageFormat::Png));
    let scene = folder.load("scene.glb", file.glb());
    let texture = scene.materials[0].base_color_texture.unwrap();
    assert_eq!(texture.wrap, [Wrap::Repeat, Wrap::Clamp]);
    let said = scene.notices.join("\n");
    assert!(
        said.contains("unknown wrap modes count as REPEAT"),
        "{said}"
    );
}

#[test]
fn normal_maps_bring_tangents() {
    let folder = Folder::new();
    folder.write("wall.png", encoded(ImageFormat::Png));
    let mapped = |scale: Value| {
        textured(json!({ "uri": "wall.png" })).with(|json| {
            json["materials"][0]["normalTexture"] = json!({ "index": 0, "scale": scale });
        })
    };
    // u grows along x, and v, which points down, along y.
    let scene = folder.load("scene.glb", mapped(json!(0.25)).glb());
    let (mesh, material) = (&scene.meshes[0], &scene.materials[0]);
    assert!(material.normal_texture.is_some() && material.normal_scale == 0.25);
    for tangent in &mesh.tangents {
        assert!(
            (*tangent - glam::Vec4::new(1.0, 0.0, 0.0, -1.0)).length() < 1e-5,
            "{tangent}"
        );
    }
    // The file's own, which count only beside normals.
    let mut own = mapped(json!(1));
    let numbers = |values: &[[f32; 4]]| -> Vec<u8> {
        values
            .as_flattened()
            .iter()
            .flat_map(|n| n.to_le_bytes())
            .collect()
    };
    let view = own.add_view(&numbers(&[[0.0, 2.0, 0.0, 1.0]; 3]));
    let tangents = own.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC4",
    }));
    own.primitive()["attributes"]["TANGENT"] = tangents.into();
    let attributes = own.primitive()["attributes"].as_object_mut().unwrap();
    attributes.remove("NORMAL");
    let without = folder.load("scene.glb", own.glb());
    assert_eq!(without.meshes[0].tangents, mesh.tangents);
    let normals: Vec<u8> = ([[0.0_f32, 0.0, 1.0]; 3].as_flattened().iter())
        .flat_map(|n| n.to_le_bytes())
        .collect();
    let view = own.add_view(&normals);
    let normals = own.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3",
    }));
    own.primitive()["attributes"]["NORMAL"] = normals.into();
    let with = folder.load("scene.glb", own.glb());
    assert_eq!(
        with.meshes[0].tangents,
        [glam::Vec4::new(0.0, 1.0, 0.0, 1.0); 3]
    );
    let text = folder.refuse("scene.glb", mapped(json!(1e39)).glb());
    assert!(text.contains("scale") || text.contains("range"), "{text}");
}

#[test]
fn missing_coordinates_are_zero() {
    let mut file = textured(json!({ "uri": "wall.png" }));
    file.primitive()["attributes"]
        .as_object_mut()
        .unwrap()
        .remove("TEXCOORD_0");
    let folder = Folder::new();
    folder.write("wall.png", encoded(ImageFormat::Png));
    let scene = folder.load("scene.glb", file.glb());
    assert_eq!(scene.meshes[0].uvs[0], [Vec2::ZERO; 3]);
    assert_eq!(
        scene.notices,
        ["texture coordinates are missing, 0 is used: TEXCOORD_0 of mesh 0 \"leaf\" primitive 0"]
    );
}

#[test]
fn what_is_out_of_range_or_outside_is_named() {
    let wrong = |change: &dyn Fn(&mut Value), parts: &[&str]| {
        let text = refuse(&textured(json!({ "uri": "wall.png" })).with(|json| change(json)));
        for part in parts {
            assert!(text.contains(part), "{part}: {text}");
        }
    };
    let far = 1_u64 << 32;
    wrong(
        &|json| {
            json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = far.into();
        },
        &[
            "texture 4294967296 is out of range, there are 1",
            "base colour texture of material 0",
        ],
    );
    wrong(
        &|json| json["textures"][0]["source"] = 1.into(),
        &["texture 0: image 1 is out of range, there are 1"],
    );
    wrong(
        &|json| json["textures"][0] = json!({ "extensions": { "other": { "source": 0 } } }),
        &["texture 0 has no image", "WebP or KTX2"],
    );
    for uri in ["../wall.png", "/etc/passwd", "a/../../b.png"] {
        wrong(
            &|json| json["images"][0]["uri"] = uri.into(),
            &["outside of the scene's folder", uri],
        );
    }
    wrong(
        &|json| json["images"][0]["uri"] = "https://x.org/a.png".into(),
        &["not a file beside the scene"],
    );
}

#[test]
fn coordinates_that_are_not_finite_are_named() {
    let mut file = textured(json!({ "uri": "wall.png" }));
    let length = file.binary.len();
    file.binary[length - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    let folder = Folder::new();
    folder.write("wall.png", encoded(ImageFormat::Png));
    let text = folder.refuse("scene.glb", file.glb());
    assert!(text.contains("texture coordinate 2 is"), "{text}");
}
