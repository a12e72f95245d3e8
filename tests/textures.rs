//! Textured pictures.

mod support;

use glam::{Affine2, Vec2, Vec3, Vec4};
use headwater::render::presets::Preset;
use headwater::render::settings::Variant;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::texture::Wrap;
use headwater::scene::{Image, Scene, Texture, procedural};
use headwater::tracing::{GpuScene, Tracer};
use std::sync::Arc;

/// The bits of the last of three frames, or of path tracing.
fn bits(scene: &Scene, settings: &Settings, tracer: Tracer) -> Vec<[u32; 3]> {
    let view = View {
        camera: scene.cameras[0].clone(),
        width: 64,
        height: 48,
        seed: 3,
        bounces: 4,
        jitter: false,
    };
    let variant = support::variants(tracer)[0];
    let (device, _) = support::open_device(Some(variant));
    let origin = view.camera.camera_to_world.translation;
    let uploaded = Arc::new(GpuScene::new(&device, scene, origin, variant).unwrap());
    let mut renderer = Renderer::new(&device, uploaded, &view, settings).unwrap();
    for frame in 0..3 {
        renderer.single_frame(frame).unwrap();
    }
    support::assert_no_messages(&device);
    assert_eq!(renderer.rejected().unwrap(), 0, "values were rejected");
    let radiance = renderer.frame_radiance().unwrap();
    radiance.iter().map(|p| p.map(f32::to_bits)).collect()
}

fn image(texels: &[[u8; 4]]) -> Image {
    Image {
        name: "test".into(),
        width: texels.len() as u32,
        height: 1,
        texels: texels.into(),
    }
}

/// A scene whose materials have factors of 0 and 1 alone, which no rounding changes; the same scene in which textures
/// make these of white, fully rough metals.
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
    let count = colors.len() as f32;
    textured.images = vec![image(&colors), image(&surfaces)];
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
    }
    for mesh in &mut textured.meshes {
        // Some way from the centre of the texel, but within it.
        let near = (0..mesh.positions.len()).map(|i| Vec2::splat((i % 5) as f32 * 0.08 / count));
        mesh.uvs = [near.clone().collect(), near.collect()];
    }
    [plain, textured]
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
fn the_full_variant_renders_textures_to_the_same_bits() {
    let [_, textured] = plain_and_textured("cornell-glossy");
    let mut settings = Preset::named("accurate").unwrap().settings().unwrap();
    let specialised = bits(&textured, &settings, Tracer::ComputeBvh);
    settings.variant = Variant::Full;
    assert!(specialised == bits(&textured, &settings, Tracer::ComputeBvh));
}

/// Vertex colours of 0 and 1 in the place of the materials' own.
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
