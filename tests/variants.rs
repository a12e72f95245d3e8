//! Shaders with the code that a scene requires render what shaders with all code render.

mod support;

use headwater::render::presets::Preset;
use headwater::render::settings::Variant;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::requirements::Requirements;
use headwater::scene::{Scene, procedural};
use headwater::tracing::GpuScene;
use std::sync::Arc;

/// The bits of the last of three frames, or of path tracing.
fn bits(scene: &Scene, settings: &Settings) -> Vec<[u32; 3]> {
    let (device, selection) = support::open_device(None);
    let view = View {
        camera: scene.cameras[0].clone(),
        width: 64,
        height: 48,
        seed: 7,
        bounces: 4,
        jitter: false,
    };
    let origin = view.camera.camera_to_world.translation;
    let uploaded = Arc::new(GpuScene::new(&device, scene, origin, selection.variant).unwrap());
    let mut renderer = Renderer::new(&device, uploaded, &view, settings).unwrap();
    for frame in 0..3 {
        renderer.single_frame(frame).unwrap();
    }
    support::assert_no_messages(&device);
    let radiance = renderer.frame_radiance().unwrap();
    radiance.iter().map(|p| p.map(f32::to_bits)).collect()
}

/// A scene that lacks what can be left out, and one that has it all; on the software drivers the pictures are the
/// same to the bit.
#[test]
fn a_specialised_shader_renders_what_the_full_one_does() {
    let plain = procedural::generate("cornell", &[]).unwrap();
    let mut rich = procedural::generate("cornell-glossy", &[]).unwrap();
    for material in rich.materials.iter_mut().filter(|m| m.is_emissive()) {
        material.double_sided = true;
    }
    for (scene, has) in [(plain, false), (rich, true)] {
        let required = Requirements::of(&scene);
        assert_eq!(required.specular, has);
        assert_eq!(required.smooth_normals, has);
        assert_eq!(required.double_sided_emitters, has);
        for preset in ["accurate", "s1", "path-tracing"] {
            let mut settings = Preset::named(preset).unwrap().settings().unwrap();
            let specialised = bits(&scene, &settings);
            settings.variant = Variant::Full;
            assert!(
                specialised == bits(&scene, &settings),
                "{} {preset}",
                scene.name
            );
            assert!(specialised.iter().any(|p| *p != [0; 3]));
        }
    }
}
