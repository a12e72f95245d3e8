//! Tests of numerical extremes: scenes from the size of atoms to that of solar systems, dim and very bright lights, objects
//! on a landscape of two triangles, and edges exactly at the centre of a pixel. Scaling by a power of two rounds nothing, so
//! the picture must keep all bits.

mod support;

use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec3};
use headwater::procedural;
use headwater::render::outputs::Sums;
use headwater::render::presets::Preset;
use headwater::render::settings::{Candidates, GridMode, Integrator, ReuseMode, Secondary};
use headwater::render::{Settings, View};
use headwater::scene::validate::{BRIGHTEST, LARGEST_COORDINATE};
use headwater::scene::{Camera, Environment, Material, PunctualLight, PunctualShape, Scene};
use headwater::shader_interface::{Tracer, Variant};

/// The scene `cornell-glossy` with smooth spheres. One of their meshes has two instances, so that the device also has a mesh
/// that is not merged.
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

/// The scene `cornell-glossy` with an environment, a point light, a spot light and a directional light.
fn scene_of_all_lights() -> Scene {
    let mut scene = scene();
    let texel = |index: u32| Vec3::splat(if index == 37 { 60.0 } else { 0.3 });
    scene.environment = Some(Environment {
        name: "test".into(),
        width: 16,
        height: 8,
        texels: (0..128).map(texel).collect(),
        rotation: 20.0,
        intensity: 1.0,
    });
    let spot = PunctualShape::Spot {
        inner: 0.2,
        outer: 0.9,
    };
    let shapes = [PunctualShape::Point, spot, PunctualShape::Directional];
    let transform = DAffine3::from_translation(DVec3::new(0.1, 0.7, 0.9));
    scene.punctual_lights = (shapes.into_iter())
        .map(|shape| PunctualLight {
            name: "test".into(),
            light_to_world: transform,
            shape,
            intensity: Vec3::new(0.5, 0.25, 1.0),
            range: None,
        })
        .collect();
    scene
}

/// The settings that every extreme is tested with: path tracing, and resampling with the preset `accurate`.
fn techniques() -> [Settings; 2] {
    let accurate = Preset::named("accurate").unwrap();
    [Settings::default(), accurate.settings().unwrap()]
}

/// The settings that a scene is tested with: path tracing, and resampling with world reservoirs. With all kinds of light,
/// candidates come from the light BVH; otherwise candidates of direct light come from the hash grid, once in each of its
/// modes.
fn techniques_for(scene: &Scene) -> Vec<Settings> {
    let [path_tracing, mut accurate] = techniques();
    accurate.direct.resampling.candidates = Candidates::HashGrid;
    accurate.indirect.secondary = Secondary::WorldReservoirs;
    accurate.world_reservoirs.min_lights = 0;
    accurate.world_reservoirs.depth = 2;
    if !scene.punctual_lights.is_empty() {
        accurate.direct.resampling.candidates = Candidates::LightBvh;
        accurate.indirect.resampling.candidates = Candidates::LightBvh;
        return vec![path_tracing, accurate];
    }
    let mut published = accurate.clone();
    published.hash_grid.mode = GridMode::Published;
    vec![path_tracing, accurate, published]
}

/// The sums of a picture of the scene. `origin` is the world position that the device uses as its zero.
fn sums(
    scene: &Scene,
    variant: Option<Variant>,
    origin: DVec3,
    view: &View,
    settings: &Settings,
    samples: u32,
) -> Sums {
    let (device, selection) = support::open_device(variant);
    let variant = selection.variant;
    let sums = support::sums(&device, scene, origin, variant, view, settings, samples);
    support::assert_no_messages(&device);
    sums
}

/// Number of samples per pixel of a picture.
const SAMPLES: u32 = 8;

/// The mean and the standard error of each pixel of a picture, by the first camera of the scene.
fn picture(scene: &Scene, settings: &Settings) -> Vec<[DVec3; 2]> {
    let view = View {
        camera: scene.cameras[0].clone(),
        width: 48,
        height: 48,
        seed: 5,
        bounces: 4,
        jitter: true,
    };
    let origin = view.camera.camera_to_world.translation;
    let sums = sums(scene, None, origin, &view, settings, SAMPLES);
    let (mean, error) = (sums.mean(SAMPLES), sums.standard_error(SAMPLES));
    mean.into_iter().zip(error).map(|(m, e)| [m, e]).collect()
}

fn assert_same(name: &str, a: &[[DVec3; 2]], b: &[[DVec3; 2]]) {
    let differ = a.iter().zip(b).filter(|(a, b)| a != b).count();
    assert_eq!(differ, 0, "{name}: of {} pixels", a.len());
}

fn assert_size_changes_nothing(plain: &Scene, powers: &[i32]) {
    for settings in techniques_for(plain) {
        let seen = picture(plain, &settings);
        assert!(
            seen.iter()
                .filter(|[mean, error]| mean.x > 0.0 && error.x > 0.0)
                .count()
                > seen.len() / 2
        );
        for power in powers {
            // By the instances' transforms, and by the meshes' own coordinates.
            for in_meshes in [false, true] {
                let scaled = scaled(plain, 2_f64.powi(*power), in_meshes);
                assert_same(&format!("2^{power}"), &seen, &picture(&scaled, &settings));
            }
        }
    }
}

/// The scene with all lengths multiplied by `scale`: in the meshes, or else in the transforms of instances.
fn scaled(scene: &Scene, scale: f64, in_meshes: bool) -> Scene {
    assert!(10.0 * scale < LARGEST_COORDINATE);
    let mut scaled = scene.clone();
    for instance in &mut scaled.instances {
        let transform = &mut instance.object_to_world;
        transform.translation *= scale;
        if !in_meshes {
            transform.matrix3 *= scale;
        }
    }
    if in_meshes {
        let positions = scaled.meshes.iter_mut().flat_map(|m| &mut m.positions);
        positions.for_each(|p| *p *= scale as f32);
    }
    scaled.cameras[0].camera_to_world.translation *= scale;
    for light in &mut scaled.punctual_lights {
        light.light_to_world.translation *= scale;
        // The same irradiance at a distance that is `scale` times as large.
        if !light.is_distant() {
            light.intensity *= (scale * scale) as f32;
        }
    }
    scaled.validate().unwrap();
    scaled
}

/// The scene with the brightness of all lights multiplied by `scale`.
fn brighter(plain: &Scene, scale: f32) -> Scene {
    let mut scaled = plain.clone();
    scaled
        .materials
        .iter_mut()
        .for_each(|m| m.emission *= scale);
    let punctual = scaled.punctual_lights.iter_mut();
    punctual.for_each(|light| light.intensity *= scale);
    if let Some(environment) = &mut scaled.environment {
        environment.intensity *= scale;
    }
    scaled.validate().unwrap();
    scaled
}

fn assert_brightness_scales_the_picture(plain: &Scene, powers: &[i32]) {
    let brightest = plain.materials.iter().map(|m| m.emission.max_element());
    let brightest = brightest.fold(0.0, f32::max);
    for settings in techniques_for(plain) {
        let seen = picture(plain, &settings);
        for power in powers {
            let scale = 2_f32.powi(*power);
            assert!(brightest * scale < BRIGHTEST);
            let scaled = brighter(plain, scale);
            let expected: Vec<[DVec3; 2]> = (seen.iter())
                .map(|values| values.map(|v| v * f64::from(scale)))
                .collect();
            let picture = picture(&scaled, &settings);
            assert_same(&format!("2^{power}"), &expected, &picture);
        }
    }
}

/// Far and dim, or near and bright: products of light and area leave the range of f32 long before one of the two does, so
/// both are scaled together.
#[test]
fn size_and_brightness_together_only_scale_the_picture() {
    let plain = scene();
    for settings in techniques_for(&plain) {
        let seen = picture(&plain, &settings);
        for (size, brightness) in [(40, -60), (40, -90), (-40, 30)] {
            let scale = 2_f32.powi(brightness);
            let scaled = brighter(&scaled(&plain, 2_f64.powi(size), false), scale);
            let expected: Vec<[DVec3; 2]> = (seen.iter())
                .map(|values| values.map(|v| v * f64::from(scale)))
                .collect();
            let name = format!("size 2^{size}, brightness 2^{brightness}");
            assert_same(&name, &expected, &picture(&scaled, &settings));
        }
    }
}

/// A floor that reflects only red is lit by an emitter with almost no red. The colour that a reservoir stores must keep this
/// dim channel, the only one that counts on the floor.
#[test]
fn the_dim_channel_of_an_emitter_is_kept() {
    let mut scene = procedural::generate("cornell", &[]).unwrap();
    let floor = scene.meshes[scene.instances[0].mesh as usize].parts[0].material;
    // Without the two blocks.
    scene.instances.truncate(scene.instances.len() - 2);
    for (number, material) in scene.materials.iter_mut().enumerate() {
        material.base_color = match number == floor as usize {
            true => Vec3::X,
            false => Vec3::splat(0.9),
        };
        material.emission *= Vec3::new(0.001, 1.0, 0.0);
    }
    let view = View {
        camera: scene.cameras[0].clone(),
        width: 32,
        height: 32,
        seed: 7,
        bounces: 5,
        jitter: false,
    };
    let (device, selection) = support::open_device(None);
    let floor_red = |settings: &Settings, samples| {
        let variant = selection.variant;
        let seen = support::render(&device, &scene, variant, &view, settings, samples);
        // Pixels of the floor alone: of the walls' light hardly any is red, so that theirs is noise.
        let on_floor = |n: &usize| n / 32 >= 27 && (8..24).contains(&(n % 32));
        let sum_of =
            |of: &[[f64; 3]]| -> f64 { (0..of.len()).filter(on_floor).map(|n| of[n][0]).sum() };
        (sum_of(&seen.mean), sum_of(&seen.error_squared))
    };
    let [path_tracing, mut alone] = techniques();
    alone.direct.resampling.reuse = ReuseMode::None;
    alone.indirect.resampling.reuse = ReuseMode::None;
    let (truth, variance) = floor_red(&path_tracing, 1024);
    let (seen, control_variance) = floor_red(&alone, 256);
    support::assert_no_messages(&device);
    let sigma = (variance + control_variance).sqrt() / truth;
    let off = seen / truth - 1.0;
    assert!(sigma < 0.01 && off.abs() < 4.0 * sigma, "{off} ± {sigma}");
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

/// Width and height in pixels of the pictures of direct light.
const SIDE: usize = 96;

/// The brightness of each pixel in direct light, through the pixels' centres, with so many samples that neighbouring pixels
/// are nearly equal. It uses the compute BVH, through which no ray slips between triangles; a gap would look like a dark
/// pixel.
fn direct_light(scene: &Scene, camera: &Camera, settings: &Settings) -> Vec<f64> {
    let variants = support::variants(Tracer::ComputeBvh);
    let view = View {
        camera: camera.clone(),
        width: SIDE as u32,
        height: SIDE as u32,
        seed: 5,
        bounces: 1,
        jitter: false,
    };
    let samples = match settings.integrator {
        Integrator::PathTracing => 512,
        Integrator::Restir => 96,
    };
    // The camera is not where the device has its origin, nor are the origins of most rays.
    let origin = camera.camera_to_world.translation + DVec3::new(2.0, -1.0, 1.5);
    let variant = variants.first().copied();
    let sums = sums(scene, variant, origin, &view, settings, samples);
    sums.mean(samples).iter().map(|p| p.element_sum()).collect()
}

/// Pixels that are darker than `least` times the darkest of their eight neighbours, or brighter than `most` times the
/// brightest: (x, y, ratio to the neighbours).
fn odd_ones(lit: &[f64], least: f64, most: f64) -> Vec<(usize, usize, f64)> {
    let mut odd = Vec::new();
    for y in 1..SIDE - 1 {
        for x in 1..SIDE - 1 {
            let i = SIDE * y + x;
            let around = [SIDE + 1, SIDE, SIDE - 1, 1].map(|step| [lit[i - step], lit[i + step]]);
            let around = around.as_flattened();
            let darkest = around.iter().copied().fold(f64::INFINITY, f64::min);
            let brightest = around.iter().copied().fold(0.0, f64::max);
            if lit[i] < least * darkest || lit[i] > most * brightest {
                odd.push((x, y, lit[i] / (darkest * brightest).sqrt()));
            }
        }
    }
    odd
}

/// The scene and its first camera, rotated by an angle that is no multiple of 90 degrees.
fn turned(mut scene: Scene) -> Scene {
    let turn = DAffine3::from_quat(DQuat::from_euler(EulerRot::XYZ, 0.4, 1.1, -0.7));
    for instance in &mut scene.instances {
        instance.object_to_world = turn * instance.object_to_world;
    }
    let camera = &mut scene.cameras[0].camera_to_world;
    *camera = turn * *camera;
    scene
}

fn white() -> Material {
    Material {
        base_color: Vec3::splat(0.7),
        ..Material::default()
    }
}

fn emitter() -> Material {
    Material {
        emission: Vec3::splat(20.0),
        ..white()
    }
}

/// A box and an emitter above it on a ground of two triangles. The ground reaches `reach` metres from its middle, and rises
/// by `slope` metres per metre.
fn box_on_ground(reach: f32, slope: f32) -> Scene {
    let (x, y, z) = (Vec3::X + slope * Vec3::Y, Vec3::Y, Vec3::Z);
    // The box stands away from the ground's middle, where their common edge would be.
    let middle = Vec3::new(0.0, 0.0, -0.15 * reach);
    let ground = support::quad(middle - reach * (x - z), 2.0 * reach * x, -2.0 * reach * z);
    // Its foot is in the ground.
    let corner = Vec3::new(-0.5, -0.5, -0.5);
    let (x, tall) = (Vec3::X, 1.5 * y);
    let walls = [
        support::quad(corner, tall, x),
        support::quad(corner, z, tall),
        support::quad(corner + x, tall, z),
        support::quad(corner + z, x, tall),
        support::quad(corner + tall, z, x),
    ];
    let above = support::quad(Vec3::new(1.5, 3.0, -1.0), x, 2.0 * z);
    support::scene_of(&[
        (white(), ground),
        (white(), walls.concat()),
        (emitter(), above),
    ])
}

/// A smooth plastic plate above a glowing floor of two kilometres, and a camera. The plate's lobe covers less of the floor
/// than one of the cells to which reservoirs round a point on a light.
fn plate_over_lava() -> (Scene, Camera) {
    let plastic = Material {
        base_color: Vec3::splat(0.1),
        roughness: 0.011,
        metallic: 0.0,
        ..Material::default()
    };
    let (x, z) = (Vec3::X, Vec3::Z);
    let reach = 1000.0;
    let floor = support::quad(reach * (z - x), 2.0 * reach * x, -2.0 * reach * z);
    // Its front looks down.
    let plate = support::quad(Vec3::new(-2.0, 0.2, -2.0), 4.0 * x, 4.0 * z);
    let scene = support::scene_of(&[(emitter(), floor), (plastic, plate)]);
    let eye = DVec3::new(0.03, 0.1, 0.15);
    let camera = support::look_at(eye, DVec3::new(0.01, 0.2, 0.02), DVec3::Y, 0.5);
    (scene, camera)
}

/// Number of independent runs of the statistical test; `HALF_WIDTH` is half the width of the 99 % interval of their mean, in
/// standard errors (Student's t).
const RUNS: u32 = 24;
const HALF_WIDTH: f64 = 2.807;

mod thorough {
    use super::*;

    /// A scale that is no power of two must change bits; otherwise the comparison of bits could not fail.
    #[test]
    fn other_scales_change_bits() {
        let plain = scene();
        for settings in techniques() {
            let seen = picture(&plain, &settings);
            for in_meshes in [false, true] {
                assert!(seen != picture(&scaled(&plain, 3.0, in_meshes), &settings));
            }
            let times_three = seen.iter().map(|values| values.map(|v| v * 3.0));
            let times_three: Vec<[DVec3; 2]> = times_three.collect();
            assert!(times_three != picture(&brighter(&plain, 3.0), &settings));
        }
    }

    #[test]
    fn size_changes_nothing() {
        assert_size_changes_nothing(&scene(), &[-40, -12, 12, 46]);
    }

    #[test]
    fn size_changes_nothing_with_all_kinds_of_light() {
        assert_size_changes_nothing(&scene_of_all_lights(), &[-40, 40]);
    }

    /// A scene that is 10¹² units from the origin, where a step of f64 is 1/10,000 of a unit.
    #[test]
    fn a_scene_at_a_million_million_units_is_lit_as_at_home() {
        let plain = scene();
        let mut far = plain.clone();
        let way = DVec3::new(0.8e12, -0.4e12, 0.5e12);
        for instance in &mut far.instances {
            instance.object_to_world.translation += way;
        }
        for camera in &mut far.cameras {
            camera.camera_to_world.translation += way;
        }
        for settings in techniques_for(&plain) {
            let light = |scene| -> f64 {
                let seen = picture(scene, &settings);
                seen.iter().map(|[mean, _]| mean.element_sum()).sum()
            };
            let ratio = light(&far) / light(&plain);
            assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
        }
    }

    #[test]
    fn brightness_scales_the_picture() {
        assert_brightness_scales_the_picture(&scene(), &[-103, 35]);
    }

    #[test]
    fn brightness_of_all_kinds_of_light_scales_the_picture() {
        assert_brightness_scales_the_picture(&scene_of_all_lights(), &[-90, 33]);
    }

    #[test]
    fn lights_wider_than_the_lobes_that_reflect_them_keep_their_brightness() {
        let (scene, camera) = plate_over_lava();
        let (device, selection) = support::open_device(None);
        // The mean of a picture, and its squared standard error.
        let mean = |seed, settings: &Settings, samples| {
            let view = View {
                camera: camera.clone(),
                width: 32,
                height: 32,
                seed,
                bounces: 1,
                jitter: false,
            };
            let seen =
                support::render(&device, &scene, selection.variant, &view, settings, samples);
            let count = (3 * seen.mean.len()) as f64;
            let sum = |values: &[[f64; 3]]| values.iter().flatten().sum::<f64>();
            (
                sum(&seen.mean) / count,
                sum(&seen.error_squared) / (count * count),
            )
        };
        let [path_tracing, mut accurate] = techniques();
        let (truth, truth_variance) = mean(0, &path_tracing, 16384);
        for reuse in [ReuseMode::None, ReuseMode::Spatiotemporal] {
            accurate.direct.resampling.reuse = reuse;
            let seen = (1..=RUNS).map(|seed| mean(seed, &accurate, 16).0 / truth - 1.0);
            let seen: Vec<f64> = seen.collect();
            let off = seen.iter().sum::<f64>() / f64::from(RUNS);
            let spread: f64 = seen.iter().map(|run| (run - off).powi(2)).sum();
            let variance = spread / f64::from(RUNS * (RUNS - 1)) + truth_variance / truth.powi(2);
            let half_width = HALF_WIDTH * variance.sqrt();
            println!(
                "{reuse:?}: {:+.2} ± {:.2} %",
                100.0 * off,
                100.0 * half_width
            );
            assert!(
                half_width < 0.003 && off.abs() < 0.005,
                "{reuse:?}: {off} ± {half_width}"
            );
        }
        support::assert_no_messages(&device);
    }

    /// On a triangle of 2000 kilometres, rounding moves a point that is computed from barycentrics by some centimetres. On a
    /// slope of that size it is known to metres only, so the tested slope is a hundredth of that size.
    #[test]
    fn a_landscape_of_two_triangles_is_lit_like_a_floor() {
        let eye = DVec3::new(2.0, 3.0, 5.0);
        let camera = support::look_at(eye, DVec3::new(0.0, 0.3, 0.0), DVec3::Y, 0.8);
        for (reach, slope) in [(1_048_576.0, 0.0), (10_000.0, 0.1)] {
            for settings in techniques() {
                let lit = |reach| direct_light(&box_on_ground(reach, slope), &camera, &settings);
                let (floor, landscape) = (lit(16.0), lit(reach));
                let seen = floor.iter().filter(|&&value| value > 0.0).count();
                assert!(seen > floor.len() / 2, "{seen} pixels are lit");
                let both = || floor.iter().zip(&landscape);
                let dark = both().filter(|(near, far)| **far < 0.2 * **near).count();
                let bright = both()
                    .filter(|(near, far)| **far > 5.0 * **near + 0.05)
                    .count();
                println!(
                    "reach {reach}, slope {slope}, {:?}: {dark} dark, {bright} bright",
                    settings.integrator
                );
                // Distances to the ground are known no better, so a ray to the box's foot may meet the
                // ground first that is inside.
                assert!(
                    dark + bright <= 20,
                    "{dark} dark, {bright} bright of {seen}"
                );
            }
        }
    }

    /// The foot of a wall on a landscape must be lit by the ground in front of it. A second vertex that is known to
    /// decimetres only would lie inside the wall as often as in front of it.
    #[test]
    fn the_foot_of_a_wall_on_a_landscape_is_lit_by_the_ground_before_it() {
        let scene = box_on_ground(1_048_576.0, 0.0);
        // All that is seen is the lowest decimetre of the box.
        let eye = DVec3::new(0.0, 0.05, 1.5);
        let camera = support::look_at(eye, DVec3::new(0.0, 0.05, 0.5), DVec3::Y, 0.1);
        let (device, selection) = support::open_device(None);
        let [path_tracing, mut accurate] = techniques();
        accurate.indirect.resampling.reuse = ReuseMode::None;
        let [(truth, truth_variance), (seen, variance)] = [(path_tracing, 1024), (accurate, 512)]
            .map(|(settings, samples)| {
                let view = View {
                    camera: camera.clone(),
                    width: 32,
                    height: 32,
                    seed: 3,
                    bounces: 3,
                    jitter: false,
                };
                let variant = selection.variant;
                let seen = support::render(&device, &scene, variant, &view, &settings, samples);
                let sum = |values: &[[f64; 3]]| values.iter().flatten().sum::<f64>();
                (sum(&seen.mean), sum(&seen.error_squared))
            });
        support::assert_no_messages(&device);
        let off = seen / truth - 1.0;
        let sigma = (variance + truth_variance).sqrt() / truth;
        println!("{:+.1} ± {:.1} %", 100.0 * off, 100.0 * sigma);
        assert!(sigma < 0.005 && off.abs() < 0.02, "{off} ± {sigma}");
    }

    /// Where a ray meets two surfaces at once, rounding may put the shading point behind the other surface, which must not
    /// make the crease darker or brighter than the points beside it.
    #[test]
    fn creases_are_lit_like_what_is_beside_them() {
        // The centres of some pixels lie on the room's creases to the last bit.
        let room = procedural::generate("cornell", &[]).unwrap();
        for scene in [room.clone(), turned(room)] {
            for settings in techniques() {
                let lit = direct_light(&scene, &scene.cameras[0], &settings);
                let odd = odd_ones(&lit, 0.1, 3.0);
                assert!(odd.is_empty(), "{:?}: {odd:?}", settings.integrator);
            }
        }
    }
}
