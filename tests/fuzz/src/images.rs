//! Images and pictures of every kind that loaders read, all of them small.

use crate::Folder;
use crate::files::{Gltf, floats};
use exr::prelude::*;
use headwater::image::{Image, Samples};
use image::{DynamicImage, ImageFormat, ImageReader};
use serde_json::json;
use std::io::Cursor;

/// Width and height of the images: more than a block of JPEG, and not of whole bytes at one bit per texel.
const SIZE: (u32, u32) = (19, 11);

/// The formats of textures.
pub const TEXTURE_FORMATS: [ImageFormat; 3] =
    [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP];

/// An image in the memory form that is called `form`, such as `rgb8`.
fn texels(form: &str) -> DynamicImage {
    let picture = image::RgbaImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        image::Rgba([x as u8 * 12, y as u8 * 20, (x ^ y) as u8 * 9, 255 - x as u8])
    });
    let picture = DynamicImage::from(picture);
    match form {
        "grey8" => picture.into_luma8().into(),
        "greya8" => picture.into_luma_alpha8().into(),
        "rgb8" => picture.into_rgb8().into(),
        "grey16" => picture.into_luma16().into(),
        "rgb16" => picture.into_rgb16().into(),
        "rgba16" => picture.into_rgba16().into(),
        "rgb32f" => picture.into_rgb32f().into(),
        _ => picture,
    }
}

fn encoded(form: &str, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    texels(form)
        .write_to(&mut bytes, format)
        .expect("an image that can be encoded");
    bytes.into_inner()
}

/// The smallest RGB image as PNG in base64.
pub fn small_png() -> String {
    use base64::Engine;
    base64::engine::general_purpose::STANDARD.encode(encoded("rgb8", ImageFormat::Png))
}

/// PNG files with a palette, with few bits per texel, and with interlaced rows.
fn packed_pngs() -> Vec<(String, Vec<u8>)> {
    use png::{BitDepth, ColorType};
    let mut files = Vec::new();
    for (depth, bits) in [
        (BitDepth::One, 1_usize),
        (BitDepth::Two, 2),
        (BitDepth::Four, 4),
        (BitDepth::Eight, 8),
    ] {
        for (name, color) in [
            ("palette", ColorType::Indexed),
            ("bits", ColorType::Grayscale),
        ] {
            // One column: interlaced, it has as many rows as otherwise.
            let height = 11;
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, 1, height);
            encoder.set_depth(depth);
            encoder.set_color(color);
            if color == ColorType::Indexed {
                encoder.set_palette((0..6).map(|i| 40 * i).collect::<Vec<u8>>());
                encoder.set_trns(vec![255, 128]);
            }
            let rows: Vec<u8> = (0..height as u8)
                .map(|row| (row % 2) << (8 - bits))
                .collect();
            let mut writer = encoder.write_header().expect("a header");
            writer.write_image_data(&rows).expect("a PNG");
            writer.finish().expect("a PNG");
            files.push((format!("{name}{bits}.png"), bytes.clone()));
            // The byte of the header that says so; the decoder that is built for fuzzing ignores the checksum.
            bytes[28] = 1;
            files.push((format!("{name}{bits}-interlaced.png"), bytes));
        }
    }
    files
}

/// JPEG files that the encoder cannot write: progressive with one scan, of four colours, and with a preview inside. The
/// Huffman tables have one code each, for zero.
fn other_jpegs() -> Vec<(String, Vec<u8>)> {
    let segment = |marker: u8, content: &[u8]| {
        let length = (content.len() as u16 + 2).to_be_bytes();
        [&[0xff, marker][..], &length, content].concat()
    };
    let frame = |marker: u8, components: u8| {
        let sampled = (1..=components).flat_map(|id| [id, 0x11, 0]);
        let content: Vec<u8> = [8, 0, 8, 0, 8, components]
            .into_iter()
            .chain(sampled)
            .collect();
        segment(marker, &content)
    };
    let table = |class: u8| segment(0xc4, &[&[class << 4, 1][..], &[0; 15], &[0]].concat());
    let scan = |components: u8, last: u8| {
        let tables = (1..=components).flat_map(|id| [id, 0]);
        let content = [components].into_iter().chain(tables).chain([0, last, 0]);
        segment(0xda, &content.collect::<Vec<u8>>())
    };
    let file = |frame: Vec<u8>, scan: Vec<u8>| {
        let quantization = segment(0xdb, &[&[0][..], &[1; 64]].concat());
        let parts = [
            vec![0xff, 0xd8],
            quantization,
            frame,
            table(0),
            table(1),
            scan,
        ];
        [parts.concat(), vec![0, 0xff, 0xd9]].concat()
    };
    let whole = encoded("rgb8", ImageFormat::Jpeg);
    let preview = [&b"Exif\0\0"[..], &encoded("grey8", ImageFormat::Jpeg)[..]].concat();
    let preview = [&whole[..2], &segment(0xe1, &preview), &whole[2..]].concat();
    vec![
        ("progressive.jpg".into(), file(frame(0xc2, 1), scan(1, 0))),
        ("cmyk.jpg".into(), file(frame(0xc0, 4), scan(4, 63))),
        ("preview.jpg".into(), preview),
    ]
}

/// WebP files that the encoder cannot write, of one texel each.
fn other_webps() -> Vec<(String, Vec<u8>)> {
    use base64::Engine;
    [
        ("lossy.webp", "UklGRiIAAABXRUJQVlA4IBYAAAAwAQCdASoBAAEADsD+JaQAA3AAAAAA"),
        (
            "alpha.webp",
            "UklGRkoAAABXRUJQVlA4WAoAAAAQAAAAAAAAAAAAQUxQSAwAAAARBxAR/Q9ERP8DAABWUDggGAAAABQBAJ0BKgEAAQAAAP4AAA3AAP7mtQAAAA==",
        ),
        (
            "animated.webp",
            "UklGRlIAAABXRUJQVlA4WAoAAAASAAAAAAAAAAAAQU5JTQYAAAD/////AABBTk1GJgAAAAAAAAAAAAAAAAAAAGQAAABWUDhMDQAAAC8AAAAQBxAREYiI/gcA",
        ),
    ]
    .map(|(name, text)| {
        let bytes = base64::engine::general_purpose::STANDARD.decode(text);
        (name.to_owned(), bytes.expect("base64"))
    })
    .to_vec()
}

/// PNG files, with their names.
pub fn pngs() -> Vec<(String, Vec<u8>)> {
    let plain = [
        "grey8", "greya8", "rgb8", "rgba8", "grey16", "rgb16", "rgba16",
    ]
    .map(|form| (format!("{form}.png"), encoded(form, ImageFormat::Png)));
    [plain.to_vec(), packed_pngs()].concat()
}

/// PNG, JPEG, WebP and KTX2 files, with their names.
pub fn textures() -> Vec<(String, Vec<u8>)> {
    let mut files = pngs();
    for form in ["grey8", "rgb8"] {
        files.push((format!("{form}.jpg"), encoded(form, ImageFormat::Jpeg)));
    }
    for form in ["rgb8", "rgba8"] {
        files.push((format!("{form}.webp"), encoded(form, ImageFormat::WebP)));
    }
    files.extend(other_jpegs());
    files.extend(other_webps());
    files.extend(ktx2s());
    files
}

/// KTX2 files of each form that can be read.
fn ktx2s() -> Vec<(String, Vec<u8>)> {
    let files: [(&str, &[u8]); 4] = [
        (
            "etc1s",
            include_bytes!("../../loading/compression/etc1s.ktx2"),
        ),
        (
            "etc1s-alpha",
            include_bytes!("../../loading/compression/etc1s-alpha.ktx2"),
        ),
        (
            "uastc",
            include_bytes!("../../loading/compression/uastc.ktx2"),
        ),
        (
            "zstandard",
            include_bytes!("../../loading/compression/uastc-zstandard.ktx2"),
        ),
    ];
    let named = |(name, bytes): (&str, &[u8])| (format!("{name}.ktx2"), bytes.to_vec());
    files.into_iter().map(named).collect()
}

/// Radiance HDR files, with their names.
pub fn hdrs() -> Vec<(String, Vec<u8>)> {
    let mut old = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n-Y 2 +X 4\n".to_vec();
    old.extend([9, 8, 7, 128].repeat(8));
    // A texel of which the first three bytes are 1 repeats the one before.
    let mut runs =
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2.5\nEXPOSURE=0.5\n\n-Y 2 +X 8\n".to_vec();
    runs.extend([9, 8, 7, 128, 1, 1, 1, 7].repeat(2));
    // What other programs write in the header.
    let mut turned = b"#?RGBE\r\nCOLORCORR= 1 0.5 2\r\n\r\n+X 2 -Y 3\r\n".to_vec();
    turned.extend([9, 8, 7, 128].repeat(6));
    let mut xyz = b"#?AUTOPANO\n# x\nFORMAT=32-bit_rle_xyze\n\n-X 2 +Y 3\n".to_vec();
    xyz.extend([9, 8, 7, 128].repeat(6));
    vec![
        ("runs.hdr".into(), runs),
        ("new.hdr".into(), encoded("rgb32f", ImageFormat::Hdr)),
        ("old.hdr".into(), old),
        ("turned.hdr".into(), turned),
        ("xyz.hdr".into(), xyz),
    ]
}

/// EXR files as other programs and `reference` write them, with their names.
pub fn exrs() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for (name, compression) in [
        ("none", Compression::Uncompressed),
        ("rle", Compression::RLE),
        ("zip1", Compression::ZIP1),
        ("zip16", Compression::ZIP16),
        ("piz", Compression::PIZ),
        ("pxr24", Compression::PXR24),
        ("b44", Compression::B44),
        ("b44a", Compression::B44A),
        ("dwaa", Compression::DWAA(None)),
    ] {
        for (kind, blocks) in [
            ("lines", Blocks::ScanLines),
            ("tiles", Blocks::Tiles(Vec2(8, 8))),
        ] {
            let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
                (f16::from_f32(at.x() as f32), at.y() as f32, 0.5_f32)
            });
            let mut encoding = Encoding {
                compression,
                blocks,
                line_order: LineOrder::Increasing,
            };
            let size = (SIZE.0 as usize, SIZE.1 as usize);
            let mut attributes = LayerAttributes::default();
            if compression == Compression::RLE {
                encoding.line_order = LineOrder::Decreasing;
                attributes.layer_position = Vec2(5, -7);
            }
            let layer = Layer::new(size, attributes, encoding, channels);
            let mut bytes = Cursor::new(Vec::new());
            exr::image::Image::from_layer(layer)
                .write()
                .to_buffered(&mut bytes)
                .expect("an EXR");
            let bytes = bytes.into_inner();
            if compression == Compression::ZIP16 {
                // The mode of levels, behind the width and the height of a tile; the sampling of the first channel, behind
                // its name, type and flag.
                files.extend(patched("mip", &bytes, b"tiledesc\0\x09\0\0\0", 8, &[1]));
                let sampling = [2, 0, 0, 0, 2, 0, 0, 0];
                files.extend(patched(
                    "sampled",
                    &bytes,
                    b"chlist\0",
                    4 + 2 + 8,
                    &sampling,
                ));
            }
            files.push((format!("{name}-{kind}.exr"), bytes));
        }
    }
    let parts = ["left", "right"].map(|name| {
        let channels = SpecificChannels::rgb(|at: Vec2<usize>| (at.x() as f32, 0.5_f32, 0.25_f32));
        let attributes = LayerAttributes::named(name);
        Layer::new((3, 2), attributes, Encoding::UNCOMPRESSED, channels)
    });
    let mut bytes = Cursor::new(Vec::new());
    // The data windows are smaller than the display window, and one of them lies partly outside of it.
    let display = IntegerBounds::new((-2, 1), (6, 4));
    let [left, mut right] = parts;
    right.attributes.layer_position = Vec2(2, 0);
    exr::image::Image::empty(ImageAttributes::new(display))
        .with_layer(left)
        .with_layer(right)
        .write()
        .to_buffered(&mut bytes)
        .expect("an EXR of two parts");
    files.push(("parts.exr".into(), bytes.into_inner()));
    let folder = Folder::new(&[]);
    for (name, layers) in [
        (
            "reference",
            &["", "stderr.", "resume.sum.", "resume.square."][..],
        ),
        ("layers", &["V.Combined.", "V.Env."]),
    ] {
        let mut picture = Image::new(4, 3);
        for layer in layers {
            let values: Vec<[f32; 3]> = (0..12_u8).map(|i| [i.into(), 0.25, 1e-6]).collect();
            picture.set_vectors(layer, ["R", "G", "B"], &values);
        }
        let ids = Samples::U32((0..12).collect());
        picture.channels.insert("instance.id".into(), ids);
        for (key, value) in [
            ("headwater.samples", "16"),
            ("headwater.settings", "{\"a\":1}"),
        ] {
            picture.metadata.insert(key.into(), value.into());
        }
        files.push((format!("{name}.exr"), written(&folder, &picture)));
    }
    for (name, channel) in [("grey", "Y"), ("depth", "depth.Z")] {
        let mut picture = Image::new(4, 3);
        let values = Samples::F32(vec![0.5; 12]);
        picture.channels.insert(channel.into(), values);
        files.push((format!("{name}.exr"), written(&folder, &picture)));
    }
    files
}

/// A file with other bytes at an offset from the end of a text, if it has the text.
fn patched(
    name: &str,
    bytes: &[u8],
    text: &[u8],
    offset: usize,
    other: &[u8],
) -> Option<(String, Vec<u8>)> {
    let found = bytes
        .windows(text.len())
        .position(|window| window == text)?;
    let start = found + text.len() + offset;
    let mut bytes = bytes.to_vec();
    bytes[start..start + other.len()].copy_from_slice(other);
    Some((format!("{name}.exr"), bytes))
}

fn written(folder: &Folder, picture: &Image) -> Vec<u8> {
    let path = folder.write("a.exr", &[]);
    picture.write(&path, 0.0).expect("an EXR");
    std::fs::read(&path).expect("the EXR")
}

/// A folder with the images that scenes of the corpus name.
pub fn folder() -> Folder {
    let png = encoded("rgb8", ImageFormat::Png);
    let jpg = encoded("rgb8", ImageFormat::Jpeg);
    let webp = encoded("rgba8", ImageFormat::WebP);
    // Most texels are vectors of unit length, so it is a normal map.
    let normals = image::RgbImage::from_pixel(5, 3, image::Rgb([180, 128, 240]));
    let mut normal = Cursor::new(Vec::new());
    (normals.write_to(&mut normal, ImageFormat::Png)).expect("an image that can be encoded");
    Folder::new(&[
        ("wall.png", &png),
        ("wall.jpg", &jpg),
        ("small.webp", &webp),
        ("normal.png", normal.get_ref()),
        ("triangle.bin", &Gltf::triangle().binary),
        ("my scene.mtl", b"newmtl other\nKd 1 0 0\n"),
    ])
}

/// A triangle with the image in the file of this name, as `.gltf`.
pub fn shown(name: &str) -> String {
    let mut file = Gltf::triangle();
    let uvs = file.add_view(&floats(&[[0.0; 3], [1.0; 3]]));
    let uvs = file.add_accessor(json!({
        "bufferView": uvs, "componentType": 5126, "count": 3, "type": "VEC2",
    }));
    file.primitive()["attributes"]["TEXCOORD_0"] = uvs.into();
    let file = file.with(|json| {
        json["images"] = json!([{ "uri": name }]);
        json["textures"] = json!([{ "source": 0 }]);
        json["materials"][0]["pbrMetallicRoughness"] =
            json!({ "baseColorTexture": { "index": 0 } });
    });
    in_one(&file)
}

/// A glTF file with its buffer in a data URI.
pub fn in_one(file: &Gltf) -> String {
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&file.binary);
    file.with_uri(&format!("data:application/octet-stream;base64,{data}"))
}

/// True if the first byte is that of EXR files.
pub fn is_exr(bytes: &[u8]) -> bool {
    bytes.first() == Some(&0x76)
}

/// True if an EXR's header can be read.
pub fn has_exr_header(bytes: &[u8]) -> bool {
    MetaData::read_from_buffered(Cursor::new(bytes), true).is_ok()
}

/// True if an HDR's header can be read: it has the first characters, an empty line, and after it a size with a height.
pub fn has_hdr_header(bytes: &[u8]) -> bool {
    let mut lines = bytes
        .split(|byte| *byte == b'\n')
        .map(<[u8]>::trim_ascii_end);
    let has_end = bytes.starts_with(b"#?") && lines.any(<[u8]>::is_empty);
    let size = lines.next().unwrap_or_default();
    has_end && size.contains(&b'Y') && size.split(|byte| *byte == b' ').count() == 4
}

/// True if the header of an image in one of these formats can be read.
pub fn has_image_header(bytes: &[u8], formats: &[ImageFormat]) -> bool {
    image_size(bytes, formats).is_some()
}

/// True if an image has a million texels or more.
pub fn is_large(bytes: &[u8]) -> bool {
    let size = image_size(bytes, &TEXTURE_FORMATS).or_else(|| ktx2_size(bytes));
    size.is_some_and(|(width, height)| u64::from(width) * u64::from(height) >= 1_000_000)
}

/// The width and height in the header of a KTX2 file.
pub fn ktx2_size(bytes: &[u8]) -> Option<(u32, u32)> {
    let fields = bytes.strip_prefix(b"\xABKTX 20\xBB\r\n\x1A\n")?;
    let word = |at: usize| Some(u32::from_le_bytes(*fields.get(at..)?.first_chunk()?));
    Some((word(8)?, word(12)?))
}

/// The width and height in the header of an image in one of these formats.
fn image_size(bytes: &[u8], formats: &[ImageFormat]) -> Option<(u32, u32)> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let reader = reader.ok()?;
    reader.format().filter(|format| formats.contains(format))?;
    reader.into_dimensions().ok()
}
