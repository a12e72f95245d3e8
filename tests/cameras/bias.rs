//! Tests that resampling is unbiased with an orthographic camera and with a lens: the mean of late frames over many seeds
//! against path tracing of the same moment, at rest and with a moving camera, object and light.

use crate::{orthographic, preset, support, view, with_lens};
use headwater::device_scene::GpuScene;
use headwater::metrics::statistics::Estimate;
use headwater::procedural;
use headwater::render::settings::{Candidates, Secondary};
use headwater::render::{Renderer, Settings, View};
use headwater::scene::{Camera, Scene};
use std::sync::Arc;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;
const FRAMES_A_SECOND: f64 = 4.0;
/// Number of runs, each with another seed.
const SEEDS: u32 = 128;
/// Index of the compared frame.
const LOOKED_AT: u32 = 2;
/// Number of samples per pixel of the path-traced moment.
const SAMPLES: u32 = 1024;
/// The probability that a correct mean lies within its confidence interval.
const CONFIDENCE: f64 = 0.999;
/// The maximum half-width of the confidence interval, as a fraction of the mean; with a wider one, the comparison would
/// prove nothing.
const MAX_HALF_WIDTH: f64 = 0.01;

/// The generated scene `motion` in which the named things move, or nothing does, as `change` makes the camera of it.
fn playroom(moving: &[&str], change: impl Fn(&Camera) -> Camera) -> Scene {
    let names = ["camera", "object", "light", "toggle"];
    let speeds = names.map(|name| {
        let speed = if moving.contains(&name) { "1" } else { "0" };
        (name.to_owned(), speed.to_owned())
    });
    let mut scene = procedural::generate("motion", &speeds).unwrap();
    // Highlights are most of the noise, and none of what is looked for.
    for material in &mut scene.materials {
        (material.metallic, material.specular) = (0.0, 0.0);
    }
    scene.cameras[0] = change(&scene.cameras[0]);
    scene
}

fn jittered(camera: Camera) -> View {
    let mut view = view(camera, WIDTH, HEIGHT, 2);
    view.jitter = true;
    view
}

/// The mean of the picture of each seed.
fn means(scene: &Scene, settings: &Settings) -> Vec<f64> {
    let (device, selection) = support::open_device(None);
    let time = |frame: u32| f64::from(frame) / FRAMES_A_SECOND;
    let view = jittered(scene.camera_at(0, 0.0).unwrap());
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, scene, origin, selection.variant).unwrap();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, settings).unwrap();
    let means = (0..SEEDS).map(|seed| {
        renderer.restart(seed).unwrap();
        for frame in 0..=LOOKED_AT {
            renderer.set_time(time(frame));
            renderer.set_camera(&scene.camera_at(0, time(frame)).unwrap());
            renderer.single_frame(frame).unwrap();
        }
        let picture = renderer.frame_radiance().unwrap();
        let sum: f64 = picture.iter().flatten().map(|v| f64::from(*v)).sum();
        sum / f64::from(3 * WIDTH * HEIGHT)
    });
    let means = means.collect();
    assert_eq!(renderer.rejected().unwrap(), 0);
    support::assert_no_messages(&device);
    means
}

/// The mean of the picture at the moment of the compared frame, by path tracing.
fn truth(scene: &Scene) -> Estimate {
    let still = scene
        .pose_at(f64::from(LOOKED_AT) / FRAMES_A_SECOND)
        .unwrap();
    let (device, selection) = support::open_device(None);
    let view = jittered(still.cameras[0].clone());
    let settings = preset("path-tracing");
    let lit = support::render(
        &device,
        &still,
        selection.variant,
        &view,
        &settings,
        SAMPLES,
    );
    let values = f64::from(3 * WIDTH * HEIGHT);
    let sum = |of: &[[f64; 3]]| of.iter().flatten().sum::<f64>() / values;
    Estimate {
        mean: sum(&lit.mean),
        // The channels of a pixel are not independent, so their errors count as if they were equal.
        standard_error: (3.0 * sum(&lit.error_squared) / values).sqrt(),
        samples: u64::from(SAMPLES) * u64::from(WIDTH * HEIGHT),
    }
}

fn check(name: &str, scene: &Scene, change: impl Fn(&mut Settings)) {
    let mut settings = preset("accurate");
    change(&mut settings);
    let truth = truth(scene);
    let difference = Estimate::of(&means(scene, &settings)).minus(&truth);
    let bias = difference.mean / truth.mean;
    let half_width = difference.t_interval_half_width(CONFIDENCE) / truth.mean;
    let text = format!(
        "{name}: {:+.3} % ± {:.3} %",
        100.0 * bias,
        100.0 * half_width
    );
    println!("{text}");
    assert!(half_width <= MAX_HALF_WIDTH, "{text}: too noisy to tell");
    assert!(bias.abs() <= half_width, "{text}");
}

const ALL: [&str; 3] = ["camera", "object", "light"];

/// An orthographic camera that shows about what the perspective one shows.
fn parallel(camera: &Camera) -> Camera {
    orthographic(camera, 4.0)
}

/// A lens that is focused on the middle of the room.
fn blurred(camera: &Camera) -> Camera {
    with_lens(camera, 0.5, 4.0)
}

#[test]
fn an_orthographic_camera_at_rest() {
    check("at rest", &playroom(&[], parallel), |_| ());
}

#[test]
fn an_orthographic_camera_in_motion() {
    check("in motion", &playroom(&ALL, parallel), |_| ());
}

#[test]
fn an_orthographic_camera_with_cells_of_space() {
    check("cells", &playroom(&["camera"], parallel), |settings| {
        settings.direct.resampling.candidates = Candidates::HashGrid;
        settings.indirect.secondary = Secondary::WorldReservoirs;
        settings.world_reservoirs.min_lights = 0;
    });
}

#[test]
fn a_lens_at_rest() {
    check("at rest", &playroom(&[], blurred), |_| ());
}

#[test]
fn a_lens_in_motion() {
    check("in motion", &playroom(&ALL, blurred), |_| ());
}
