//! Tests with one file per feature of scene files: each is rendered, and compared with a closed form at every pixel.
//!
//! Each file shows a square that fills the picture, seen from straight above, so that the point of the square at every pixel
//! is known.

#[path = "loading/files.rs"]
#[allow(dead_code)] // Of what loading needs, this is a part.
mod files;
mod support;

use files::{Folder, Gltf};
use glam::{DVec2, DVec3};
use headwater::render::View;
use headwater::render::presets::Preset;
use headwater::scene::{Environment, Scene};
use headwater::shader_interface::Tracer;
use image::{ImageFormat, RgbaImage};
use serde_json::{Value, json};

/// Width and height of the pictures in pixels.
const SIDE: u32 = 32;
/// Distance of the camera from the square, in units of half the side of the square.
const DISTANCE: f64 = 4.0;
const SAMPLES: u32 = 256;
/// The number of standard errors by which a pixel, or the sum of all pixels, may differ from the closed form. It is so large
/// that chance makes none of the thousands of compared values fail.
const SIGMAS: f64 = 6.5;
/// The maximum standard error of the sum of all pixels, relative to the sum; with a larger one, the comparison would prove
/// nothing.
const MAX_HALF_WIDTH: f64 = 1e-3;
/// Distance from the edge of a texel, in texels, within which a pixel is not compared, since rounding may show either side.
const EDGE: f64 = 1e-3;

/// The image that most tests use as a texture: RGBA bytes in sRGB, row by row from the top.
const TEXELS: [[[u8; 4]; 2]; 2] = [
    [[200, 40, 90, 255], [30, 220, 120, 255]],
    [[60, 70, 240, 255], [250, 240, 10, 0]],
];

/// The point of the square that a pixel shows: x and y in [−1, 1], y upwards.
fn point(pixel: usize) -> DVec2 {
    let at = |i: usize| (i as f64 + 0.5) / f64::from(SIDE) * 2.0 - 1.0;
    DVec2::new(at(pixel % SIDE as usize), -at(pixel / SIDE as usize))
}

/// The texture coordinates of a point of the square: [0, 1], from the top left.
fn uv(point: DVec2) -> DVec2 {
    DVec2::new(point.x + 1.0, 1.0 - point.y) / 2.0
}

fn linear(srgb: u8) -> f64 {
    let value = f64::from(srgb) / 255.0;
    match value <= 0.04045 {
        true => value / 12.92,
        false => ((value + 0.055) / 1.055).powf(2.4),
    }
}

fn color([r, g, b, _]: [u8; 4]) -> DVec3 {
    DVec3::new(linear(r), linear(g), linear(b))
}

/// The nearest texel at texture coordinates, for an image that repeats; `None` at an edge between texels.
fn texel(at: DVec2) -> Option<[u8; 4]> {
    let position = at * 2.0;
    let edge = (position - position.round()).abs().min_element();
    let index = |x: f64| x.floor().rem_euclid(2.0) as usize;
    (edge > EDGE).then(|| TEXELS[index(position.y)][index(position.x)])
}

/// The linear colour of the nearest texel at texture coordinates; `None` at an edge between texels.
fn shown(at: DVec2) -> Option<DVec3> {
    texel(at).map(color)
}

/// The linear colour at texture coordinates, interpolated between the centres of texels, and constant beyond the outer
/// centres.
fn interpolated(at: DVec2) -> DVec3 {
    let part = (at * 2.0 - 0.5).clamp(DVec2::ZERO, DVec2::ONE);
    let row = |y: usize| color(TEXELS[y][0]).lerp(color(TEXELS[y][1]), part.x);
    row(0).lerp(row(1), part.y)
}

fn encoded(format: ImageFormat) -> Vec<u8> {
    let image = RgbaImage::from_fn(2, 2, |x, y| image::Rgba(TEXELS[y as usize][x as usize]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn floats(file: &mut Gltf, kind: &str, values: &[f64]) -> usize {
    let bytes: Vec<u8> = (values.iter())
        .flat_map(|value| (*value as f32).to_le_bytes())
        .collect();
    let width: usize = kind[3..].parse().unwrap();
    let view = file.add_view(&bytes);
    file.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": values.len() / width, "type": kind,
    }))
}

/// A file with the square, a Lambert surface with one set of texture coordinates, and the camera.
fn square() -> Gltf {
    let mut file = Gltf::triangle();
    let corners = [
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
    ];
    let positions = file.add_vectors(&corners);
    let indices = file.add_indices(5123, &[0, 1, 2, 0, 2, 3]);
    let uvs = floats(&mut file, "VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    *file.primitive() = json!({
        "attributes": { "POSITION": positions, "TEXCOORD_0": uvs }, "indices": indices, "material": 0,
    });
    file.with(|json| {
        json["nodes"][1]["translation"] = json!([0.0, 0.0, DISTANCE]);
        json["cameras"][0]["perspective"] =
            json!({ "yfov": 2.0 * (1.0 / DISTANCE).atan(), "aspectRatio": 1.0, "znear": 0.1 });
        json["materials"][0] = json!({
            "pbrMetallicRoughness": { "metallicFactor": 0.0 },
            "extensions": { "KHR_materials_specular": { "specularFactor": 0.0 } },
        });
    })
}

/// The square with a base colour texture whose image is in the file; `sampler` and `info` are JSON of the texture.
fn pictured(mime: &str, bytes: &[u8], sampler: Value, info: Value) -> Gltf {
    let mut file = square();
    let view = file.add_view(bytes);
    file.with(|json| {
        json["images"] = json!([{ "mimeType": mime, "bufferView": view }]);
        json["samplers"] = json!([sampler]);
        json["textures"] = json!([{ "source": 0, "sampler": 0 }]);
        let surface = &mut json["materials"][0]["pbrMetallicRoughness"];
        surface["baseColorTexture"] = info;
    })
}

/// The square with the image [`TEXELS`] as a base colour texture that is read from the nearest texel.
fn tiled(info: Value) -> Gltf {
    pictured(
        "image/png",
        &encoded(ImageFormat::Png),
        json!({ "magFilter": 9728 }),
        info,
    )
}

fn push(list: &mut Value, value: Value) {
    list.as_array_mut().unwrap().push(value);
}

fn load(file: &Gltf) -> Scene {
    let scene = Folder::new().load("scene.glb", file.glb());
    assert_eq!(scene.notices, Vec::<String>::new());
    scene
}

/// The scene with an environment of the same radiance in all directions.
fn surrounded(mut scene: Scene, radiance: f32) -> Scene {
    scene.environment = Some(Environment {
        name: "uniform".into(),
        width: 4,
        height: 2,
        texels: vec![glam::Vec3::splat(radiance); 8].into(),
        rotation: 0.0,
        intensity: 1.0,
    });
    scene
}

/// The view that fills the picture with the square.
fn view_of(scene: &Scene, bounces: u32) -> View {
    View {
        camera: scene.cameras[0].clone(),
        width: SIDE,
        height: SIDE,
        seed: 3,
        bounces,
        jitter: false,
    }
}

/// Renders a scene and compares each pixel with the value of `expected` at the point that it shows, within noise and the
/// relative error `slack`. `None` leaves the pixel out.
fn assert_shows(name: &str, scene: &Scene, slack: f64, expected: impl Fn(DVec2) -> Option<DVec3>) {
    assert_shows_after(SAMPLES, name, scene, slack, expected);
}

/// The same with another number of samples per pixel.
fn assert_shows_after(
    samples: u32,
    name: &str,
    scene: &Scene,
    slack: f64,
    expected: impl Fn(DVec2) -> Option<DVec3>,
) {
    let (device, selection) = support::open_device(None);
    let view = view_of(scene, 1);
    let settings = Preset::named("path-tracing").unwrap().settings().unwrap();
    let found = support::render(&device, scene, selection.variant, &view, &settings, samples);
    support::assert_no_messages(&device);
    let (mut compared, mut sum, mut difference, mut variance) = (0, 0.0, 0.0, 0.0);
    for (pixel, (mean, error)) in found.mean.iter().zip(&found.error_squared).enumerate() {
        let at = point(pixel);
        let Some(expected) = expected(at) else {
            continue;
        };
        compared += 1;
        for channel in 0..3 {
            let (mean, expected) = (mean[channel], expected[channel]);
            let allowed = SIGMAS * error[channel].sqrt() + (slack + 2e-5) * expected + 1e-7;
            assert!(
                (mean - expected).abs() <= allowed,
                "{name} at {at}, channel {channel}: {mean} instead of {expected} ± {allowed}"
            );
            sum += expected;
            difference += mean - expected;
            variance += error[channel];
        }
    }
    let shown = (SIDE * SIDE) as usize;
    assert!(compared > shown / 2, "{name}: {compared} pixels compared");
    let error = variance.sqrt();
    println!(
        "{name}: {:.4} of what is expected, ± {:.4}",
        1.0 + difference / sum,
        error / sum
    );
    assert!(
        error <= MAX_HALF_WIDTH * sum,
        "{name}: too noisy to show anything"
    );
    let allowed = SIGMAS * error + (slack + 2e-5) * sum;
    assert!(
        difference.abs() <= allowed,
        "{name}: the sum is off by {difference}, not {allowed}"
    );
}

#[test]
fn png_and_webp_are_laid_onto_surfaces() {
    let png = tiled(json!({ "index": 0 }));
    assert_shows("PNG", &surrounded(load(&png), 1.0), 0.0, |at| shown(uv(at)));
    let mut webp = png.clone();
    let view = webp.add_view(&encoded(ImageFormat::WebP));
    let webp = webp.with(|json| {
        json["images"] = json!([{ "mimeType": "image/webp", "bufferView": view }]);
        json["textures"] =
            json!([{ "sampler": 0, "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
        json["extensionsUsed"] = json!(["EXT_texture_webp"]);
    });
    assert_shows("WebP", &surrounded(load(&webp), 1.0), 0.0, |at| {
        shown(uv(at))
    });
}

/// A JPEG texture of grey blocks of 16 texels, for which JPEG keeps each value within one step.
#[test]
fn jpeg_is_laid_onto_surfaces() {
    let greys = [60_u8, 200];
    let image = image::RgbImage::from_fn(32, 32, |x, _| image::Rgb([greys[x as usize / 16]; 3]));
    let mut bytes = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100);
    image.write_with_encoder(encoder).unwrap();
    let file = pictured(
        "image/jpeg",
        &bytes,
        json!({ "magFilter": 9728 }),
        json!({ "index": 0 }),
    );
    // One step of the darker grey changes its linear value by 3 %.
    assert_shows("JPEG", &surrounded(load(&file), 1.0), 0.035, |at| {
        Some(DVec3::splat(linear(greys[usize::from(at.x > 0.0)])))
    });
}

#[test]
fn texels_are_interpolated_in_linear_light() {
    let sampler = json!({ "magFilter": 9729, "wrapS": 33071, "wrapT": 33071 });
    let png = encoded(ImageFormat::Png);
    let file = pictured("image/png", &png, sampler, json!({ "index": 0 }));
    assert_shows("linear", &surrounded(load(&file), 1.0), 0.0, |at| {
        Some(interpolated(uv(at)))
    });
}

#[test]
fn the_second_set_of_coordinates_is_its_own() {
    let mut file = tiled(json!({ "index": 0, "texCoord": 1 }));
    // Those of the first, with u and v exchanged.
    let uvs = floats(&mut file, "VEC2", &[1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0]);
    file.primitive()["attributes"]["TEXCOORD_1"] = uvs.into();
    assert_shows("second set", &surrounded(load(&file), 1.0), 0.0, |at| {
        let DVec2 { x, y } = uv(at);
        shown(DVec2::new(y, x))
    });
}

/// KHR_texture_transform must scale, then rotate towards −v, then translate.
#[test]
fn textures_are_scaled_turned_and_moved() {
    let (offset, angle, scale) = (DVec2::new(0.3, -0.2), 0.4_f64, DVec2::new(2.0, 3.0));
    let file = tiled(
        json!({ "index": 0, "extensions": { "KHR_texture_transform": {
        "offset": offset.to_array(), "rotation": angle, "scale": scale.to_array(),
    } } }),
    );
    let file = file.with(|json| json["extensionsUsed"] = json!(["KHR_texture_transform"]));
    assert_shows("transform", &surrounded(load(&file), 1.0), 0.0, |at| {
        let scaled = uv(at) * scale;
        let (sin, cos) = angle.sin_cos();
        let u = cos * scaled.x + sin * scaled.y;
        let v = -sin * scaled.x + cos * scaled.y;
        shown(DVec2::new(u, v) + offset)
    });
}

#[test]
fn images_end_or_are_mirrored_at_their_edges() {
    let sampler = json!({ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 });
    let png = encoded(ImageFormat::Png);
    let mut file = pictured("image/png", &png, sampler, json!({ "index": 0 }));
    let uvs = floats(
        &mut file,
        "VEC2",
        &[-1.0, 3.0, 3.0, 3.0, 3.0, -1.0, -1.0, -1.0],
    );
    file.primitive()["attributes"]["TEXCOORD_0"] = uvs.into();
    assert_shows("wrap", &surrounded(load(&file), 1.0), 0.0, |at| {
        let wide = uv(at) * 4.0 - 1.0;
        let v = wide.y.rem_euclid(2.0);
        let v = if v > 1.0 { 2.0 - v } else { v };
        shown(DVec2::new(wide.x.clamp(2.0 * EDGE, 1.0 - 2.0 * EDGE), v))
    });
}

#[test]
fn colours_of_vertices_are_interpolated() {
    let mut file = square();
    let at = |x: f64, y: f64| DVec3::new(0.5 + 0.25 * x, 0.5 + 0.3 * y, 0.4 - 0.1 * x + 0.2 * y);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let colors: Vec<f64> = corners
        .iter()
        .flat_map(|(x, y)| at(*x, *y).to_array())
        .collect();
    let colors = floats(&mut file, "VEC3", &colors);
    file.primitive()["attributes"]["COLOR_0"] = colors.into();
    assert_shows("vertex colours", &surrounded(load(&file), 1.0), 0.0, |p| {
        Some(at(p.x, p.y))
    });
}

/// The blue channel of the texture is metalness: where it is 0, the surface must be Lambert, for every metallic factor.
#[test]
fn metalness_may_be_a_texture() {
    let file = tiled(json!({ "index": 0 }));
    let mut black = std::io::Cursor::new(Vec::new());
    let image = RgbaImage::from_pixel(1, 1, image::Rgba([255, 128, 0, 255]));
    image.write_to(&mut black, ImageFormat::Png).unwrap();
    let mut file = file;
    let view = file.add_view(&black.into_inner());
    let file = file.with(|json| {
        push(
            &mut json["images"],
            json!({ "bufferView": view, "mimeType": "image/png" }),
        );
        push(&mut json["textures"], json!({ "source": 1 }));
        let surface = &mut json["materials"][0]["pbrMetallicRoughness"];
        surface["metallicFactor"] = json!(1.0);
        surface["metallicRoughnessTexture"] = json!({ "index": 1 });
    });
    assert_shows("metalness", &surrounded(load(&file), 1.0), 0.0, |at| {
        shown(uv(at))
    });
}

/// A black mirror shows a uniform room by its Fresnel term alone: the alpha of one texture multiplies its strength, the colour
/// of another its reflectance at normal incidence, which a factor of 30 lifts to the limit of 1 in some channels.
#[test]
fn specular_reflection_may_be_textures() {
    let ior = 1.5_f64;
    let tint = DVec3::new(30.0, 2.0, 1.0);
    let file = |textures: [bool; 2]| {
        tiled(json!({ "index": 0 })).with(|json| {
            let mut specular =
                json!({ "specularFactor": 0.75, "specularColorFactor": tint.to_array() });
            for (name, _) in (["specularTexture", "specularColorTexture"]
                .iter()
                .zip(textures))
            .filter(|(_, is_used)| *is_used)
            {
                specular[*name] = json!({ "index": 0 });
            }
            json["extensionsUsed"] = json!(["KHR_materials_specular"]);
            json["materials"][0] = json!({
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 0,
                },
                "extensions": { "KHR_materials_specular": specular },
            });
        })
    };
    for [has_strength, has_color] in [[true, false], [false, true], [true, true]] {
        let scene = surrounded(load(&file([has_strength, has_color])), 1.0);
        assert_shows("specular textures", &scene, 1e-5, |at| {
            let texel = texel(uv(at))?;
            let alpha = f64::from(texel[3]) / 255.0;
            let strength = 0.75 * if has_strength { alpha } else { 1.0 };
            let color = if has_color { color(texel) } else { DVec3::ONE };
            let f0 = (((ior - 1.0) / (ior + 1.0)).powi(2) * tint * color).min(DVec3::ONE);
            let cosine = DISTANCE / at.extend(DISTANCE).length();
            let grazing = (1.0 - cosine).powi(5);
            Some(strength * (f0 * (1.0 - grazing) + grazing))
        });
    }
}

/// The camera must see the environment through the holes of a surface with alpha mode mask.
#[test]
fn masks_have_holes() {
    let file = tiled(json!({ "index": 0 }));
    let file = file.with(|json| json["materials"][0]["alphaMode"] = json!("MASK"));
    assert_shows("MASK", &surrounded(load(&file), 0.5), 0.0, |at| {
        let texel = texel(uv(at))?;
        Some(
            if texel[3] == 0 {
                DVec3::ONE
            } else {
                color(texel)
            } * 0.5,
        )
    });
}

#[test]
fn blended_surfaces_cover_a_part() {
    let alpha = 0.25;
    let file = tiled(json!({ "index": 0 })).with(|json| {
        json["materials"][0]["alphaMode"] = json!("BLEND");
        json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] =
            json!([1.0, 1.0, 1.0, alpha]);
    });
    assert_shows("BLEND", &surrounded(load(&file), 2.0), 0.0, |at| {
        let texel = texel(uv(at))?;
        let cover = alpha * f64::from(texel[3]) / 255.0;
        Some((color(texel) * cover + (1.0 - cover)) * 2.0)
    });
}

/// An emitter that covers a part of each point emits by this part, and shows what is behind it by the rest: black, or a room.
#[test]
fn blended_emitters_emit_by_what_they_cover() {
    let (alpha, emission) = (0.25, DVec3::new(1.0, 0.5, 0.125));
    let file = tiled(json!({ "index": 0 })).with(|json| {
        let material = &mut json["materials"][0];
        material["alphaMode"] = json!("BLEND");
        material["emissiveFactor"] = json!(emission.to_array());
        material["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.0, 0.0, 0.0, alpha]);
    });
    let [alone, inside] = [load(&file), surrounded(load(&file), 2.0)];
    for (name, scene, behind) in [("over black", alone, 0.0), ("in a room", inside, 2.0)] {
        // Chance decides for each sample whether it ends at the emitter.
        assert_shows_after(16 * SAMPLES, name, &scene, 0.0, |at| {
            let cover = alpha * f64::from(texel(uv(at))?[3]) / 255.0;
            Some(emission * cover + behind * (1.0 - cover))
        });
    }
}

#[test]
fn emission_may_be_a_texture() {
    let file = tiled(json!({ "index": 0 })).with(|json| {
        let material = &mut json["materials"][0];
        let texture = material["pbrMetallicRoughness"]["baseColorTexture"].take();
        *material = json!({
            "pbrMetallicRoughness": { "baseColorFactor": [0.0, 0.0, 0.0, 1.0], "metallicFactor": 0.0 },
            "emissiveTexture": texture,
            "emissiveFactor": [1.0, 0.5, 0.25],
            "extensions": {
                "KHR_materials_emissive_strength": { "emissiveStrength": 8.0 },
                "KHR_materials_specular": { "specularFactor": 0.0 },
            },
        });
    });
    assert_shows("emissive texture", &load(&file), 0.0, |at| {
        Some(shown(uv(at))? * DVec3::new(8.0, 4.0, 2.0))
    });
}

#[test]
fn unlit_surfaces_are_seen_as_they_are() {
    let file = tiled(json!({ "index": 0 })).with(|json| {
        json["materials"][0]["extensions"] = json!({ "KHR_materials_unlit": {} });
        json["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    });
    assert_shows("unlit", &surrounded(load(&file), 7.0), 0.0, |at| {
        shown(uv(at))
    });
}

/// The square under a large wall at the height 0.5, which shows the camera its back, unless its material is double-sided.
fn under_a_wall(material: Value, is_double_sided: bool) -> Gltf {
    tiled(json!({ "index": 0 })).with(|json| {
        json["materials"][0]["extensions"] = material;
        json["extensionsUsed"] = json!(["KHR_materials_unlit", "KHR_materials_specular"]);
        let mut wall = json["meshes"][0].clone();
        wall["primitives"][0]["material"] = json!(1);
        push(&mut json["meshes"], wall);
        push(
            &mut json["materials"],
            json!({
                "pbrMetallicRoughness": { "baseColorFactor": [0.0, 0.0, 0.0, 1.0], "metallicFactor": 0.0 },
                "extensions": { "KHR_materials_specular": { "specularFactor": 0.0 } },
                "doubleSided": is_double_sided,
            }),
        );
        // Turned about x, so that it faces the square.
        push(
            &mut json["nodes"],
            json!({
                "mesh": 1, "translation": [0.0, 0.0, 0.5], "rotation": [1.0, 0.0, 0.0, 0.0], "scale": [100, 100, 100],
            }),
        );
        json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    })
}

/// The camera looks through the back of a single-sided surface, with both tracers and with reuse. Light does not pass.
#[test]
fn the_camera_does_not_see_backs_but_light_meets_them() {
    let unlit = json!({ "KHR_materials_unlit": {} });
    let culled = load(&under_a_wall(unlit.clone(), false));
    let seen = load(&under_a_wall(unlit, true));
    assert_shows("culled", &surrounded(culled.clone(), 7.0), 0.0, |at| {
        shown(uv(at))
    });
    let matte = json!({ "KHR_materials_specular": { "specularFactor": 0.0 } });
    let dark = surrounded(load(&under_a_wall(matte, false)), 7.0);
    let tracers = [Tracer::ComputeBvh, Tracer::RayQuery].into_iter();
    for variant in tracers.filter_map(|tracer| support::variants(tracer).first().copied()) {
        let (device, _) = support::open_device(Some(variant));
        for preset in ["path-tracing", "accurate"] {
            let settings = Preset::named(preset).unwrap().settings().unwrap();
            let mean = |scene: &Scene| {
                let view = view_of(scene, 2);
                support::render(&device, scene, variant, &view, &settings, 4).mean
            };
            for (pixel, color) in mean(&culled).iter().enumerate() {
                if let Some(expected) = shown(uv(point(pixel))) {
                    let off = (DVec3::from_array(*color) - expected).abs().max_element();
                    assert!(off < 1e-5, "{preset} {variant:?}: {color:?} {expected}");
                }
            }
            // The backs of double-sided surfaces are seen, and the environment, whose radiance is 7, does not light what is
            // behind the wall, except through a slit at the horizon.
            for scene in [&seen, &dark] {
                let most = mean(scene).iter().flatten().copied().fold(0.0, f64::max);
                assert!(most < 0.2, "{preset} {variant:?}: {most}");
            }
        }
        support::assert_no_messages(&device);
    }
}

/// Positions may be signed integers of 16 bits, and texture coordinates unsigned integers of 16 bits.
#[test]
fn positions_and_coordinates_may_be_integers() {
    let mut file = tiled(json!({ "index": 0 }));
    let bytes = |values: &[i32]| -> Vec<u8> {
        (values.iter())
            .flat_map(|value| (*value as u16).to_le_bytes())
            .collect()
    };
    const ONE: i32 = 32767;
    // A stride of 8 bytes, as glTF asks for.
    let positions = [
        [-ONE, -ONE, 0, 0],
        [ONE, -ONE, 0, 0],
        [ONE, ONE, 0, 0],
        [-ONE, ONE, 0, 0],
    ];
    let view = file.add_view(&bytes(&positions.concat()));
    file.json["bufferViews"][view]["byteStride"] = 8.into();
    let positions = file.add_accessor(json!({
        "bufferView": view, "componentType": 5122, "normalized": true, "count": 4, "type": "VEC3",
    }));
    let view = file.add_view(&bytes(&[0, 65535, 65535, 65535, 65535, 0, 0, 0]));
    let uvs = file.add_accessor(json!({
        "bufferView": view, "componentType": 5123, "normalized": true, "count": 4, "type": "VEC2",
    }));
    file.primitive()["attributes"] = json!({ "POSITION": positions, "TEXCOORD_0": uvs });
    let file = file.with(|json| {
        json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    });
    assert_shows("quantization", &surrounded(load(&file), 1.0), 0.0, |at| {
        shown(uv(at))
    });
}

/// The square from an OBJ file with a material, whose v axis points up.
fn obj(material: &str) -> Scene {
    let folder = Folder::new();
    folder.write("tiles.png", encoded(ImageFormat::Png));
    folder.write("square.mtl", format!("newmtl square\n{material}\n"));
    let mut scene = folder.load(
        "square.obj",
        "mtllib square.mtl\nusemtl square\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n\
         vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n",
    );
    scene.cameras = load(&square()).cameras;
    scene
}

#[test]
fn maps_of_obj_files_are_laid_onto_surfaces() {
    let clamped = "-clamp on tiles.png";
    let reflects = obj(&format!("Kd 1 1 1\nmap_Kd {clamped}"));
    assert_shows("map_Kd", &surrounded(reflects, 1.0), 0.0, |at| {
        Some(interpolated(uv(at)))
    });
    let emits = obj(&format!("Kd 0 0 0\nKe 2 2 2\nmap_Ke {clamped}"));
    assert_shows("map_Ke", &emits, 0.0, |at| Some(interpolated(uv(at)) * 2.0));
}

/// The square under one light of `KHR_lights_punctual` at a position; the light shines down, rotated by the angle `turn`
/// about x.
fn lit(light: Value, position: DVec3, turn: f64) -> Scene {
    let (sin, cos) = (turn / 2.0).sin_cos();
    load(&square().with(|json| {
        json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
        push(
            &mut json["nodes"],
            json!({
                "translation": position.to_array(),
                "rotation": [sin, 0.0, 0.0, cos],
                "extensions": { "KHR_lights_punctual": { "light": 0 } },
            }),
        );
        json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    }))
}

#[test]
fn punctual_lights_shine_as_the_extension_says() {
    let (position, turn) = (DVec3::new(0.3, -0.2, 0.9), 0.35_f64);
    let axis = DVec3::new(0.0, turn.sin(), -turn.cos());
    let (tint, intensity) = (DVec3::new(1.0, 0.5, 0.25), 6.0);
    let light =
        |kind: &str| json!({ "type": kind, "color": tint.to_array(), "intensity": intensity });
    // Cosine over squared distance, and the cosine to the light's axis.
    let seen = |at: DVec2| {
        let to_light = position - at.extend(0.0);
        let distance = to_light.length();
        (
            position.z / distance.powi(3),
            -to_light.dot(axis) / distance,
        )
    };
    let reflected = |irradiance: f64| Some(tint * (irradiance / std::f64::consts::PI));
    assert_shows("point", &lit(light("point"), position, turn), 0.0, |at| {
        reflected(intensity * seen(at).0)
    });
    let (inner, outer) = (0.2_f64, 1.1_f64);
    let mut spot = light("spot");
    spot["spot"] = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
    // Near the cone's edge the part is a small difference of cosines in f32.
    assert_shows("spot", &lit(spot, position, turn), 1e-4, |at| {
        let (falloff, cosine) = seen(at);
        let part = (cosine - outer.cos()) / (inner.cos() - outer.cos());
        reflected(intensity * falloff * part.clamp(0.0, 1.0).powi(2))
    });
    assert_shows(
        "directional",
        &lit(light("directional"), position, turn),
        0.0,
        |_| reflected(intensity * turn.cos()),
    );
}

/// The square with a normal map of a single texel.
fn with_normal(texel: [u8; 4]) -> Gltf {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = RgbaImage::from_pixel(1, 1, image::Rgba(texel));
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    let mut file = square();
    let view = file.add_view(&bytes.into_inner());
    file.with(|json| {
        json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
        json["textures"] = json!([{ "source": 0 }]);
        json["materials"][0]["normalTexture"] = json!({ "index": 0 });
    })
}

/// A normal map of one direction must change the cosine of a directional light accordingly.
#[test]
fn normal_maps_turn_the_normal() {
    let texel = [204, 128, 230, 255];
    let file = with_normal(texel).with(|json| {
        json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        json["extensions"] =
            json!({ "KHR_lights_punctual": { "lights": [{ "type": "directional" }] } });
        push(
            &mut json["nodes"],
            json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
        );
        json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    });
    let [x, y, z] = [0, 1, 2].map(|i| f64::from(texel[i]) / 255.0 * 2.0 - 1.0);
    // u points along x and v along −y, so the bitangent along y; the light shines along −z.
    let cosine = DVec3::new(x, y, z).normalize().z;
    assert_shows("normal map", &load(&file), 1e-4, |_| {
        Some(DVec3::splat(cosine / std::f64::consts::PI))
    });
}

/// A mirror in a room of uniform brightness must show that brightness everywhere, however far its normal map tilts the
/// normal.
#[test]
fn mirrors_with_normal_maps_have_no_black_pixels() {
    for texel in [
        [218, 128, 217, 255],
        [250, 100, 170, 255],
        [128, 3, 150, 255],
        [20, 60, 140, 255],
    ] {
        let file = with_normal(texel).with(|json| {
            json["materials"][0]["pbrMetallicRoughness"] =
                json!({ "metallicFactor": 1, "roughnessFactor": 0 });
        });
        let scene = surrounded(load(&file), 1.0);
        assert_shows("tilted mirror", &scene, 1e-3, |_| Some(DVec3::ONE));
    }
}

/// A rough lobe whose mirror direction barely leaves the surface loses only the light that falls below the surface.
#[test]
fn rough_metal_under_a_normal_map_of_85_degrees_keeps_most_of_its_light() {
    for (roughness, kept) in [(0.2, 0.57), (0.5, 0.54)] {
        let file = with_normal([254, 128, 139, 255]).with(|json| {
            json["materials"][0]["pbrMetallicRoughness"] =
                json!({ "metallicFactor": 1, "roughnessFactor": roughness });
        });
        let scene = surrounded(load(&file), 1.0);
        assert_shows("tilted metal", &scene, 0.03, |_| Some(DVec3::splat(kept)));
    }
}

/// A PNG texture with 16 bits per channel is shown with all of them: 0x8040 and 0x80C0 have the same high byte.
#[test]
fn textures_of_sixteen_bits_are_shown_whole() {
    let shades = [0x8040_u16, 0x80C0];
    let picture: image::ImageBuffer<image::Luma<u16>, _> =
        image::ImageBuffer::from_fn(2, 1, |x, _| image::Luma([shades[x as usize]]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
    let sampler = json!({ "magFilter": 9728 });
    let file = pictured(
        "image/png",
        &bytes.into_inner(),
        sampler,
        json!({ "index": 0 }),
    );
    let file = file.with(|json| {
        json["extensionsUsed"] = json!(["KHR_materials_unlit"]);
        json["materials"][0]["extensions"] = json!({ "KHR_materials_unlit": {} });
    });
    let linear = shades.map(|shade| ((f64::from(shade) / 65535.0 + 0.055) / 1.055).powf(2.4));
    assert!((linear[0] - 0.214_95).abs() < 5e-6);
    assert_shows("sixteen bits", &load(&file), 0.0, |at| {
        Some(DVec3::splat(linear[usize::from(at.x > 0.0)]))
    });
}

#[test]
fn a_wrong_closed_form_is_noticed() {
    let scene = surrounded(load(&tiled(json!({ "index": 0 }))), 1.0);
    let upside_down = std::panic::catch_unwind(|| {
        assert_shows("upside down", &scene, 0.0, |at| {
            shown(uv(DVec2::new(at.x, -at.y)))
        });
    });
    let too_bright = std::panic::catch_unwind(|| {
        assert_shows("too bright", &scene, 0.0, |at| {
            shown(uv(at)).map(|color| color * 1.02)
        });
    });
    assert!(upside_down.is_err() && too_bright.is_err());
}
