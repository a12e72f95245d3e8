//! Tests of boxes in the style of the Cornell box against the brute-force tracer.

use crate::comparison::{IMAGE, by_brute_force, compare_pictures, failures, on_device, regions};
use crate::rooms::{ROOM_SIZE, room};
use crate::support::brute_force::{Options, Tracer, camera_ray};
use headwater::procedural;
use headwater::render::View;
use headwater::scene::{Camera, Scene};

/// Asserts that no pixel centre lies on an edge, where rounding would decide which instance, or which face of a flat
/// instance, the pixel shows.
fn assert_off_edges(scene: &Scene, tracer: &Tracer, camera: &Camera, size: [u32; 2]) {
    for at in 0..size[0] * size[1] {
        let pixel = [at % size[0], at / size[0]];
        let (origin, direction) = camera_ray(camera, pixel, size);
        let (x, y) = direction.any_orthonormal_pair();
        let beside = [x, -x, y, -y].map(|aside| {
            let hit = tracer.closest(origin, direction + aside * 1e-5, f64::INFINITY)?;
            let mesh = scene.instances[hit.instance as usize].mesh as usize;
            let flat = scene.meshes[mesh].normals.is_empty();
            Some((hit.instance, flat.then_some(hit.triangle)))
        });
        assert_eq!(beside, [beside[0]; 4], "pixel {pixel:?} is on an edge");
    }
}

/// The scene with the albedo of white matte materials 2 % too high, a fault that the comparison must find.
fn with_a_fault(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for material in &mut scene.materials {
        let color = material.base_color;
        if material.specular == 0.0 && color.min_element() > 0.7 {
            material.base_color *= 1.02;
        }
    }
    scene
}

/// One comparison: the length of paths, the number of samples, and the regions that are compared precisely.
struct Plan {
    bounces: u32,
    /// Number of samples per pixel, of each tracer.
    samples: u32,
    /// Names of the regions whose means must be known so precisely that a fault is not hidden by noise.
    sharp: &'static [&'static str],
}

fn assert_as_brute_force_says(
    scene: &Scene,
    camera: &Camera,
    size: [u32; 2],
    seed: u32,
    plans: &[Plan],
) {
    let tracer = Tracer::new(scene);
    let faulty_tracer = Tracer::new(&with_a_fault(scene));
    assert_off_edges(scene, &tracer, camera, size);
    let regions = regions(scene, &tracer, camera, size);
    let mut comparisons = Vec::new();
    let mut faulty = Vec::new();
    for plan in plans {
        let view = View {
            camera: camera.clone(),
            width: size[0],
            height: size[1],
            seed,
            bounces: plan.bounces,
            jitter: false,
        };
        let options = Options {
            bounces: plan.bounces,
            samples: plan.samples,
            seed: u64::from(seed) + 1,
            nee: true,
        };
        let few = Options {
            samples: plan.samples / 16,
            ..options
        };
        let picture = on_device(scene, &view, plan.samples);
        let truth = by_brute_force(&tracer, camera, size, &options);
        let wrong = by_brute_force(&faulty_tracer, camera, size, &few);
        let compare = |what, with, sharp| {
            let name = format!("{what}, {} bounces", plan.bounces);
            compare_pictures(&name, &picture, with, &regions, sharp)
        };
        comparisons.extend(compare("truth", &truth, plan.sharp));
        faulty.extend(compare("fault", &wrong, &[]));
    }
    let text = failures(&comparisons);
    assert!(text.is_empty(), "\n{text}");
    let text = failures(&faulty);
    for plan in plans {
        let image = format!("fault, {} bounces, {IMAGE}", plan.bounces);
        let seen = |line: &str| line.starts_with(&image) && line.contains(" is not ");
        assert!(
            text.lines().any(seen),
            "{image}: a planted fault was not seen\n{text}"
        );
    }
}

/// Width and height of the pictures in pixels. The camera looks at the middle of the back wall; with an even and an odd
/// number, no pixel centre lies on the wall's diagonals.
const BOX_SIZE: [u32; 2] = [24, 25];
/// Names of the regions that are compared precisely: the picture without emitters, and the instances that cover many pixels.
const WALLS: &[&str] = &[IMAGE, "back wall", "floor", "red wall", "green wall"];

mod thorough {
    use super::*;

    #[test]
    fn the_cornell_box_is_as_the_brute_force_tracer_says() {
        let scene = procedural::generate("cornell", &[]).unwrap();
        let plans = [(1, 8192), (5, 16384)].map(|(bounces, samples)| Plan {
            bounces,
            samples,
            sharp: WALLS,
        });
        assert_as_brute_force_says(&scene, &scene.cameras[0], BOX_SIZE, 21, &plans);
    }

    #[test]
    fn the_glossy_cornell_box_is_as_the_brute_force_tracer_says() {
        let scene = procedural::generate("cornell-glossy", &[]).unwrap();
        let plans = [
            Plan {
                bounces: 1,
                samples: 10240,
                sharp: WALLS,
            },
            // Light that the metals gather makes single walls too noisy.
            Plan {
                bounces: 5,
                samples: 16384,
                sharp: &[IMAGE],
            },
        ];
        assert_as_brute_force_says(&scene, &scene.cameras[0], BOX_SIZE, 31, &plans);
    }

    #[test]
    fn a_room_is_as_the_brute_force_tracer_says() {
        let (scene, camera) = room();
        let plans = [(1, 2048), (5, 14336)].map(|(bounces, samples)| Plan {
            bounces,
            samples,
            sharp: &[IMAGE],
        });
        assert_as_brute_force_says(&scene, &camera, ROOM_SIZE, 11, &plans);
    }
}
