//! The numerical extremes: scenes from atoms to solar systems, lamps from dim to blinding, things on a
//! landscape of two triangles, creases under a pixel's very centre. Scaling by a power of two rounds
//! nothing, so the picture must not change by a bit.

mod support;

use glam::{DAffine3, DVec3, Vec3};
use headwater::layouts::PixelSums;
use headwater::render::presets::Preset;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::validate::{BRIGHTEST, LARGEST_COORDINATE};
use headwater::scene::{Camera, Material, Scene, procedural};
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

/// The brightness of each pixel of a picture in direct light, through the pixels' centres.
fn direct_light(scene: &Scene, camera: &Camera, settings: &Settings) -> Vec<f64> {
    let (device, selection) = support::open_device(None);
    let view = View {
        camera: camera.clone(),
        width: SIDE,
        height: SIDE,
        seed: 5,
        bounces: 1,
        jitter: false,
    };
    let picture = support::render(&device, scene, selection.variant, &view, settings, 32);
    support::assert_no_messages(&device);
    picture.mean.iter().map(|p| p.iter().sum()).collect()
}

/// Width and height of these pictures.
const SIDE: u32 = 96;

/// Where a ray meets two surfaces at once, rounding may put the shading point behind the other one,
/// from where it sees nothing.
#[test]
fn no_crease_is_dark() {
    // The centres of some pixels lie on the room's creases to the last bit. Resampling, which rebuilds
    // its shading points from depths, is the technique that had them in the walls.
    let scene = procedural::generate("cornell", &[]).unwrap();
    let [_, resampling] = techniques();
    let side = SIDE as usize;
    let lit = direct_light(&scene, &scene.cameras[0], &resampling);
    for y in 1..side - 1 {
        for x in 1..side - 1 {
            let i = side * y + x;
            let around = [i - 1, i + 1, i - side, i + side].map(|i| lit[i]);
            let least = around.into_iter().fold(f64::INFINITY, f64::min);
            assert!(lit[i] >= 0.1 * least, "({x}, {y}): {} in {least}", lit[i]);
        }
    }
}

/// A box under a lamp on ground of two triangles that reach this far.
fn box_on_ground(reach: f32) -> Scene {
    let white = Material {
        base_color: Vec3::splat(0.7),
        ..Material::default()
    };
    let lamp = Material {
        emission: Vec3::splat(20.0),
        ..white.clone()
    };
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    // The box stands away from the ground's middle, where their common edge would be.
    let middle = Vec3::new(0.0, 0.0, -0.15 * reach);
    let ground = support::quad(middle - reach * (x - z), 2.0 * reach * x, -2.0 * reach * z);
    let corner = Vec3::new(-0.5, 0.0, -0.5);
    let walls = [
        support::quad(corner, y, x),
        support::quad(corner, z, y),
        support::quad(corner + x, y, z),
        support::quad(corner + z, x, y),
        support::quad(corner + y, z, x),
    ];
    let above = support::quad(Vec3::new(1.5, 3.0, -1.0), x, 2.0 * z);
    support::scene_of(&[
        (white.clone(), ground),
        (white, walls.concat()),
        (lamp, above),
    ])
}

/// Rounding moves what barycentrics say of a triangle of a thousand kilometres by some centimetres.
#[test]
fn a_landscape_of_two_triangles_is_lit_like_a_floor() {
    let eye = DVec3::new(2.0, 3.0, 5.0);
    let camera = support::look_at(eye, DVec3::new(0.0, 0.3, 0.0), DVec3::Y, 0.8);
    for settings in techniques() {
        let lit = |reach| direct_light(&box_on_ground(reach), &camera, &settings);
        let (floor, landscape) = (lit(16.0), lit(1_048_576.0));
        let seen = floor.iter().filter(|&&value| value > 0.0).count();
        assert!(seen > floor.len() / 2, "{seen} pixels are lit");
        let dark = floor.iter().zip(&landscape);
        let dark = dark.filter(|(near, far)| **far < 0.2 * **near).count();
        // Distances to the ground are known no better, so a ray beside the box may meet it first
        // where it is inside.
        assert!(dark <= seen / 200, "{dark} of {seen} pixels are dark");
    }
}
