//! Tests of named surfaces: a picture whose primary surfaces name their triangles must have the mean of one whose surfaces
//! store materials.

use crate::support;
use headwater::device_scene::GpuScene;
use headwater::metrics::statistics::Estimate;
use headwater::procedural;
use headwater::render::presets::Preset;
use headwater::render::{Renderer, View};
use headwater::scene::Scene;
use headwater::shader_interface::PrimarySurface;
use std::sync::Arc;
use std::time::Instant;

const WIDTH: u32 = 40;
const HEIGHT: u32 = 24;
/// Number of pairs of runs; both runs of a pair have the same random numbers, so their difference has little noise.
const SEEDS: u32 = 12;
const FRAMES: u32 = 2;
const FRAMES_A_SECOND: f64 = 12.0;
/// The probability that a correct difference of means lies within its confidence interval.
const CONFIDENCE: f64 = 0.999;
/// The maximum half-width of the interval, as a fraction of the mean.
const MAX_HALF_WIDTH: f64 = 0.01;

/// The mean radiance of the last frame for each seed, and what the camera sees there.
fn runs(scene: &Scene, named: bool) -> (Vec<f64>, Vec<PrimarySurface>) {
    let (device, selection) = support::open_device(None);
    let view = View {
        camera: scene.camera_at(0, 0.0).unwrap(),
        width: WIDTH,
        height: HEIGHT,
        seed: 0,
        bounces: 2,
        jitter: false,
    };
    let origin = view.camera.camera_to_world.translation;
    let mut uploaded = GpuScene::new(&device, scene, origin, selection.variant).unwrap();
    assert!(!uploaded.requirements.named_surfaces);
    uploaded.requirements.named_surfaces = named;
    let settings = Preset::named("balanced").unwrap().settings().unwrap();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, &settings).unwrap();
    let start = Instant::now();
    let means = (0..SEEDS).map(|seed| {
        renderer.restart(seed).unwrap();
        for frame in 0..FRAMES {
            let time = f64::from(frame) / FRAMES_A_SECOND;
            renderer.set_time(time);
            renderer.set_camera(&scene.camera_at(0, time).unwrap());
            renderer.single_frame(frame).unwrap();
        }
        let radiance = renderer.frame_radiance().unwrap();
        let sum: f64 = radiance.iter().flatten().map(|v| f64::from(*v)).sum();
        sum / radiance.len() as f64
    });
    let means = means.collect();
    println!("named {named}: {:.2} s", start.elapsed().as_secs_f64());
    assert_eq!(renderer.rejected().unwrap(), 0);
    support::assert_no_messages(&device);
    (means, renderer.primary_surfaces().unwrap())
}

/// Textures, vertex colours, alpha, normal maps, an environment, and instances that move.
#[test]
fn named_surfaces_have_the_same_light_and_motion() {
    let settings = [("lantern", "pierced"), ("speed", "1")];
    let settings = settings.map(|(name, value)| (name.to_owned(), value.to_owned()));
    let scene = procedural::generate("conservatory", &settings).unwrap();
    let ((plain, seen), (named, seen_named)) = (runs(&scene, false), runs(&scene, true));
    let moving = seen.iter().filter(|s| s.motion.length() > 0.1).count();
    assert!(moving > 0, "nothing moves");
    for (a, b) in seen.iter().zip(&seen_named) {
        assert!((a.motion - b.motion).length() < 0.02, "{a:?}\n{b:?}");
    }
    let differences: Vec<f64> = plain.iter().zip(&named).map(|(a, b)| b - a).collect();
    let mean = plain.iter().sum::<f64>() / plain.len() as f64;
    let difference = Estimate::of(&differences);
    let half_width = difference.t_interval_half_width(CONFIDENCE) / mean;
    let bias = difference.mean / mean;
    let text = format!(
        "named: {:+.3} % ± {:.3} %",
        100.0 * bias,
        100.0 * half_width
    );
    println!("{text}");
    assert!(bias.abs() <= half_width, "{text}");
    assert!(half_width <= MAX_HALF_WIDTH, "{text}: too noisy to tell");
}

#[test]
fn wrong_materials_of_named_surfaces_are_seen() {
    let fault = (
        "restir/sample_data.glsl",
        "if (SURFACES_NAMED) return named_owner(data).material;",
        "if (SURFACES_NAMED) return 0u;",
    );
    let test = "named::named_surfaces_have_the_same_light_and_motion";
    let output = support::run_with_fault(test, fault, |command| command.arg("--nocapture"));
    let said = support::said(&output);
    println!("{said}");
    assert!(!output.status.success() && said.contains("named: ") && !said.contains("too noisy"));
}
