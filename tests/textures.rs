//! Tests of pictures with textures.

mod support;

use glam::{Affine2, DVec3, Vec2, Vec3, Vec4};
use headwater::device_scene::SceneSizes;
use headwater::device_scene::selection::{Request, select};
use headwater::gpu::{DeviceInfo, DriverKind};
use headwater::procedural;
use headwater::render::presets::Preset;
use headwater::render::settings;
use headwater::render::{Settings, View};
use headwater::scene::lights;
use headwater::scene::texture::Wrap;
use headwater::scene::{Environment, Image, Material, Scene, Texture};
use headwater::shader_interface::{Textures, Tracer, Variant};

/// The bits of a frame's radiance (RGB), row by row, by a tracer that the tests' device has.
fn bits(scene: &Scene, settings: &Settings, tracer: Tracer) -> Vec<[u32; 3]> {
    support::frame_bits(scene, settings, Some(support::variants(tracer)[0]))
}

fn image(texels: &[[u8; 4]]) -> Image {
    Image {
        name: "test".into(),
        width: texels.len() as u32,
        height: 1,
        texels: texels.into(),
    }
}

/// Two scenes that must look the same. In the first, materials have factors of 0 and 1 only, which no rounding changes; in
/// the second, textures give white, fully rough metals these values, and white strength to their specular reflection.
fn plain_and_textured(name: &str) -> [Scene; 2] {
    let mut plain = procedural::generate(name, &[]).unwrap();
    for (index, material) in plain.materials.iter_mut().enumerate() {
        material.base_color = [
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::ONE,
            Vec3::new(0.0, 1.0, 1.0),
        ][index % 3];
        material.metallic = [0.0, 1.0][index % 2];
        material.roughness = 1.0;
        material.specular = [1.0, 1.0, 0.0][index % 3];
        material.specular_color = [Vec3::X, Vec3::ONE][index / 2 % 2];
    }
    let mut textured = plain.clone();
    // One texel for each material, which its coordinates select.
    let bytes = |color: Vec3| color.to_array().map(|c| (c * 255.0) as u8);
    let colors: Vec<[u8; 4]> = (plain.materials.iter())
        .map(|m| {
            let [r, g, b] = bytes(m.base_color);
            [r, g, b, 7]
        })
        .collect();
    let surfaces: Vec<[u8; 4]> = (plain.materials.iter())
        .map(|m| [9, 255, bytes(Vec3::splat(m.metallic))[0], 7])
        .collect();
    let speculars: Vec<[u8; 4]> = (plain.materials.iter())
        .map(|m| {
            let [r, g, b] = bytes(m.specular_color);
            [r, g, b, bytes(Vec3::splat(m.specular))[0]]
        })
        .collect();
    let count = colors.len() as f32;
    textured.images = vec![image(&colors), image(&surfaces), image(&speculars)];
    for (index, material) in textured.materials.iter_mut().enumerate() {
        let texture = |image, set| Texture {
            set,
            transform: Affine2::from_translation(Vec2::new((index as f32 + 0.5) / count, 0.5)),
            wrap: [Wrap::Clamp; 2],
            nearest: true,
            ..Texture::plain(image)
        };
        material.base_color = Vec3::ONE;
        material.metallic = 1.0;
        material.base_color_texture = Some(texture(0, 0));
        material.metallic_roughness_texture = Some(texture(1, 1));
        (material.specular, material.specular_color) = (1.0, Vec3::ONE);
        material.specular_texture = Some(texture(2, 1));
        material.specular_color_texture = Some(texture(2, 0));
    }
    for mesh in &mut textured.meshes {
        // Some way from the centre of the texel, but within it.
        let near = (0..mesh.positions.len()).map(|i| Vec2::splat((i % 5) as f32 * 0.08 / count));
        mesh.uvs = [near.clone().collect(), near.collect()];
    }
    [plain, textured]
}

/// A scene with base colours, normal maps, emissive textures and alpha from images, and a sky.
fn conservatory() -> Scene {
    let mut scene = procedural::generate("conservatory", &[]).unwrap();
    scene.environment = Some(Environment::open("sky:sun=40,width=64", &mut Vec::new()).unwrap());
    scene
}

/// The selected access to textures, and the reason for it, on a device with descriptor indexing and buffer addresses whose
/// properties `change` has edited; `None` and the error if the selection fails.
fn chosen(
    scene: &Scene,
    wanted: Option<Textures>,
    change: impl FnOnce(&mut DeviceInfo),
) -> (Option<Textures>, String) {
    let (_, mut info) = support::tests_device();
    (info.image_arrays, info.buffer_addresses) = (true, true);
    (info.max_sampled_images, info.max_image_side) = (1 << 16, 1 << 14);
    (info.kind, info.driver_kind) = ("discrete", DriverKind::Other);
    change(&mut info);
    let wanted = Request {
        textures: wanted,
        ..Request::default()
    };
    match select(&info, wanted, &SceneSizes::of(scene)) {
        Ok(selection) => {
            assert_eq!(
                selection.features().image_arrays,
                selection.variant.textures == Textures::Images
            );
            (Some(selection.variant.textures), selection.textures_reason)
        }
        Err(error) => {
            assert_eq!(error.exit_status(), 2);
            (None, error.to_string())
        }
    }
}

#[test]
fn a_rule_chooses_how_textures_are_read() {
    use None;
    use Textures::{Buffer, Images};
    let scene = conservatory();
    let plain = procedural::generate("cornell", &[]).unwrap();
    let gpu = |_: &mut DeviceInfo| ();
    assert_eq!(chosen(&scene, None, gpu).0, Some(Images));
    // Without textures no feature is asked for.
    assert_eq!(chosen(&plain, None, gpu).0, Some(Buffer));
    assert_eq!(chosen(&scene, Some(Textures::Buffer), gpu).0, Some(Buffer));
    let cpu = |info: &mut DeviceInfo| info.kind = "cpu";
    assert_eq!(chosen(&scene, None, cpu).0, Some(Buffer));
    assert_eq!(chosen(&scene, Some(Textures::Images), cpu).0, Some(Images));
    // What no buffer holds, images may.
    let texels = SceneSizes::of(&scene).bytes.texels;
    let small = |info: &mut DeviceInfo| (info.kind, info.max_buffer_size) = ("cpu", texels - 1);
    assert_eq!(chosen(&scene, None, small).0, Some(Images));
    type Lack = fn(&mut DeviceInfo);
    let lacks: [(Lack, &str); 5] = [
        (|info| info.image_arrays = false, "descriptor indexing"),
        (|info| info.buffer_addresses = false, "buffer addresses"),
        (|info| info.max_sampled_images = 65, "at most 1 of"),
        (|info| info.max_image_side = 7, "allows 7"),
        (|info| info.max_buffer_size = 99, "allows 99"),
    ];
    for (lack, why) in lacks {
        let (textures, reason) = chosen(&scene, None, lack);
        assert_eq!(textures, Some(Buffer), "{reason}");
        assert!(reason.contains(why), "{reason}");
        let (none, refusal) = chosen(&scene, Some(Textures::Images), lack);
        assert_eq!(none, None);
        assert!(refusal.contains(why) && refusal.contains("--textures buffer"));
        assert!(!refusal.contains('\n'), "{refusal}");
    }
}

#[test]
fn images_beyond_the_limits_of_the_device_are_refused_by_upload_too() {
    let (mut device_info, scene) = (support::tests_device().1, conservatory());
    let Some(variant) = (support::variants(Tracer::ComputeBvh).into_iter())
        .find(|variant| variant.textures == Textures::Images)
    else {
        return;
    };
    device_info.max_image_side = 7;
    let error = SceneSizes::of(&scene).check(&device_info, variant);
    let text = error.unwrap_err().to_string();
    assert!(text.contains("allows 7"), "{text}");
}

/// Vertex colours of 0 and 1 instead of the materials' base colours must give the same picture.
#[test]
fn vertices_of_one_colour_are_that_colour() {
    let [plain, _] = plain_and_textured("cornell");
    let mut colored = plain.clone();
    for mesh in &mut colored.meshes {
        mesh.colors = vec![Vec4::ONE; mesh.positions.len()];
        for part in &mesh.parts {
            let first = part.first_triangle as usize;
            for &vertex in mesh.triangles[first..][..part.triangle_count as usize].as_flattened() {
                let color = plain.materials[part.material as usize].base_color;
                mesh.colors[vertex as usize] = color.extend(1.0);
            }
        }
    }
    for material in &mut colored.materials {
        material.base_color = Vec3::ONE;
    }
    for (preset, tracer) in [
        ("accurate", Tracer::ComputeBvh),
        ("path-tracing", Tracer::RayQuery),
    ] {
        if support::variants(tracer).is_empty() {
            continue;
        }
        let settings = Preset::named(preset).unwrap().settings().unwrap();
        let expected = bits(&plain, &settings, tracer);
        let found = bits(&colored, &settings, tracer);
        let differ = expected.iter().zip(&found).filter(|(a, b)| a != b);
        assert_eq!(differ.count(), 0, "{preset} {tracer:?}");
    }
}

/// A floor below an emitter with a dark half: by a texture, or by another material.
fn half_an_emitter(textured: bool) -> Scene {
    let floor = support::quad(Vec3::new(-2.0, 0.0, 2.0), Vec3::X * 4.0, Vec3::NEG_Z * 4.0);
    let grey = Material::lambert("floor", Vec3::splat(0.5));
    let dark = Material::lambert("lamp", Vec3::splat(0.2));
    let emitter = Material {
        emission: Vec3::new(3.0, 4.0, 5.0),
        ..dark.clone()
    };
    let (corner, depth) = (Vec3::new(-0.5, 1.0, -0.5), Vec3::Z);
    let half = |x: f32| support::quad(corner + Vec3::X * x, Vec3::X * 0.5, depth);
    if !textured {
        return support::scene_of(&[(grey, floor), (emitter, half(0.0)), (dark, half(0.5))]);
    }
    let whole = support::quad(corner, Vec3::X, depth);
    let mut scene = support::scene_of(&[(grey, floor), (emitter, whole)]);
    scene.images = vec![image(&[[255; 4], [0, 0, 0, 255]])];
    scene.materials[1].emissive_texture = Some(Texture {
        nearest: true,
        set: 1,
        ..Texture::plain(0)
    });
    let laid = |p: &Vec3| Vec2::new(p.x + 0.5, p.z + 0.5);
    scene.meshes[1].uvs[1] = scene.meshes[1].positions.iter().map(laid).collect();
    scene
}

/// The only bright texels of the emitter lie between the points at which its brightness is estimated. Its power must not be
/// 0, or no light sample would find it.
#[test]
fn an_emitter_that_is_lit_between_the_points_of_its_estimate_has_power() {
    let mut scene = half_an_emitter(true);
    let texel = |x: usize| if x == 24 { [255; 4] } else { [0, 0, 0, 255] };
    scene.images = vec![image(&std::array::from_fn::<_, 64, _>(texel))];
    scene.validate().unwrap();
    let lights = lights::light_triangles(&scene);
    assert_eq!(lights.len(), 2);
    for light in lights {
        assert!(lights::power(&light, &scene.materials[light.material as usize]) > 0.0);
    }
}

mod thorough {
    use super::*;

    #[test]
    fn images_and_a_buffer_render_to_the_same_bits() {
        let scene = conservatory();
        for (preset, tracer) in [
            ("path-tracing", Tracer::ComputeBvh),
            ("accurate", Tracer::ComputeBvh),
            ("path-tracing", Tracer::RayQuery),
        ] {
            let settings = Preset::named(preset).unwrap().settings().unwrap();
            let mut variants = support::variants(tracer).into_iter();
            let Some(images) = variants.find(|variant| variant.textures == Textures::Images) else {
                continue;
            };
            let buffer = Variant {
                textures: Textures::Buffer,
                ..images
            };
            let [expected, found] = [buffer, images]
                .map(|variant| support::frame_bits(&scene, &settings, Some(variant)));
            assert!(expected.iter().any(|pixel| *pixel != [0; 3]));
            assert!(expected == found, "{preset} {images:?}");
        }
    }

    #[test]
    fn textures_of_one_colour_are_that_colour() {
        for (name, preset, tracer) in [
            ("cornell", "accurate", Tracer::ComputeBvh),
            ("cornell", "s1", Tracer::ComputeBvh),
            ("cornell", "path-tracing", Tracer::RayQuery),
            ("motion", "accurate", Tracer::ComputeBvh),
        ] {
            if support::variants(tracer).is_empty() {
                continue;
            }
            let [plain, textured] = plain_and_textured(name);
            let settings = Preset::named(preset).unwrap().settings().unwrap();
            let expected = bits(&plain, &settings, tracer);
            let found = bits(&textured, &settings, tracer);
            let differ = expected.iter().zip(&found).filter(|(a, b)| a != b);
            assert_eq!(differ.count(), 0, "{name} {preset} {tracer:?}");
        }
    }

    #[test]
    fn half_an_emitter_by_texture_lights_as_half_an_emitter() {
        let [plain, textured] = [false, true].map(half_an_emitter);
        let mut camera = support::look_at(
            DVec3::new(0.3, 0.2, 3.0),
            DVec3::new(0.0, 0.5, 0.0),
            DVec3::Y,
            1.2,
        );
        camera.aspect_ratio = Some(1.0);
        let view = View {
            camera,
            width: 32,
            height: 32,
            seed: 5,
            bounces: 3,
            jitter: true,
        };
        for (preset, samples, tracer) in [
            ("path-tracing", 4096, Tracer::ComputeBvh),
            ("accurate", 768, Tracer::ComputeBvh),
            ("path-tracing", 1024, Tracer::RayQuery),
        ] {
            let Some(&variant) = support::variants(tracer).first() else {
                continue;
            };
            let (device, _) = support::open_device(Some(variant));
            let settings = Preset::named(preset).unwrap().settings().unwrap();
            // Each row of the picture sees other parts of floor and emitter.
            let rows = |scene: &Scene, seed| -> Vec<[f64; 2]> {
                let view = View {
                    seed,
                    ..view.clone()
                };
                let found = support::render(&device, scene, variant, &view, &settings, samples);
                (found.mean.chunks(32).zip(found.error_squared.chunks(32)))
                    .map(|(mean, error)| {
                        let sum = |values: &[[f64; 3]]| values.iter().flatten().sum::<f64>();
                        [sum(mean), sum(error)]
                    })
                    .collect()
            };
            let expected = rows(&plain, 5);
            let found = rows(&textured, 6);
            let (mut whole, mut of_whole) = ([0.0; 2], 0.0);
            for (row, ([a, aa], [b, bb])) in expected.iter().zip(&found).enumerate() {
                // Samples of `accurate` depend on each other: its errors are larger than they seem.
                let sigma = (aa + bb).sqrt() * if preset == "accurate" { 4.0 } else { 1.0 };
                assert!(
                    (a - b).abs() < 5.0 * sigma + 1e-9,
                    "{preset} {tracer:?}, row {row}: {a} {b} ± {sigma}"
                );
                whole = [whole[0] + a, whole[1] + b];
                of_whole += sigma * sigma;
            }
            let off = whole[1] / whole[0] - 1.0;
            println!(
                "{preset} {tracer:?}: {:.3} ± {:.3} %",
                100.0 * off,
                100.0 * of_whole.sqrt() / whole[0]
            );
            assert!(off.abs() < 0.005, "{preset} {tracer:?}: {off}");
        }
    }
}

mod largest {
    use super::*;

    #[test]
    fn the_full_variant_renders_textures_to_the_same_bits() {
        let [_, textured] = plain_and_textured("cornell-glossy");
        let mut settings = Preset::named("accurate").unwrap().settings().unwrap();
        let specialised = bits(&textured, &settings, Tracer::ComputeBvh);
        settings.variant = settings::Variant::Full;
        assert!(specialised == bits(&textured, &settings, Tracer::ComputeBvh));
    }
}
