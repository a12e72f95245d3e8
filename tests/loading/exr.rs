//! Tests of EXR files of other programs: data windows, parts, layers, grey and the types of samples.

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, ImageAttributes,
    IntegerBounds, Layer, LayerAttributes, Text, Vec2, WritableImage, f16,
};
use glam::Vec3;
use headwater::image::Image;
use headwater::scene::Environment;
use std::path::PathBuf;
use tempfile::TempDir;

/// A part of an EXR file: its name (empty for none), the position and the size of its data window, and its channels.
struct Part {
    name: &'static str,
    position: (i32, i32),
    size: (usize, usize),
    channels: Vec<(&'static str, FlatSamples)>,
}

/// A part of 2 × 1 pixels with these channels; channel number i has the values i + 0.25 and i + 0.5.
fn part(name: &'static str, channels: &[&'static str]) -> Part {
    let samples = |index: usize| FlatSamples::F32([0.25, 0.5].map(|v| v + index as f32).into());
    let channels = channels.iter().enumerate();
    Part {
        name,
        position: (0, 0),
        size: (2, 1),
        channels: channels
            .map(|(index, name)| (*name, samples(index)))
            .collect(),
    }
}

/// Writes an EXR file whose display window has its corner at (−3, 5) and `size` pixels. The positions of `parts` are
/// relative to the display window.
fn write(size: (usize, usize), parts: Vec<Part>) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let layers = parts.into_iter().map(|part| {
        let mut attributes = LayerAttributes {
            layer_position: Vec2(part.position.0 - 3, part.position.1 + 5),
            ..LayerAttributes::default()
        };
        attributes.layer_name = (!part.name.is_empty()).then(|| Text::from(part.name));
        let channels = part.channels.into_iter();
        let channels = channels.map(|(name, samples)| AnyChannel::new(name, samples));
        let channels = AnyChannels::sort(channels.collect());
        Layer::new(part.size, attributes, Encoding::SMALL_LOSSLESS, channels)
    });
    let image = ExrImage {
        attributes: ImageAttributes::new(IntegerBounds::new((-3, 5), size)),
        layer_data: layers.collect::<exr::image::Layers<_>>(),
    };
    image.write().to_file(&path).unwrap();
    (folder, path)
}

/// The environment of a file and the notices about it.
fn open(size: (usize, usize), parts: Vec<Part>) -> (Environment, Vec<String>) {
    let (_folder, path) = write(size, parts);
    let mut notices = Vec::new();
    let environment = Environment::open(path.to_str().unwrap(), &mut notices).unwrap();
    (environment, notices)
}

#[test]
fn pixels_stand_where_the_data_window_is() {
    // Three by two pixels of data at the corners of a display window of four by three, and around it.
    for position in [
        (0, 0),
        (1, 1),
        (-1, -1),
        (-2, 2),
        (3, -1),
        (0, 3),
        (-3, 0),
        (9, 9),
    ] {
        let values = |channel: usize| {
            let values = (0..6).map(|i| (i + 1 + 10 * channel) as f32);
            FlatSamples::F32(values.collect())
        };
        let cropped = Part {
            name: "",
            position,
            size: (3, 2),
            channels: vec![("B", values(2)), ("G", values(1)), ("R", values(0))],
        };
        let (environment, notices) = open((4, 3), vec![cropped]);
        assert_eq!((environment.width, environment.height), (4, 3));
        for (index, texel) in environment.texels.iter().enumerate() {
            let (x, y) = (
                (index % 4) as i32 - position.0,
                (index / 4) as i32 - position.1,
            );
            let expected = match (0..3).contains(&x) && (0..2).contains(&y) {
                true => Vec3::new(1.0, 11.0, 21.0) + (x + 3 * y) as f32,
                false => Vec3::ZERO,
            };
            assert_eq!(*texel, expected, "{position:?} {x} {y}");
        }
        assert!(notices.is_empty(), "{notices:?}");
    }
}

#[test]
fn a_display_window_that_fills_the_memory_is_refused() {
    let rgb = || vec![part("", &["R", "G", "B"])];
    let (_folder, path) = write((8192, 4096), rgb());
    assert_eq!(Image::read(&path).unwrap().width, 8192);
    for size in [(100_000, 100_000), (16384, 8192)] {
        let (_folder, path) = write(size, rgb());
        let text = Image::read(&path).unwrap_err().to_string();
        let window = format!("its display window has {} × {} pixels", size.0, size.1);
        assert!(text.contains(&window) && text.contains("crop it"), "{text}");
    }
}

#[test]
fn the_picture_is_found_among_layers_and_parts() {
    let rgb = ["R", "G", "B"];
    for (parts, layer, red) in [
        (
            vec![part("", &["diffuse.R", "diffuse.G", "diffuse.B"])],
            Some("diffuse"),
            0.25,
        ),
        (
            vec![part(
                "",
                &[
                    "A.R",
                    "A.G",
                    "A.B",
                    "V.Combined.R",
                    "V.Combined.G",
                    "V.Combined.B",
                ],
            )],
            Some("V.Combined"),
            3.25,
        ),
        // The first part is the picture, unless another one is called so.
        (vec![part("main", &rgb), part("albedo", &rgb)], None, 0.25),
        (
            vec![part("main", &["A", "R", "G", "B"]), part("Beauty", &rgb)],
            Some("Beauty"),
            0.25,
        ),
        (
            vec![part("rgba", &["A", "R", "G", "B"]), part("depth", &["Z"])],
            Some("rgba"),
            1.25,
        ),
        (
            vec![part("depth", &["Z"]), part("main", &["A", "R", "G", "B"])],
            Some("main"),
            1.25,
        ),
        // As Blender writes parts: their channels have the whole name.
        (
            vec![
                part(
                    "V.Combined",
                    &[
                        "V.Combined.A",
                        "V.Combined.R",
                        "V.Combined.G",
                        "V.Combined.B",
                    ],
                ),
                part("V.Depth", &["V.Depth.Z"]),
            ],
            Some("V.Combined"),
            1.25,
        ),
        (vec![part("", &["Y"])], None, 0.25),
    ] {
        let names: Vec<&str> = parts.iter().map(|part| part.name).collect();
        let is_grey = parts[0].channels[0].0 == "Y";
        let (environment, notices) = open((2, 1), parts);
        let next = if is_grey {
            Vec3::ZERO
        } else {
            Vec3::new(0.0, 1.0, 2.0)
        };
        let expected = [red, red + 0.25].map(|red| red + next);
        assert_eq!(*environment.texels, expected, "{names:?} {layer:?}");
        match (layer, notices.as_slice()) {
            (None, []) => {}
            (Some(layer), [notice]) => {
                assert!(
                    notice.ends_with(&format!("its layer {layer:?} is shown")),
                    "{notice}"
                );
            }
            _ => panic!("{names:?} {layer:?}: {notices:?}"),
        }
    }
}

#[test]
fn parts_keep_their_channels_and_their_data_windows() {
    let mut depth = part("depth", &["Z"]);
    depth.position = (1, 1);
    let (_folder, path) = write((3, 2), vec![part("main", &["R"]), depth]);
    let image = Image::read(&path).unwrap();
    assert_eq!(image.floats("R").unwrap(), [0.25, 0.5, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(
        image.floats("depth.Z").unwrap(),
        [0.0, 0.0, 0.0, 0.0, 0.25, 0.5]
    );
}

#[test]
fn halves_floats_and_integers_are_one_picture() {
    let mixed = Part {
        channels: vec![
            ("B", FlatSamples::U32(vec![3, 70_000])),
            ("G", FlatSamples::F16([0.5, 2.0].map(f16::from_f32).into())),
            ("R", FlatSamples::F32(vec![1e-6, 1e6])),
        ],
        ..part("", &[])
    };
    let (environment, notices) = open((2, 1), vec![mixed]);
    assert_eq!(
        *environment.texels,
        [Vec3::new(1e-6, 0.5, 3.0), Vec3::new(1e6, 2.0, 70_000.0)]
    );
    assert!(notices.is_empty(), "{notices:?}");
}

#[test]
fn subsampled_colour_is_refused_in_a_clear_line() {
    let (_folder, path) = write((2, 1), vec![part("", &["BY", "RY", "Y"])]);
    let text = Environment::open(path.to_str().unwrap(), &mut Vec::new())
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("neither channels R, G, B nor Y, but BY, RY, Y"),
        "{text}"
    );
    // The sampling of BY: the two numbers before the name of the next channel.
    let mut bytes = std::fs::read(&path).unwrap();
    let at = bytes
        .windows(3)
        .position(|window| window == b"RY\0")
        .unwrap();
    bytes[at - 8] = 2;
    std::fs::write(&path, bytes).unwrap();
    let text = Image::read(&path).unwrap_err().to_string();
    assert!(
        text.contains("it has subsampled channels") && text.contains("save it as RGB"),
        "{text}"
    );
}
