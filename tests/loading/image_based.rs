//! Tests of `EXT_lights_image_based`: the cube map of a file becomes the environment of the scene.

use crate::files::{Folder, Gltf};
use glam::{DQuat, DVec3, Vec3};
use headwater::scene::{Environment, Scene};
use headwater::scene_files::{Options, load_watched};
use image::{ImageFormat, Rgba, RgbaImage};
use serde_json::json;
use std::f64::consts::{PI, TAU};

/// The faces of a cube in the order of the extension, each by its direction and by the direction of its upper edge.
const FACES: [(DVec3, DVec3); 6] = [
    (DVec3::X, DVec3::Y),
    (DVec3::NEG_X, DVec3::Y),
    (DVec3::Y, DVec3::NEG_Z),
    (DVec3::NEG_Y, DVec3::Z),
    (DVec3::Z, DVec3::Y),
    (DVec3::NEG_Z, DVec3::Y),
];

/// A file whose scene has an image-based light, with faces of 8 × 8 texels by `texel`, which gets the index of a face and a
/// position on it from its upper left corner.
fn lit(texel: impl Fn(usize, u32, u32) -> [u8; 4], light: serde_json::Value) -> Gltf {
    let mut file = Gltf::triangle();
    let mut images = Vec::new();
    for face in 0..6 {
        let image = RgbaImage::from_fn(8, 8, |x, y| Rgba(texel(face, x, y)));
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let view = file.add_view(&bytes.into_inner());
        images.push(json!({ "bufferView": view, "mimeType": "image/png" }));
    }
    file.with(|json| {
        let mut own = json!({
            "specularImageSize": 8,
            "specularImages": [[0, 1, 2, 3, 4, 5], [0, 0, 0, 0, 0, 0]],
            "irradianceCoefficients": vec![[0; 3]; 9],
        });
        for (key, value) in light.as_object().unwrap() {
            own[key] = value.clone();
        }
        json["images"] = json!(images);
        json["extensionsUsed"] = json!(["EXT_lights_image_based"]);
        json["extensionsRequired"] = json!(["EXT_lights_image_based"]);
        json["extensions"] = json!({ "EXT_lights_image_based": { "lights": [own] } });
        json["scenes"][0]["extensions"] = json!({ "EXT_lights_image_based": { "light": 0 } });
    })
}

fn load(file: &Gltf) -> Scene {
    Folder::new().load("scene.glb", file.glb())
}

/// The radiance of the texel that is seen in a direction, times the intensity.
fn seen(environment: &Environment, toward: DVec3) -> Vec3 {
    assert_eq!(environment.rotation, 0.0);
    let around = toward.x.atan2(-toward.z) / TAU + 0.5;
    let down = toward.y.clamp(-1.0, 1.0).acos() / PI;
    let index = |part: f64, count: u32| ((part * f64::from(count)) as u32).min(count - 1);
    let (x, y) = (
        index(around, environment.width),
        index(down, environment.height),
    );
    environment.texels[(y * environment.width + x) as usize] * environment.intensity
}

fn linear(srgb: u8) -> f32 {
    match f32::from(srgb) / 255.0 {
        value if value <= 0.04045 => value / 12.92,
        value => ((value + 0.055) / 1.055).powf(2.4),
    }
}

#[test]
fn a_constant_cube_is_a_constant_environment() {
    let light = json!({ "name": "studio", "intensity": 3.0 });
    let scene = load(&lit(|_, _, _| [188, 100, 50, 255], light));
    assert_eq!(
        scene.notices,
        [
            "of image-based lights only the sharpest level is used, from which all reflections follow: image-based light 0 \"studio\""
        ]
    );
    let environment = scene.environment.unwrap();
    assert_eq!((environment.width, environment.height), (32, 16));
    let expected = Vec3::new(linear(188), linear(100), linear(50)) * 3.0;
    for texel in environment.texels.iter() {
        assert!((*texel * 3.0 - expected).length() < 1e-5, "{texel}");
    }
}

/// The alpha of a texel divides its colour, so that it can exceed 1.
#[test]
fn alpha_makes_colours_brighter() {
    let environment = |alpha| {
        load(&lit(|_, _, _| [188, 188, 188, alpha], json!({})))
            .environment
            .unwrap()
    };
    for (alpha, factor) in [(51, 5.0), (1, 255.0), (0, 255.0)] {
        let found = seen(&environment(alpha), DVec3::Y).x / linear(188);
        assert!((found / factor - 1.0).abs() < 1e-4, "{alpha}: {found}");
    }
}

/// Each quarter of each face has another colour, and is seen where the face lies around a viewer at its centre. A rotation
/// turns all of them.
#[test]
fn faces_lie_around_the_viewer() {
    let shade = |face: usize, right: bool, low: bool| {
        [
            40 * face as u8 + 40,
            100 + 100 * u8::from(right),
            100 + 100 * u8::from(low),
            255,
        ]
    };
    let quarter = DQuat::from_rotation_y(PI / 2.0);
    assert!((quarter * DVec3::X - DVec3::NEG_Z).length() < 1e-12);
    let tilted = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.8);
    for rotation in [DQuat::IDENTITY, quarter, tilted] {
        let light = json!({ "rotation": rotation.to_array() });
        let file = lit(|face, x, y| shade(face, x >= 4, y >= 4), light);
        let environment = load(&file).environment.unwrap();
        for (face, (forward, up)) in FACES.into_iter().enumerate() {
            let right = forward.cross(up);
            for (x, y) in [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)] {
                let toward = (forward + x * right - y * up).normalize();
                let [r, g, b, _] = shade(face, x > 0.0, y > 0.0).map(linear);
                let found = seen(&environment, rotation * toward);
                let off = (found - Vec3::new(r, g, b)).length();
                assert!(off < 1e-4, "{rotation} face {face} {x} {y}: {found}");
            }
        }
    }
}

/// The light that arrives from all directions is that of the cube, whose texels have different solid angles.
#[test]
fn the_light_of_a_cube_is_kept() {
    let texel =
        |face: usize, x: u32, y: u32| [((face as u32 * 41 + x * 67 + y * 29) % 256) as u8; 4];
    let opaque = |face, x, y| {
        let [value, ..] = texel(face, x, y);
        [value, value, value, 255]
    };
    let environment = load(&lit(opaque, json!({}))).environment.unwrap();
    let (found, _) = environment.integrals();
    // The solid angle per unit of area at a point of a face of the cube from −1 to 1, at the centres of texels.
    let mut expected = 0.0;
    for (face, x, y) in (0..6).flat_map(|f| (0..64).map(move |i| (f, i % 8, i / 8))) {
        let [u, v] = [x, y].map(|i| (f64::from(i) + 0.5) / 4.0 - 1.0);
        let solid_angle = 1.0 / 16.0 / (1.0 + u * u + v * v).powf(1.5);
        expected += solid_angle * f64::from(linear(texel(face, x, y)[0]));
    }
    assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
}

#[test]
fn wrong_lights_are_refused() {
    let plain = |light| lit(|_, _, _| [9; 4], light);
    for (file, text) in [
        (plain(json!({ "specularImages": [] })), "6 faces"),
        (
            plain(json!({ "specularImages": [[0, 1, 2, 3, 4]] })),
            "6 faces",
        ),
        (
            plain(json!({ "specularImages": [[0, 1, 2, 3, 4, 6]] })),
            "image 6 is out of range",
        ),
        (
            plain(json!({ "rotation": [0, 0, 0, 0] })),
            "unit quaternion",
        ),
        (plain(json!({ "intensity": -1 })), "intensity is -1"),
        (
            plain(json!({})).with(|json| {
                json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 1.into();
            }),
            "image-based light 1 is out of range",
        ),
    ] {
        let refusal = Folder::new().refuse("scene.glb", file.glb());
        assert!(refusal.contains(text), "{refusal}");
    }
}

/// A missing face takes the whole light away if the user permits this.
#[test]
fn a_cube_with_a_missing_face_is_left_out() {
    let file = lit(|_, _, _| [9; 4], json!({}))
        .with(|json| json["images"][3] = json!({ "uri": "missing.png" }));
    let folder = Folder::new();
    let refusal = folder.refuse("scene.glb", file.glb());
    assert!(refusal.contains("missing.png"), "{refusal}");
    let options = Options {
        allow_missing: true,
        ..Options::default()
    };
    let scene = load_watched(&folder.path("scene.glb"), options, &mut |_, _, _| Ok(())).unwrap();
    assert!(scene.environment.is_none());
    assert!(
        scene
            .notices
            .iter()
            .any(|notice| notice.contains("left out"))
    );
}
