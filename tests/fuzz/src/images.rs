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

/// PNG files, with their names.
pub fn pngs() -> Vec<(String, Vec<u8>)> {
    [
        "grey8", "greya8", "rgb8", "rgba8", "grey16", "rgb16", "rgba16",
    ]
    .map(|form| (format!("{form}.png"), encoded(form, ImageFormat::Png)))
    .to_vec()
}

/// PNG, JPEG and WebP files, with their names.
pub fn textures() -> Vec<(String, Vec<u8>)> {
    let mut files = pngs();
    for form in ["grey8", "rgb8"] {
        files.push((format!("{form}.jpg"), encoded(form, ImageFormat::Jpeg)));
    }
    for form in ["rgb8", "rgba8"] {
        files.push((format!("{form}.webp"), encoded(form, ImageFormat::WebP)));
    }
    files
}

/// Radiance HDR files, with their names.
pub fn hdrs() -> Vec<(String, Vec<u8>)> {
    let mut old = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n-Y 2 +X 4\n".to_vec();
    old.extend([9, 8, 7, 128].repeat(8));
    vec![
        ("new.hdr".into(), encoded("rgb32f", ImageFormat::Hdr)),
        ("old.hdr".into(), old),
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
        ("dwaa", Compression::DWAA(None)),
    ] {
        for (kind, blocks) in [
            ("lines", Blocks::ScanLines),
            ("tiles", Blocks::Tiles(Vec2(8, 8))),
        ] {
            let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
                (f16::from_f32(at.x() as f32), at.y() as f32, 0.5_f32)
            });
            let encoding = Encoding {
                compression,
                blocks,
                line_order: LineOrder::Increasing,
            };
            let size = (SIZE.0 as usize, SIZE.1 as usize);
            let layer = Layer::new(size, LayerAttributes::default(), encoding, channels);
            let mut bytes = Cursor::new(Vec::new());
            exr::image::Image::from_layer(layer)
                .write()
                .to_buffered(&mut bytes)
                .expect("an EXR");
            files.push((format!("{name}-{kind}.exr"), bytes.into_inner()));
        }
    }
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
    Folder::new(&[
        ("wall.png", &png),
        ("wall.jpg", &jpg),
        ("small.webp", &webp),
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

/// True if an EXR's header can be read.
pub fn has_exr_header(bytes: &[u8]) -> bool {
    MetaData::read_from_buffered(Cursor::new(bytes), true).is_ok()
}

/// True if an HDR's header can be read.
pub fn has_hdr_header(bytes: &[u8]) -> bool {
    let mut reader = ImageReader::new(Cursor::new(bytes));
    reader.set_format(ImageFormat::Hdr);
    reader.into_dimensions().is_ok()
}

/// True if the header of a PNG, JPEG or WebP file can be read.
pub fn has_image_header(bytes: &[u8]) -> bool {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    matches!(reader.map(|reader| reader.into_dimensions()), Ok(Ok(_)))
}
