//! Tests with changes of a scene that must not change its picture beyond noise: lights in more pieces, another order, other
//! names, copies instead of instances, a mirror image, geometry that the camera does not see. They need no true picture, and
//! so reach scenes without a closed form. Changes that must keep every bit (brightness and size times a power of two) are in
//! `extremes.rs`.

mod support;

use glam::{DAffine3, DVec3, Vec3};
use headwater::device_scene::GpuScene;
use headwater::metrics::statistics::{Estimate, holm, welch_p_value};
use headwater::procedural;
use headwater::render::presets::Preset;
use headwater::render::settings::{Candidates, Secondary};
use headwater::render::{Renderer, Settings, View};
use headwater::scene::{Material, Mesh, Scene};
use std::collections::BTreeMap;
use std::sync::Arc;

const SIDE: u32 = 32;
const BLOCK: u32 = 8;
const FRAMES: u32 = 4;
/// Number of runs of each scene, each with another seed.
const SEEDS: u32 = 48;
/// The probability of an alarm without a cause, over all blocks of a comparison.
const LEVEL: f64 = 1e-4;
/// A part of the message of a failed comparison.
const CHANGES: &str = "changes the picture";

/// A box with glossy objects and three emitters: one at the ceiling, a dim one that is a rare light, and a small one whose
/// back faces the camera.
fn scene() -> Scene {
    let mut scene = procedural::generate("cornell-glossy", &[]).unwrap();
    let emitter = |name: &str, radiance: Vec3| Material {
        emission: radiance,
        ..Material::lambert(name, Vec3::splat(0.5))
    };
    let corner = Vec3::new(-0.9, 0.3, -0.95);
    let dim = support::quad(corner, Vec3::X * 0.1, Vec3::Y * 0.1);
    support::add(&mut scene, &emitter("dim", Vec3::new(0.2, 0.6, 0.9)), &dim);
    let corner = Vec3::new(0.6, 0.05, 0.7);
    let small = support::quad(corner, Vec3::Y * 0.2, Vec3::X * 0.2);
    support::add(
        &mut scene,
        &emitter("small", Vec3::new(9.0, 6.0, 2.0)),
        &small,
    );
    // Eggs that lie on their sides, and a second one of each above: meshes of one instance are uploaded in the world's
    // coordinates, and only those of several are turned by shaders.
    let turn = DAffine3::from_rotation_z(1.2) * DAffine3::from_scale(DVec3::new(1.0, 0.7, 0.9));
    let mut eggs = Vec::new();
    for instance in &mut scene.instances {
        if instance.name.starts_with("sphere") {
            instance.object_to_world *= turn;
            let mut second = instance.clone();
            second.object_to_world.translation.y += 1.0;
            eggs.push(second);
        }
    }
    scene.instances.extend(eggs);
    // Not on the axis of the box, where edges would pass through the centres of pixels, and rounding would choose the wall.
    scene.cameras[0].camera_to_world.translation += DVec3::new(0.013, 0.017, 0.0);
    scene.validate().unwrap();
    scene
}

/// Names and settings that cover every kind of reservoir: light samples and paths, compact and full, each light sampler, and
/// world reservoirs. Without `--all` only two of them, which together have the most features.
fn techniques() -> BTreeMap<&'static str, Settings> {
    let preset = |name: &str| Preset::named(name).unwrap().settings().unwrap();
    let mut with_grid = preset("accurate");
    with_grid.direct.resampling.candidates = Candidates::HashGrid;
    with_grid.indirect.secondary = Secondary::WorldReservoirs;
    with_grid.world_reservoirs.min_lights = 0;
    let mut with_tree = preset("balanced");
    with_tree.direct.resampling.candidates = Candidates::LightBvh;
    with_tree.indirect.resampling.candidates = Candidates::LightBvh;
    let mut techniques = BTreeMap::from([
        ("path tracing", preset("path-tracing")),
        ("fast", preset("fast")),
        ("s1", preset("s1")),
        ("light BVH", with_tree),
        ("hash grid and world reservoirs", with_grid),
    ]);
    let few = ["light BVH", "hash grid and world reservoirs"];
    techniques.retain(|name, _| support::takes_largest() || few.contains(name));
    techniques
}

/// For each block of the picture, the sum of its radiance (all pixels and channels) in the last frame, one value per seed.
/// Blocks are row by row from left to right, with `mirrored` from right to left.
fn blocks(scene: &Scene, settings: &Settings, first_seed: u32, mirrored: bool) -> Vec<Vec<f64>> {
    let (device, selection) = support::open_device(None);
    let view = View {
        camera: scene.cameras[0].clone(),
        width: SIDE,
        height: SIDE,
        seed: 0,
        bounces: 3,
        jitter: false,
    };
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, scene, origin, selection.variant).unwrap();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, settings).unwrap();
    let across = SIDE / BLOCK;
    let mut all = vec![Vec::new(); (across * across) as usize];
    for seed in first_seed..first_seed + SEEDS {
        renderer.restart(seed).unwrap();
        for frame in 0..FRAMES {
            renderer.single_frame(frame).unwrap();
        }
        let mut sums = vec![0.0; all.len()];
        for (pixel, radiance) in (0..).zip(renderer.frame_radiance().unwrap()) {
            let (x, y) = (pixel % SIDE, pixel / SIDE);
            let x = if mirrored { SIDE - 1 - x } else { x };
            sums[(y / BLOCK * across + x / BLOCK) as usize] +=
                radiance.iter().map(|v| f64::from(*v)).sum::<f64>();
        }
        all.iter_mut()
            .zip(sums)
            .for_each(|(block, sum)| block.push(sum));
    }
    support::assert_no_messages(&device);
    all
}

/// The smallest p-value over the blocks, corrected for their number, of the hypothesis that two scenes look the same.
fn p_value(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let pairs = a.iter().zip(b);
    let p_values: Vec<f64> = pairs
        .map(|(a, b)| welch_p_value(&Estimate::of(a), &Estimate::of(b)))
        .collect();
    holm(&p_values).into_iter().fold(1.0, f64::min)
}

/// Compares the changed scene with the original one, with every technique. After an alarm, the comparison with fresh seeds
/// decides.
fn assert_looks_the_same(name: &str, changed: &Scene, mirrored: bool) {
    let plain = scene();
    for (technique, settings) in techniques() {
        let compare = |first_seed: u32| {
            let seen = blocks(&plain, &settings, first_seed, false);
            p_value(
                &seen,
                &blocks(changed, &settings, first_seed + 10_000, mirrored),
            )
        };
        let mut p = compare(0);
        if p < LEVEL {
            p = compare(20_000);
        }
        println!("{name}, {technique}: p {p:.2e}");
        assert!(p >= LEVEL, "{name} {CHANGES} of {technique}: p {p:.2e}");
    }
}

/// The scene with each emissive triangle split into four.
fn with_split_lights(mut scene: Scene) -> Scene {
    let is_emitter: Vec<bool> = scene
        .materials
        .iter()
        .map(|m| m.emission != Vec3::ZERO)
        .collect();
    for mesh in &mut scene.meshes {
        if !mesh
            .parts
            .iter()
            .any(|part| is_emitter[part.material as usize])
        {
            continue;
        }
        assert!(mesh.normals.is_empty() && mesh.parts.len() == 1);
        let mut triangles = Vec::new();
        for [a, b, c] in std::mem::take(&mut mesh.triangles) {
            let mut middle = |i: u32, j: u32| {
                let point = (mesh.positions[i as usize] + mesh.positions[j as usize]) / 2.0;
                mesh.positions.push(point);
                mesh.positions.len() as u32 - 1
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        mesh.parts[0].triangle_count = triangles.len() as u32;
        mesh.triangles = triangles;
    }
    scene.validate().unwrap();
    scene
}

/// The scene with materials, triangles, meshes and instances in the opposite order.
fn reordered(mut scene: Scene) -> Scene {
    let last = scene.materials.len() as u32 - 1;
    scene.materials.reverse();
    for mesh in &mut scene.meshes {
        assert_eq!(mesh.parts.len(), 1);
        mesh.parts[0].material = last - mesh.parts[0].material;
        mesh.triangles.reverse();
    }
    let last = scene.meshes.len() as u32 - 1;
    scene.meshes.reverse();
    for instance in &mut scene.instances {
        instance.mesh = last - instance.mesh;
    }
    scene.instances.reverse();
    scene
}

/// The scene with a separate mesh per instance, in world coordinates.
fn with_copies(mut scene: Scene) -> Scene {
    let meshes = std::mem::take(&mut scene.meshes);
    for instance in &mut scene.instances {
        let mut mesh: Mesh = meshes[instance.mesh as usize].clone();
        let to_world = std::mem::replace(&mut instance.object_to_world, DAffine3::IDENTITY);
        for position in &mut mesh.positions {
            *position = to_world.transform_point3(position.as_dvec3()).as_vec3();
        }
        let normals = to_world.matrix3.inverse().transpose();
        for normal in &mut mesh.normals {
            *normal = (normals * normal.as_dvec3()).normalize().as_vec3();
        }
        instance.mesh = scene.meshes.len() as u32;
        scene.meshes.push(mesh);
    }
    scene.validate().unwrap();
    scene
}

/// The mirror image of the scene: left is right.
fn mirrored(mut scene: Scene) -> Scene {
    let flip = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    for instance in &mut scene.instances {
        instance.object_to_world = flip * instance.object_to_world;
    }
    let camera = &mut scene.cameras[0].camera_to_world;
    // The camera keeps its own sides.
    *camera = flip * *camera * flip;
    scene.validate().unwrap();
    scene
}

/// The scene with panels behind its walls, which neither the camera nor any light reaches.
fn with_unseen_geometry(mut scene: Scene) -> Scene {
    let grey = Material::lambert("unseen", Vec3::splat(0.5));
    for x in [-3.0, 2.0] {
        let corner = Vec3::new(x, 0.2, -0.5);
        support::add(&mut scene, &grey, &support::quad(corner, Vec3::Y, Vec3::Z));
    }
    scene.validate().unwrap();
    scene
}

/// Runs a test of this file again in a new process with a fault in the shaders, and asserts that it fails with the text
/// `complaint`.
fn assert_found(test: &str, fault: (&str, &str, &str), complaint: &str) {
    let output = support::run_with_fault(test, fault, |command| command);
    let said = support::said(&output);
    assert!(
        !output.status.success() && said.contains(complaint),
        "{said}"
    );
}

#[test]
fn lights_in_more_pieces_look_the_same() {
    assert_looks_the_same("splitting", &with_split_lights(scene()), false);
}

mod thorough {
    use super::*;

    #[test]
    fn the_order_does_not_matter() {
        assert_looks_the_same("reordering", &reordered(scene()), false);
    }

    #[test]
    fn copies_look_like_instances() {
        assert_looks_the_same("copying", &with_copies(scene()), false);
    }

    #[test]
    fn a_mirror_image_is_one() {
        assert_looks_the_same("mirroring", &mirrored(scene()), true);
    }

    #[test]
    fn what_nobody_sees_changes_nothing() {
        assert_looks_the_same("adding", &with_unseen_geometry(scene()), false);
    }

    #[test]
    fn densities_that_small_lights_do_not_have_are_found() {
        let area = "probability / light_at(point.index, CURRENT).area";
        let wrong = "probability / max(light_at(point.index, CURRENT).area, 0.1)";
        let fault = ("lights/light_point.glsl", area, wrong);
        assert_found("lights_in_more_pieces_look_the_same", fault, CHANGES);
    }

    #[test]
    fn a_first_light_that_is_never_drawn_is_found() {
        let drawn = "LightPoint(LIGHT_TRIANGLE, light, uniform";
        let wrong = "LightPoint(LIGHT_TRIANGLE, max(light, 1u), uniform";
        let fault = ("lights/light_point.glsl", drawn, wrong);
        assert_found("thorough::the_order_does_not_matter", fault, CHANGES);
    }

    #[test]
    fn normals_that_are_left_in_object_space_are_found() {
        let turned =
            "normalize(transform_normal(instance.world_to_object, unpack_octahedral(packed)))";
        let fault = (
            "scene/triangle_point.glsl",
            turned,
            "unpack_octahedral(packed)",
        );
        assert_found("thorough::copies_look_like_instances", fault, CHANGES);
    }

    #[test]
    fn rays_that_leave_to_one_side_are_found() {
        let around = "r * on_circle(u.y)";
        let fault = (
            "bsdf/diffuse.glsl",
            around,
            "r * on_circle(0.5 * u.y - 0.25)",
        );
        assert_found("thorough::a_mirror_image_is_one", fault, CHANGES);
    }

    #[test]
    #[should_panic(expected = "changes the picture")]
    fn a_panel_that_is_seen_is_found() {
        let mut scene = scene();
        let grey = Material::lambert("seen", Vec3::splat(0.5));
        let panel = support::quad(Vec3::new(-0.4, 1.2, -0.4), Vec3::X * 0.8, Vec3::Z * 0.8);
        support::add(&mut scene, &grey, &panel);
        assert_looks_the_same("adding", &scene, false);
    }

    /// Other names in a scene must not change a bit of its picture.
    #[test]
    fn names_change_no_bit() {
        let mut renamed = scene();
        for instance in &mut renamed.instances {
            instance.name += " 2";
        }
        for material in &mut renamed.materials {
            material.name.insert(0, '_');
        }
        renamed.meshes.iter_mut().for_each(|mesh| mesh.name.clear());
        for (technique, settings) in techniques() {
            let bits = |scene: &Scene| support::frame_bits(scene, &settings, None);
            assert!(bits(&scene()) == bits(&renamed), "{technique}");
            let mut brighter = scene();
            let emitter = brighter.materials.iter_mut().find(|m| m.is_emissive());
            emitter.unwrap().emission *= 1.0 + f32::EPSILON;
            assert!(bits(&scene()) != bits(&brighter), "{technique}");
        }
    }

    #[test]
    fn reuse_that_gains_energy_is_found() {
        if !support::takes_largest() {
            return;
        }
        let fault = (
            "restir/algebra.glsl",
            "front * fraction / neighbour_fraction * pair;",
            "1.005 * front * fraction / neighbour_fraction * pair;",
        );
        let test = "thorough::furnaces_keep_their_energy_over_four_thousand_frames";
        assert_found(test, fault, "Estimate");
    }

    /// Reuse over thousands of frames must neither gain nor lose energy.
    #[test]
    fn furnaces_keep_their_energy_over_four_thousand_frames() {
        let settings = [("body", "sphere"), ("metallic", "0"), ("specular", "0")];
        let settings = settings.map(|(key, value)| (key.to_owned(), value.to_owned()));
        let furnace = procedural::generate("furnace", &settings).unwrap();
        for (technique, settings) in techniques() {
            let (device, selection) = support::open_device(None);
            let view = View {
                camera: furnace.cameras[0].clone(),
                width: 8,
                height: 8,
                seed: 1,
                bounces: 2,
                jitter: false,
            };
            let origin = view.camera.camera_to_world.translation;
            let uploaded = GpuScene::new(&device, &furnace, origin, selection.variant).unwrap();
            let mut renderer =
                Renderer::new(&device, Arc::new(uploaded), &view, &settings).unwrap();
            let mut means = Vec::new();
            for frame in 0..4000 {
                renderer.single_frame(frame).unwrap();
                if frame % 20 == 19 {
                    let seen = renderer.frame_radiance().unwrap();
                    means.push(
                        seen.iter().map(|p| f64::from(p[1])).sum::<f64>() / seen.len() as f64,
                    );
                }
            }
            support::assert_no_messages(&device);
            let (first, last) = means.split_at(means.len() / 2);
            for part in [first, last] {
                let mean = Estimate::of(part);
                let half_width = mean.t_interval_half_width(0.9999);
                println!("{technique}: {:.5} ± {half_width:.5}", mean.mean);
                assert!(
                    (mean.mean - 1.0).abs() < half_width + 1e-5,
                    "{technique}: {mean:?}"
                );
                assert!(half_width < 0.01, "{technique}: {half_width}");
            }
        }
    }
}
