//! The numerical extremes: scenes from atoms to solar systems, lamps from dim to blinding. Scaling by
//! a power of two rounds nothing, so the picture must not change by a bit.

mod support;

use glam::{DAffine3, DVec3, Vec3};
use headwater::layouts::PixelSums;
use headwater::render::presets::Preset;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::validate::{BRIGHTEST, LARGEST_COORDINATE};
use headwater::scene::{Scene, procedural};
use headwater::tracing::GpuScene;
use std::sync::Arc;

/// Glossy spheres with smooth normals, one of them placed twice, so that not all is gathered.
fn scene() -> Scene {
    let mut scene = procedural::generate("cornell-glossy", &[]).unwrap();
    let smooth = |i: &headwater::scene::Instance| !scene.meshes[i.mesh as usize].normals.is_empty();
    let mut copy = scene.instances.iter().find(|i| smooth(i)).unwrap().clone();
    copy.object_to_world = DAffine3::from_translation(DVec3::new(0.0, 0.6, 0.0))
        * copy.object_to_world
        * DAffine3::from_scale(DVec3::new(0.5, 0.3, -0.5));
    scene.instances.push(copy);
    scene
}

/// What the extremes are tried on: path tracing, and resampling with all that it can do.
fn techniques() -> [Settings; 2] {
    let accurate = Preset::named("accurate").unwrap();
    [Settings::default(), accurate.settings().unwrap()]
}

/// The sums of a picture of the scene, by its first camera.
fn picture(scene: &Scene, settings: &Settings) -> Vec<PixelSums> {
    let (device, selection) = support::open_device(None);
    let view = View {
        camera: scene.cameras[0].clone(),
        width: 48,
        height: 48,
        seed: 5,
        bounces: 4,
        jitter: true,
    };
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, scene, origin, selection.variant).unwrap();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, settings).unwrap();
    renderer.add_samples(0, 8).unwrap();
    assert_eq!(renderer.rejected().unwrap(), 0);
    support::assert_no_messages(&device);
    renderer.sums().unwrap()
}

fn assert_same(name: &str, a: &[PixelSums], b: &[PixelSums]) {
    let differ = a.iter().zip(b).filter(|(a, b)| a.sum != b.sum).count();
    assert_eq!(differ, 0, "{name}: of {} pixels", a.len());
}

#[test]
fn size_changes_nothing() {
    let plain = scene();
    for settings in techniques() {
        let seen = picture(&plain, &settings);
        assert!(seen.iter().filter(|p| p.sum.x > 0.0).count() > seen.len() / 2);
        for power in [-40, -12, 12, 40] {
            // By the instances' transforms, and by the meshes' own coordinates.
            for in_meshes in [false, true] {
                let scaled = scaled(&plain, 2_f64.powi(power), in_meshes);
                assert_same(&format!("2^{power}"), &seen, &picture(&scaled, &settings));
            }
        }
    }
}

/// The scene at another scale.
fn scaled(scene: &Scene, scale: f64, in_meshes: bool) -> Scene {
    assert!(10.0 * scale < LARGEST_COORDINATE);
    let mut scaled = scene.clone();
    for instance in &mut scaled.instances {
        let place = &mut instance.object_to_world;
        place.translation *= scale;
        if !in_meshes {
            place.matrix3 *= scale;
        }
    }
    if in_meshes {
        let positions = scaled.meshes.iter_mut().flat_map(|m| &mut m.positions);
        positions.for_each(|p| *p *= scale as f32);
    }
    scaled.cameras[0].camera_to_world.translation *= scale;
    scaled.validate().unwrap();
    scaled
}

#[test]
fn brightness_scales_the_picture() {
    let plain = scene();
    let brightest = plain.materials.iter().map(|m| m.emission.max_element());
    let brightest = brightest.fold(0.0, f32::max);
    for settings in techniques() {
        let seen = picture(&plain, &settings);
        for power in [-60, 30] {
            let scale = 2_f32.powi(power);
            assert!(brightest * scale < BRIGHTEST);
            let mut scaled = plain.clone();
            scaled
                .materials
                .iter_mut()
                .for_each(|m| m.emission *= scale);
            scaled.validate().unwrap();
            let expected: Vec<PixelSums> = seen
                .iter()
                .map(|p| PixelSums {
                    sum: p.sum * scale,
                    ..*p
                })
                .collect();
            let picture = picture(&scaled, &settings);
            assert_same(&format!("2^{power}"), &expected, &picture);
        }
    }
}

#[test]
fn what_is_too_large_or_too_bright_is_refused() {
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene();
        change(&mut scene);
        scene.validate().unwrap_err().to_string()
    };
    let far = DVec3::X * LARGEST_COORDINATE * 1.01;
    assert!(refused(&|s| s.instances[0].object_to_world.translation = far).contains("1e15"));
    assert!(refused(&|s| s.cameras[0].camera_to_world.translation = far).contains("1e15"));
    assert!(refused(&|s| s.meshes[0].positions[0] = far.as_vec3()).contains("1e15"));
    for emission in [BRIGHTEST * 1.01, f32::INFINITY, f32::NAN, -1.0] {
        assert!(refused(&|s| s.materials[0].emission = Vec3::splat(emission)).contains("1e12"));
    }
}
