//! Tests of the brute-force tracer: against itself, and against results that need no tracer.

use crate::comparison::{Comparison, by_brute_force, compare_pictures, failures, regions};
use crate::rooms::{ROOM_SIZE, emitter, room, standing_box};
use crate::support;
use crate::support::brute_force::{Options, Tracer};
use glam::{DAffine3, DVec3, Vec3};
use headwater::metrics::statistics::Estimate;
use headwater::scene::{Camera, Material, Scene};

#[test]
fn the_brute_force_estimators_agree() {
    let (mut scene, camera) = room();
    // An emitter that chance finds, turned to both sides so that its back counts too.
    let emitter = scene.materials.last_mut().unwrap();
    emitter.double_sided = true;
    let tracer = Tracer::new(&scene);
    let options = Options {
        bounces: 3,
        samples: 1024,
        seed: 3,
        nee: true,
    };
    let one = by_brute_force(&tracer, &camera, ROOM_SIZE, &options);
    let options = Options {
        samples: 4096,
        seed: 4,
        nee: false,
        ..options
    };
    let other = by_brute_force(&tracer, &camera, ROOM_SIZE, &options);
    let regions = regions(&scene, &tracer, &camera, ROOM_SIZE);
    let text = failures(&compare_pictures("room", &one, &other, &regions, &[]));
    assert!(text.is_empty(), "\n{text}");
}

/// A closed box that glows, with a white box in it, and a camera inside.
fn furnace(emission: f32, albedo: f32) -> (Scene, Camera) {
    let mut shell = standing_box([0.0, 0.0], Vec3::splat(4.0), 0.0);
    let corner = Vec3::new(-2.0, 0.0, -2.0);
    shell.extend(support::quad(corner, Vec3::X * 4.0, Vec3::Z * 4.0));
    let glow = Material {
        double_sided: true,
        ..emitter(Vec3::splat(emission), albedo)
    };
    let mut scene = support::scene_of(&[
        (glow, shell),
        (
            Material::lambert("white", Vec3::ONE),
            standing_box([0.0, 0.0], Vec3::ONE, 0.0),
        ),
    ]);
    // Off the floor, mirrored and stretched: the transform must not matter.
    scene.instances[1].object_to_world = DAffine3::from_translation(DVec3::new(0.1, 1.2, -0.2))
        * DAffine3::from_rotation_x(0.5)
        * DAffine3::from_scale(DVec3::new(-1.2, 0.9, 1.1));
    let (eye, target) = (DVec3::new(0.4, 2.2, 1.8), DVec3::new(0.1, 1.7, -0.2));
    (scene, support::look_at(eye, target, DVec3::Y, 1.0))
}

#[test]
fn a_white_furnace_is_one_by_brute_force() {
    let options = Options {
        bounces: 1,
        samples: 64,
        seed: 5,
        nee: false,
    };
    let (scene, camera) = furnace(1.0, 0.0);
    let picture = by_brute_force(&Tracer::new(&scene), &camera, [16, 16], &options);
    for value in picture.mean.iter().flatten() {
        assert!((value - 1.0).abs() < 1e-12, "{value}");
    }
    // Σ ρⁿ (1 − ρ), with the last of n scattering events missing, where the glow reflects too.
    let (scene, camera) = furnace(0.5, 0.5);
    let tracer = Tracer::new(&scene);
    let all: Vec<usize> = (0..256).collect();
    // What is missing is some 1e-6, from paths that stay in the white box, whose bottom is open; by
    // chance alone the noise is below that.
    let whole = Estimate {
        mean: 1.0,
        standard_error: 1e-5,
        samples: 1 << 40,
    };
    let mut comparisons = Vec::new();
    for nee in [false, true] {
        let options = Options {
            bounces: 40,
            samples: 256,
            nee,
            ..options
        };
        let picture = by_brute_force(&tracer, &camera, [16, 16], &options);
        for channel in 0..3 {
            comparisons.push(Comparison {
                what: format!("nee {nee}, channel {channel}"),
                one: picture.mean_of(&all, channel),
                other: whole,
                sharp: true,
            });
        }
    }
    let text = failures(&comparisons);
    assert!(text.is_empty(), "\n{text}");
}

#[test]
fn the_brute_force_tracer_finds_triangles() {
    let matte = Material::lambert("matte", Vec3::ONE);
    let corner = Vec3::new(0.0, 0.0, -4.0);
    let mut scene = support::scene_of(&[(matte, support::quad(corner, Vec3::X, Vec3::Y))]);
    scene.instances[0].object_to_world = DAffine3::from_scale(DVec3::new(2.0, 1.0, 1.0));
    let tracer = Tracer::new(&scene);
    // A direction of length 2; the second triangle lies above the diagonal.
    let (origin, direction) = (DVec3::new(0.5, 0.75, 0.0), DVec3::Z * -2.0);
    let hit = tracer.closest(origin, direction, 10.0).unwrap();
    assert_eq!((hit.instance, hit.triangle, hit.t), (0, 1, 2.0));
    assert_eq!((hit.u, hit.v), (0.25, 0.5));
    assert!(tracer.closest(origin, direction, 1.9).is_none());
    assert!(tracer.closest(origin, -direction, 10.0).is_none());
}
