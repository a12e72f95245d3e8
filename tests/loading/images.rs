//! Tests of images of textures: formats, damage, limits, and the images of a file that are read at all.

use crate::files::{Folder, Gltf};
use crate::textures::{encoded, picture, textured};
use base64::prelude::{BASE64_STANDARD, Engine};
use glam::Vec2;
use headwater::scene::{Scene, Texture};
use headwater::scene_files::{Options, load_watched};
use image::{DynamicImage, GrayImage, ImageFormat, RgbImage};
use serde_json::{Value, json};

fn load(file: &Gltf) -> Scene {
    Folder::new().load("scene.glb", file.glb())
}

fn refuse(file: &Gltf) -> String {
    Folder::new().refuse("scene.glb", file.glb())
}

/// A textured triangle whose image has these bytes.
fn with_image(bytes: &[u8]) -> Gltf {
    let mut file = textured(json!({}));
    file.json["images"][0]["bufferView"] = file.add_view(bytes).into();
    file
}

fn write(image: &image::DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A picture of noise, whose compressed file is large.
fn noisy() -> image::DynamicImage {
    let noise = |x: u32, y: u32| (x * 7919 + y * 104_729).wrapping_mul(2_654_435_761) >> 24;
    RgbImage::from_fn(64, 64, |x, y| {
        image::Rgb([noise(x, y), noise(y, x), noise(x + 9, y)].map(|n| n as u8))
    })
    .into()
}

/// A PNG file whose header has this size, while its data belongs to another size.
fn lying_png(width: u32, height: u32) -> Vec<u8> {
    lying_png_of_bits(8, width, height)
}

fn lying_png_of_bits(bits: u8, width: u32, height: u32) -> Vec<u8> {
    let mut png = encoded(ImageFormat::Png);
    png[24] = bits;
    png[16..20].copy_from_slice(&width.to_be_bytes());
    png[20..24].copy_from_slice(&height.to_be_bytes());
    let checksum = crc32fast::hash(&png[12..29]);
    png[29..33].copy_from_slice(&checksum.to_be_bytes());
    png
}

#[test]
fn images_may_be_beside_inside_or_in_the_uri_and_of_three_formats() {
    for format in [ImageFormat::Png, ImageFormat::WebP, ImageFormat::Jpeg] {
        let bytes = encoded(format);
        let folder = Folder::new();
        folder.write("a wall.image", &bytes);
        let beside = textured(json!({ "uri": "a%20wall.image" }));
        let uri = format!("data:image/any;base64,{}", BASE64_STANDARD.encode(&bytes));
        let in_uri = textured(json!({ "uri": uri }));
        let mut inside = textured(json!({ "mimeType": "image/png" }));
        inside.json["images"][0]["bufferView"] = inside.add_view(&bytes).into();
        for file in [beside, in_uri, inside] {
            let scene = folder.load("scene.glb", file.glb());
            assert!(scene.notices.is_empty(), "{:?}", scene.notices);
            let (image, texels) = (&scene.images[0], &scene.images[0].texels);
            if format == ImageFormat::Jpeg {
                assert_eq!((image.width, image.height), (8, 8));
                assert!(texels.iter().all(|texel| *texel == [255; 4]));
            } else {
                assert_eq!((image.width, image.height), (2, 3));
                let expected: Vec<[u8; 4]> = picture().pixels().map(|p| p.0).collect();
                assert_eq!(**texels, expected);
            }
            let texture = scene.materials[0].base_color_texture;
            assert_eq!(texture, Some(Texture::plain(0)));
            assert_eq!(scene.meshes[0].uvs[0], [Vec2::ZERO, Vec2::X, Vec2::Y * 2.0]);
            assert!(scene.meshes[0].uvs[1].is_empty());
        }
    }
}

#[test]
fn webp_is_preferred_where_there_is_a_choice() {
    let mut file = textured(json!({ "uri": "a.png" }));
    file.json["images"] = json!([{ "uri": "a.png" }, { "uri": "a.webp" }]);
    file.json["textures"][0]["extensions"] = json!({ "EXT_texture_webp": { "source": 1 } });
    let folder = Folder::new();
    folder.write("a.webp", encoded(ImageFormat::WebP));
    assert_eq!(
        folder.load("scene.glb", file.glb()).images[0].name,
        "a.webp"
    );
}

#[test]
fn a_missing_image_is_named_and_may_be_allowed() {
    let file = textured(json!({ "name": "bark", "uri": "textures/bark.png" }));
    let text = refuse(&file);
    for part in [
        "image 0 \"bark\"",
        "\"textures/bark.png\"",
        "--allow-missing",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let path = Folder::new();
    let path = path.write("scene.glb", file.glb());
    let options = Options {
        allow_missing: true,
        ..Options::default()
    };
    let scene = load_watched(&path, options, &mut |_, _, _| Ok(())).unwrap();
    assert_eq!(
        scene.notices,
        [
            "image files are missing, the plain factors are used: \"textures/bark.png\" (image 0 \"bark\")"
        ]
    );
    assert!(scene.images.is_empty() && scene.materials[0].base_color_texture.is_none());
}

#[test]
fn an_image_that_nothing_uses_need_not_exist() {
    let file = textured(json!({ "uri": "wall.png" }))
        .with(|json| json["materials"][0]["pbrMetallicRoughness"] = json!({}));
    assert!(load(&file).images.is_empty());
}

#[test]
fn broken_images_are_one_line() {
    let png = encoded(ImageFormat::Png);
    let cases: [(&[u8], &str); 8] = [
        (&lying_png(60_000, 3), "60000 × 3 texels"),
        (&lying_png(0, 3), "cannot be decoded"),
        (&png[..20], "cannot be decoded"),
        (b"", "not PNG, JPEG, WebP or KTX2"),
        (b"no picture at all", "not PNG, JPEG, WebP or KTX2"),
        // What the environment may be.
        (
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x80",
            "not PNG, JPEG, WebP or KTX2",
        ),
        (b"BM", "not PNG, JPEG, WebP or KTX2"),
        (b"RIFF\x04\0\0\0WEBP", "cannot be decoded"),
    ];
    for (bytes, part) in cases {
        let folder = Folder::new();
        folder.write("wall.png", bytes);
        let file = textured(json!({ "uri": "wall.png" }));
        let text = folder.refuse("scene.glb", file.glb());
        assert!(
            text.contains(part) && text.contains("wall.png"),
            "{part}: {text}"
        );
    }
}

#[test]
fn images_that_are_cut_off_are_refused() {
    for format in [ImageFormat::Png, ImageFormat::WebP, ImageFormat::Jpeg] {
        let whole = write(&noisy(), format);
        load(&with_image(&whole));
        // What follows the end of an image, some cameras write previews there, changes nothing.
        load(&with_image(&[&whole[..], b"more"].concat()));
        // The last chunk of a PNG file only says that it is the last.
        let needed = whole.len() - if format == ImageFormat::Png { 12 } else { 0 };
        for length in [needed / 8, needed / 2, needed - 100, needed - 5, needed - 1] {
            let text = refuse(&with_image(&whole[..length]));
            assert!(
                text.contains("image 0: cannot be decoded"),
                "{format:?}, {length} of {needed}: {text}"
            );
        }
    }
}

/// A find of the fuzzer: the decoder of the library panics where a scan has the first colour alone and another colour has
/// finer samples.
#[test]
fn scans_and_samplings_of_jpeg_are_read_or_refused_in_one_line() {
    let whole = write(&noisy().crop_imm(0, 0, 19, 11), ImageFormat::Jpeg);
    let offset_of = |marker: u8| whole.windows(2).position(|pair| pair == [0xFF, marker]);
    let (frame, scan) = (offset_of(0xC0).unwrap(), offset_of(0xDA).unwrap());
    let data = &whole[scan + 2 + usize::from(whole[scan + 3])..];
    // A scan of the first colour.
    let single: &[u8] = &[0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 63, 0];
    let mut refused = 0;
    for start in [
        &whole[..scan + 2 + usize::from(whole[scan + 3])],
        &[&whole[..scan], single].concat(),
    ] {
        for component in 0..usize::from(whole[frame + 9]) {
            for sampling in [
                0x00, 0x11, 0x12, 0x14, 0x21, 0x22, 0x24, 0x41, 0x42, 0x44, 0xFF,
            ] {
                let mut bytes = [start, data].concat();
                bytes[frame + 11 + 3 * component] = sampling;
                let folder = Folder::new();
                let path = folder.write("scene.glb", with_image(&bytes).glb());
                let loaded = load_watched(&path, Options::default(), &mut |_, _, _| Ok(()));
                if let Err(error) = loaded {
                    let text = error.to_string();
                    assert!(
                        text.lines().count() == 1 && text.contains("image 0"),
                        "{text}"
                    );
                    refused += 1;
                }
            }
        }
    }
    assert!(refused > 0);
}

#[test]
fn the_smallest_and_the_largest_image() {
    let single = GrayImage::from_pixel(1, 1, image::Luma([7]));
    let scene = load(&with_image(&write(&single.into(), ImageFormat::Png)));
    assert_eq!(*scene.images[0].texels, [[7, 7, 7, 255]]);
    let strip = GrayImage::from_fn(16384, 1, |x, _| image::Luma([(x % 251) as u8]));
    let scene = load(&with_image(&write(&strip.into(), ImageFormat::Png)));
    let last = (16383 % 251) as u8;
    assert_eq!(scene.images[0].texels[16383], [last, last, last, 255]);
    let text = refuse(&with_image(&lying_png(16385, 1)));
    assert!(text.contains("16385 × 1 texels"), "{text}");
}

/// Images of 16 bits per channel keep them, and count twice. Those of 8 bits do not change.
#[test]
fn sixteen_bits_are_kept() {
    let (low, high) = (0x8040_u16, 0x12FF);
    let grey: image::ImageBuffer<image::Luma<u16>, _> =
        image::ImageBuffer::from_fn(3, 2, |x, _| image::Luma([low + x as u16]));
    let mut color = image::ImageBuffer::from_pixel(3, 2, image::Rgba([low, high, 0, 7]));
    color.put_pixel(2, 1, image::Rgba([1, 2, 3, 4]));
    for (image, first, last) in [
        (
            DynamicImage::from(grey),
            [low, low, low, u16::MAX],
            [low + 2, low + 2, low + 2, u16::MAX],
        ),
        (DynamicImage::from(color), [low, high, 0, 7], [1, 2, 3, 4]),
    ] {
        let scene = load(&with_image(&write(&image, ImageFormat::Png)));
        let deep = &scene.images[0];
        assert!(deep.is_deep() && deep.texels.len() == 12);
        assert_eq!((deep.width, deep.height), (3, 2));
        assert_eq!([deep.texel(0), deep.texel(5)], [first, last]);
        let requirements = headwater::scene::requirements::Requirements::of(&scene);
        assert!(requirements.deep_textures && scene.notices.is_empty());
        let scene = load(&with_image(&write(
            &image.into_rgba8().into(),
            ImageFormat::Png,
        )));
        assert!(!scene.images[0].is_deep() && scene.images[0].texels.len() == 6);
    }
    // Eight images of 2^28 texels each are as many as a scene can have.
    let views: Vec<Value> = (0..9).map(|i| json!({ "bufferView": 4 + i })).collect();
    let mut file = with_images(&views);
    for _ in 0..9 {
        file.add_view(&lying_png_of_bits(16, 16384, 16384));
    }
    let text = refuse(&file);
    assert!(
        text.contains("image 8: ") && text.contains(" 2147483648 bytes"),
        "{text}"
    );
}

/// Roughness and metalness of an OBJ file are put together in 16 bits if one of them has 16 bits.
#[test]
fn sixteen_bits_are_kept_in_what_is_put_together() {
    let folder = Folder::new();
    let deep: image::ImageBuffer<image::Luma<u16>, _> =
        image::ImageBuffer::from_fn(2, 1, |x, _| image::Luma([0x1234 + x as u16]));
    folder.write("deep.png", write(&deep.into(), ImageFormat::Png));
    let grey = GrayImage::from_pixel(2, 1, image::Luma([0x56]));
    folder.write("grey.png", write(&grey.into(), ImageFormat::Png));
    folder.write("m.mtl", "newmtl a\nmap_Pr grey.png\nmap_Pm deep.png\n");
    let scene = folder.load(
        "scene.obj",
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n",
    );
    let texture = scene.materials[0].metallic_roughness_texture.unwrap();
    let image = &scene.images[texture.image as usize];
    let most = u16::MAX;
    assert_eq!(
        [image.texel(0), image.texel(1)],
        [[most, 0x5656, 0x1234, most], [most, 0x5656, 0x1235, most]]
    );
}

/// A file with one triangle and one material per image.
fn with_images(images: &[Value]) -> Gltf {
    textured(json!({})).with(|json| {
        let primitive = json["meshes"][0]["primitives"][0].clone();
        let numbers = 0..images.len();
        json["images"] = images.into();
        json["textures"] = numbers.clone().map(|i| json!({ "source": i })).collect();
        json["materials"] = (numbers.clone())
            .map(|i| json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": i } } }))
            .collect();
        json["meshes"][0]["primitives"] = numbers
            .map(|i| {
                let mut primitive = primitive.clone();
                primitive["material"] = i.into();
                primitive
            })
            .collect();
    })
}

#[test]
fn images_of_the_same_bytes_are_one() {
    let folder = Folder::new();
    let png = encoded(ImageFormat::Png);
    folder.write("wall.png", &png);
    let uri = format!("data:image/png;base64,{}", BASE64_STANDARD.encode(&png));
    let (data, file) = (json!({ "uri": uri }), json!({ "uri": "wall.png" }));
    let other_name = json!({ "name": "again", "uri": "./wall.png" });
    // The view of the texture coordinates is 3.
    let view = json!({ "bufferView": 4 });
    let images = [&file, &data, &view, &view, &data, &other_name, &file].map(Value::clone);
    let mut scene = with_images(&images);
    assert_eq!(scene.add_view(&png), 4);
    let scene = folder.load("scene.glb", scene.glb());
    let used = scene.materials.iter();
    let used: Vec<u32> = used.map(|m| m.base_color_texture.unwrap().image).collect();
    assert_eq!(used, [0, 1, 2, 2, 1, 0, 0]);
    assert_eq!(scene.images.len(), 3);
}

#[test]
fn more_texels_in_all_than_a_scene_can_have_are_refused_undecoded() {
    // Seventeen images of 2^28 texels each: their data would not decode.
    let views: Vec<Value> = (0..17).map(|i| json!({ "bufferView": 4 + i })).collect();
    let mut file = with_images(&views);
    for _ in 0..17 {
        file.add_view(&lying_png(16384, 16384));
    }
    let text = refuse(&file);
    for part in ["image 16: ", " 1073741824 bytes", "17179869184; scale them"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn images_of_materials_without_faces_need_not_exist() {
    let file = textured(json!({ "uri": "wall.png" })).with(|json| {
        json["materials"].as_array_mut().unwrap().push(json!({}));
        json["meshes"][0]["primitives"][0]["material"] = 1.into();
    });
    let scene = load(&file);
    assert!(scene.images.is_empty() && scene.notices.is_empty());
    // Neither do those of faces that are in no scene.
    let file = textured(json!({ "uri": "wall.png" })).with(|json| {
        json["scenes"][0]["nodes"] = json!([1]);
    });
    assert!(load(&file).images.is_empty());
}

#[test]
fn emissive_textures_of_what_never_emits_are_not_read() {
    let emissive = |factor: Value| {
        textured(json!({ "uri": "lamp.png" })).with(|json| {
            json["materials"][0] =
                json!({ "emissiveTexture": { "index": 0 }, "emissiveFactor": factor });
        })
    };
    let dark = load(&emissive(json!([0, 0, 0])));
    assert!(dark.images.is_empty() && dark.materials[0].emissive_texture.is_none());
    assert!(dark.meshes[0].uvs[0].is_empty(), "no texture uses them");
    let text = refuse(&emissive(json!([0, 0.5, 0])));
    assert!(text.contains("lamp.png"), "{text}");
    // What is dark at first may be lit later.
    let mut animated = emissive(json!([0, 0, 0]));
    let numbers =
        |numbers: &[f32]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
    let view = animated.add_view(&numbers(&[0.0, 1.0]));
    let times = animated.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1],
    }));
    let colors = animated.add_vectors(&[[0.0; 3], [1.0; 3]]);
    let pointer = json!({ "KHR_animation_pointer": { "pointer": "/materials/0/emissiveFactor" } });
    animated.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    animated.json["animations"] = json!([{
        "samplers": [{ "input": times, "output": colors }],
        "channels": [{ "sampler": 0, "target": { "path": "pointer", "extensions": pointer } }],
    }]);
    let folder = Folder::new();
    folder.write("lamp.png", encoded(ImageFormat::Png));
    let scene = folder.load("scene.glb", animated.glb());
    assert!(scene.materials[0].emissive_texture.is_some());
}

#[test]
fn each_slot_has_its_own_image() {
    let folder = Folder::new();
    for name in ["base", "surface", "normal", "lamp"] {
        folder.write(&format!("{name}.png"), encoded(ImageFormat::Png));
    }
    let mut file = textured(json!({}));
    file.json["images"] = ["lamp", "normal", "surface", "base"]
        .iter()
        .map(|name| json!({ "uri": format!("{name}.png") }))
        .collect();
    file.json["textures"] = (0..4).map(|i| json!({ "source": i })).collect();
    file.json["materials"][0] = json!({
        "emissiveFactor": [1, 1, 1],
        "emissiveTexture": { "index": 0 },
        "normalTexture": { "index": 1 },
        "pbrMetallicRoughness": {
            "metallicRoughnessTexture": { "index": 2 },
            "baseColorTexture": { "index": 3 },
        },
    });
    let scene = folder.load("scene.glb", file.glb());
    let name = |texture: Option<Texture>| &*scene.images[texture.unwrap().image as usize].name;
    let material = &scene.materials[0];
    assert_eq!(name(material.base_color_texture), "base.png");
    assert_eq!(name(material.metallic_roughness_texture), "surface.png");
    assert_eq!(name(material.normal_texture), "normal.png");
    assert_eq!(name(material.emissive_texture), "lamp.png");
}

#[test]
fn images_lie_in_the_folder_of_the_scene() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("inside/textures")).unwrap();
    folder.write("secret.png", encoded(ImageFormat::Png));
    folder.write("inside/wall.png", encoded(ImageFormat::Png));
    let link = |to: &str, name: &str| {
        std::os::unix::fs::symlink(folder.path(to), folder.path(name)).unwrap();
    };
    link("secret.png", "inside/link.png");
    link(".", "inside/out");
    link("inside/wall.png", "inside/own.png");
    let scene = |uri: &str| textured(json!({ "uri": uri })).glb();
    for uri in [
        "textures/../wall.png",
        "./wall.png",
        "own.png",
        "a/../wall.png",
    ] {
        let scene = folder.load("inside/scene.glb", scene(uri));
        assert_eq!(scene.images.len(), 1, "{uri}");
    }
    for uri in [
        "link.png",
        "out/secret.png",
        "../secret.png",
        "textures/../../secret.png",
        "../inside/wall.png",
    ] {
        let text = folder.refuse("inside/scene.glb", scene(uri));
        assert!(text.contains("outside of the scene's folder"), "{text}");
    }
}
