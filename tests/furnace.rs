//! The white furnace test: a surface of albedo 1 in a uniformly bright room must be invisible.

mod support;

use glam::{DVec3, Vec3};
use headwater::device_scene::GpuScene;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::{Material, Scene};
use std::sync::Arc;

const ROUGHNESS: [f32; 13] = [
    0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0,
];
/// The half-width of the two-sided 99.9 % interval of the normal distribution, in standard deviations.
const Z: f64 = 3.29;

/// The measured albedo of one plate, and the half-width of its 99.9 % confidence interval.
struct Measured {
    kind: &'static str,
    roughness: f32,
    albedo: f64,
    half_width: f64,
}

/// A row of white metal plates and a row of white dielectric plates of rising roughness, flat on the ground. They are
/// stretched so that a camera whose direction makes the cosine `cosine` with their normal sees squares.
fn plates(cosine: f32) -> Scene {
    let length = 1.0 / cosine;
    let mut parts = Vec::new();
    for (row, metallic) in [1.0, 0.0].into_iter().enumerate() {
        for (column, roughness) in ROUGHNESS.into_iter().enumerate() {
            let corner = Vec3::new(
                (column as f32 - 6.5) * 1.2,
                0.0,
                (row as f32 - 1.0) * 1.2 * length + 1.1 * length,
            );
            let material = Material {
                metallic,
                roughness,
                ..Material::default()
            };
            parts.push((material, support::quad(corner, Vec3::X, -Vec3::Z * length)));
        }
    }
    let bright = Material {
        emission: Vec3::ONE,
        ..Material::lambert("room", Vec3::ZERO)
    };
    // The inward faces take the edges in the other order.
    let room = support::block(Vec3::splat(400.0))
        .flat_map(|[corner, u, v]| support::quad(corner, v, u))
        .collect();
    parts.push((bright, room));
    support::scene_of(&parts)
}

fn measure(energy: &str, cosine: f64, samples: u32) -> Vec<Measured> {
    let (device, selection) = support::open_device(None);
    let scene = plates(cosine as f32);
    let direction = DVec3::new(0.0, cosine, (1.0 - cosine * cosine).sqrt());
    let view = View {
        camera: support::look_at(direction * 100.0, DVec3::ZERO, -DVec3::Z, 0.0258),
        width: 400,
        height: 64,
        seed: 11,
        bounces: 1,
        jitter: false,
    };
    let change = Settings::parse_change(&format!("energy={energy}")).unwrap();
    let settings = Settings::default().with(&change).unwrap();
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, &scene, origin, selection.variant).unwrap();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, &settings).unwrap();
    renderer.add_samples(0, samples).unwrap();
    assert_eq!(renderer.rejected().unwrap(), 0);
    let surfaces = renderer.primary_surfaces().unwrap();
    let sums = renderer.sums().unwrap();
    let (mean, error) = (sums.mean(samples), sums.standard_error(samples));
    support::assert_no_messages(&device);
    (0..2 * ROUGHNESS.len())
        .map(|plate| {
            let (mut total, mut variance, mut pixels) = (0.0, 0.0, 0.0);
            for ((surface, mean), error) in surfaces.iter().zip(&mean).zip(&error) {
                if surface.instance == plate as u32 {
                    total += mean.x;
                    variance += error.x * error.x;
                    pixels += 1.0;
                }
            }
            assert!(pixels > 200.0, "plate {plate} covers {pixels} pixels");
            Measured {
                kind: if plate < ROUGHNESS.len() {
                    "metal"
                } else {
                    "dielectric"
                },
                roughness: ROUGHNESS[plate % ROUGHNESS.len()],
                albedo: total / pixels,
                half_width: Z * variance.sqrt() / pixels,
            }
        })
        .collect()
}

#[test]
fn the_plain_model_loses_and_gains_what_is_known_of_it() {
    let mut all = Vec::new();
    for cosine in [0.1, 0.4, 0.95] {
        for plate in measure("gltf", cosine, 200) {
            println!(
                "gltf {} r={} cos={cosine}: {:.4} ± {:.4}",
                plate.kind, plate.roughness, plate.albedo, plate.half_width
            );
            all.push((cosine, plate));
        }
    }
    let (cosine, worst) = extreme(&all, |a, b| a < b);
    assert_eq!((worst.kind, worst.roughness, cosine), ("metal", 1.0, 0.95));
    assert!((worst.albedo - 0.32).abs() < 0.01);
    let (cosine, brightest) = extreme(&all, |a, b| a > b);
    assert_eq!((brightest.kind, cosine), ("dielectric", 0.1));
    assert!(brightest.roughness <= 0.02);
    assert!((brightest.albedo - 1.53).abs() < 0.015);
}

/// The plate whose albedo comes before the albedo of all other plates in the order `before`, with its cosine.
fn extreme(all: &[(f64, Measured)], before: fn(f64, f64) -> bool) -> (f64, &Measured) {
    let mut found = &all[0];
    for other in all {
        if before(other.1.albedo, found.1.albedo) {
            found = other;
        }
    }
    (found.0, &found.1)
}

mod thorough {
    use super::*;

    #[test]
    fn compensated_surfaces_keep_all_light_at_every_roughness_and_angle() {
        // What the widest of the 26 intervals asks for.
        for (cosine, samples) in [(0.1, 1200), (0.4, 2200), (0.95, 3400)] {
            for plate in measure("compensated", cosine, samples) {
                let Measured {
                    kind,
                    roughness,
                    albedo,
                    half_width,
                } = plate;
                println!(
                    "compensated {kind} r={roughness} cos={cosine}: {albedo:.4} ± {half_width:.4}"
                );
                assert!(
                    half_width <= 0.002,
                    "{kind} r={roughness} cos={cosine}: ± {half_width}"
                );
                assert!(
                    (albedo - 1.0).abs() <= 0.005,
                    "{kind} r={roughness} cos={cosine}: {albedo}"
                );
            }
        }
    }
}
