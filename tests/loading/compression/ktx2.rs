//! `KHR_texture_basisu`. The images were made by the encoder of Basis Universal with alktx2 0.1.7: `encode_raw_rgba_to_ktx2`
//! with `quality=100`. `etc1s-alpha` has all levels (`mipmaps=True`). `uastc` is `uastc-zstandard`, whose level was
//! decompressed and whose header was changed accordingly.

use super::*;

/// The size of the images: blocks of 4 × 4 texels of one colour each, the last ones cut off.
const SIZE: (u32, u32) = (18, 10);

/// The images, each with the greatest difference of a byte from the texel that was encoded.
const IMAGES: [(&str, &[u8], u8); 4] = [
    ("etc1s", include_bytes!("etc1s.ktx2"), 2),
    ("etc1s-alpha", include_bytes!("etc1s-alpha.ktx2"), 2),
    ("uastc", include_bytes!("uastc.ktx2"), 0),
    ("uastc-zstandard", include_bytes!("uastc-zstandard.ktx2"), 0),
];

const ZSTANDARD: &[u8] = IMAGES[3].1;

/// The texel that was encoded.
fn texel(x: u32, y: u32, is_opaque: bool) -> [u8; 4] {
    let alpha = if is_opaque { 255 } else { 60 + 60 * (x / 8) };
    [40 * (x / 4), 80 * (y / 4), 30, alpha].map(|byte| byte as u8)
}

/// A triangle with the image, which a buffer view contains. The texture has a fallback that does not exist.
fn shown(image: &[u8]) -> Gltf {
    let mut file = textured(json!({ "uri": "lost.png" }));
    let view = file.add_view(image);
    file.with(|json| {
        let images = json["images"].as_array_mut().unwrap();
        images.push(json!({ "name": "wall", "bufferView": view, "mimeType": "image/ktx2" }));
        json["textures"][0] =
            json!({ "source": 0, "extensions": { "KHR_texture_basisu": { "source": 1 } } });
        json["extensionsUsed"] = json!(["KHR_texture_basisu"]);
        json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    })
}

#[test]
fn ktx2_images_equal_the_texels_before_compression() {
    for (name, bytes, step) in IMAGES {
        let scene = load(&shown(bytes));
        let [image] = &scene.images[..] else {
            panic!("one image")
        };
        assert_eq!((image.width, image.height), SIZE);
        assert_eq!(image.name, "wall");
        for (index, found) in (0..).zip(image.texels.iter()) {
            let (x, y) = (index % SIZE.0, index / SIZE.0);
            let expected = texel(x, y, name == "etc1s");
            let error = (0..4).map(|c| found[c].abs_diff(expected[c])).max();
            assert!(error <= Some(step), "{name} at {x}, {y}: {found:?}");
        }
    }
}

#[test]
fn wrong_ktx2_images_are_one_clear_line() {
    for (at, value, named) in [
        (12, 37, "not compressed by Basis Universal"),
        (20, 0, "has 0 × 10 texels"),
        (20, 16385, "has 16385 × 10 texels"),
        (28, 1, "not a single two-dimensional image"),
        (32, 2, "not a single two-dimensional image"),
        (36, 6, "not a single two-dimensional image"),
        (40, 99, "the data are damaged"),
        (44, 3, "the data are damaged"),
        (88, 1 << 30, "the data are damaged"),
        (96, 1 << 30, "level 0 does not have the size of its texels"),
        (100, 1 << 30, "level 0 does not have the size of its texels"),
    ] {
        let mut bytes = ZSTANDARD.to_vec();
        bytes[at..at + 4].copy_from_slice(&u32::to_le_bytes(value));
        let text = refuse(&shown(&bytes));
        for named in ["image 1 \"wall\"", named] {
            assert!(
                text.contains(named),
                "{at}, {value}: {text:?} says {named:?}"
            );
        }
    }
}

/// Other formats of Basis Universal, whose decoders allocate what the file states: here XUASTC, by the scheme of compression,
/// the global data of one image and the colour model.
#[test]
fn other_formats_of_basis_universal_are_not_decoded() {
    let mut bytes = IMAGES[2].1.to_vec();
    for (at, value) in [(44, 5), (64, 0), (72, 12), (96, 0)] {
        bytes[at..at + 4].copy_from_slice(&u32::to_le_bytes(value));
    }
    bytes[104 + 12] = 169;
    let text = refuse(&shown(&bytes));
    assert!(text.contains("neither ETC1S nor UASTC"), "{text}");
}

#[test]
fn damaged_ktx2_images_are_refused_or_read() {
    for (_, bytes, _) in IMAGES {
        for length in (0..104).chain(bytes.len() - 2..bytes.len()) {
            refuse(&shown(&bytes[..length]));
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.to_vec();
            changed[at] ^= 0x5A;
            let folder = Folder::new();
            let path = folder.write("scene.glb", shown(&changed).glb());
            if let Err(error) = headwater::scene_files::load(&path) {
                assert_eq!(error.exit_status(), 2, "{error}");
                assert_eq!(error.to_string().lines().count(), 1, "{error}");
            }
        }
    }
}
