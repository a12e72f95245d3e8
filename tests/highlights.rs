//! Tests of smooth metal beside the mirror image of an emitter. It shows the tail of a narrow lobe there, which neither a
//! point of the emitter nor a ray of the lobe finds often. `points_of_emitter` in `glsl/path_tracing/path_trace.comp`
//! explains the countermeasure.

mod support;

use glam::{DVec3, Vec3};
use headwater::device_scene::GpuScene;
use headwater::metrics::statistics::Estimate;
use headwater::render::presets::Preset;
use headwater::render::{Renderer, View};
use headwater::scene::{Camera, Material, Scene};
use std::sync::Arc;
use support::brute_force::{Surface, camera_ray};

const WIDTH: u32 = 48;
const HEIGHT: u32 = 36;
const SAMPLES: u32 = 16;
const SEEDS: u32 = 200;
const RADIANCE: f32 = 10.0;
/// A corner of the emitter, a square that lies 0.8 above the floor and emits downwards.
const CORNER: DVec3 = DVec3::new(-0.3, 0.8, -0.5);
const SIDE: f64 = 0.6;

fn metal() -> Material {
    Material {
        metallic: 1.0,
        roughness: 0.05,
        ..Material::lambert("metal", Vec3::new(0.9, 0.8, 0.6))
    }
}

fn scene() -> Scene {
    let emitter = Material {
        emission: Vec3::splat(RADIANCE),
        ..Material::lambert("lamp", Vec3::ZERO)
    };
    let floor = support::quad(Vec3::new(-2.0, 0.0, -2.0), Vec3::Z * 4.0, Vec3::X * 4.0);
    let (x, z) = (Vec3::X * SIDE as f32, Vec3::Z * SIDE as f32);
    support::scene_of(&[
        (metal(), floor),
        (emitter, support::quad(CORNER.as_vec3(), x, z)),
    ])
}

fn camera() -> Camera {
    support::look_at(
        DVec3::new(0.0, 0.8, 1.2),
        DVec3::new(0.16, 0.0, 0.5),
        DVec3::Y,
        0.15,
    )
}

/// The true radiance of the metal at the centre of each pixel, by a sum over the emitter; `None` where the emitter is
/// visible or nearly mirrored.
fn truth() -> Vec<Option<f64>> {
    let surface = Surface::new(&metal());
    // The shading frame of the floor, whose normal is +Y.
    let local = |v: DVec3| DVec3::new(v.x, v.z, v.y);
    let shown = |pixel: u32, cells: usize| {
        let (origin, way) = camera_ray(&camera(), [pixel % WIDTH, pixel / WIDTH], [WIDTH, HEIGHT]);
        let at = origin - way * (origin.y / way.y);
        let cell = SIDE / cells as f64;
        let mut sum = 0.0;
        for i in 0..cells * cells {
            let (u, v) = ((i % cells) as f64 + 0.5, (i / cells) as f64 + 0.5);
            let toward = CORNER + cell * DVec3::new(u, 0.0, v) - at;
            let distance_squared = toward.length_squared();
            let incoming = toward / distance_squared.sqrt();
            let f = surface.evaluate(local(-way), local(incoming)).y;
            sum += f * incoming.y * incoming.y / distance_squared;
        }
        sum * cell * cell * f64::from(RADIANCE)
    };
    // Darker pixels have too little light to matter, and brighter ones need a finer sum.
    let wanted = 0.03..1.0;
    let roughly = 0.01..3.0;
    (0..WIDTH * HEIGHT)
        .map(|pixel| {
            let candidate = roughly.contains(&shown(pixel, 60));
            let value = candidate.then(|| shown(pixel, 500))?;
            wanted.contains(&value).then_some(value)
        })
        .collect()
}

/// The root mean square of the relative deviations of pixels from the truth, and the ratio of the sum of all pixels to the
/// true sum.
fn deviation() -> (f64, Estimate) {
    let truth = truth();
    let count = truth.iter().flatten().count();
    assert!(count > 100, "{count} pixels");
    let settings = Preset::named("path-tracing").unwrap().settings().unwrap();
    let (device, selection) = support::open_device(None);
    let view = View {
        camera: camera(),
        width: WIDTH,
        height: HEIGHT,
        seed: 0,
        bounces: 1,
        jitter: false,
    };
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, &scene(), origin, selection.variant).unwrap();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, &settings).unwrap();
    let (mut squares, mut sums) = (0.0, Vec::new());
    for seed in 0..SEEDS {
        renderer.restart(seed).unwrap();
        renderer.add_samples(0, SAMPLES).unwrap();
        let seen = renderer.sums().unwrap().mean(SAMPLES);
        let pairs = seen.iter().zip(&truth);
        let pairs: Vec<_> = pairs
            .filter_map(|(pixel, truth)| Some((pixel.y, (*truth)?)))
            .collect();
        squares += pairs
            .iter()
            .map(|(pixel, truth)| (pixel / truth - 1.0).powi(2))
            .sum::<f64>();
        let (pixels, truths): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        sums.push(pixels.iter().sum::<f64>() / truths.iter().sum::<f64>());
    }
    support::assert_no_messages(&device);
    (
        (squares / f64::from(SEEDS) / count as f64).sqrt(),
        Estimate::of(&sums),
    )
}

/// The deviation must stay far below that of a path tracer which tries only one point of the emitter.
#[test]
fn metal_beside_the_image_of_an_emitter_has_few_outliers() {
    let (deviation, sum) = deviation();
    let half_width = sum.t_interval_half_width(0.999);
    println!(
        "deviation {deviation:.3}, sum {:.4} ± {half_width:.4}",
        sum.mean
    );
    assert!(
        (sum.mean - 1.0).abs() < half_width,
        "the sum is {} ± {half_width}",
        sum.mean
    );
    assert!(deviation < 1.0, "pixels deviate by {deviation}");
    assert!(half_width < 0.03, "the interval is ± {half_width}");
}

mod thorough {
    use super::support;

    /// The planted faults: one point of the emitter on every surface, points that count too often, and rays whose MIS
    /// weights ignore the points.
    #[test]
    fn outliers_and_wrong_weights_of_points_are_found() {
        let pass = "path_tracing/path_trace.comp";
        let faults = [
            (
                "clamp(round(32.0 * probability), 1.0, 16.0)",
                "1.0",
                "pixels deviate",
            ),
            ("/ (points * pdf_light)", "/ pdf_light", "the sum is"),
            (
                "samples_of_emitter(path.narrow, probability) * pdf_light",
                "pdf_light",
                "the sum is",
            ),
        ];
        for (text, replacement, message) in faults {
            let test = "metal_beside_the_image_of_an_emitter_has_few_outliers";
            let output = support::run_with_fault(test, (pass, text, replacement), |c| c);
            let said = support::said(&output);
            assert!(
                !output.status.success() && said.contains(message),
                "{replacement}: {said}"
            );
        }
    }
}
