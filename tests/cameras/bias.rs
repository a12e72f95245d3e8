//! Tests that resampling is unbiased with an orthographic camera and with a lens: the mean of late frames over many seeds
//! against path tracing of the same moment, at rest and with a moving camera, object and light.

use crate::{orthographic, preset, renderer, support, view, with_lens};
use headwater::gpu::Device;
use headwater::metrics::statistics::Estimate;
use headwater::procedural;
use headwater::render::settings::{Candidates, ReuseMode, Secondary};
use headwater::render::{Renderer, Settings};
use headwater::scene::{Camera, Scene};
use std::sync::Arc;

const WIDTH: u32 = 32;
const HEIGHT: u32 = 24;
const FRAMES_A_SECOND: f64 = 4.0;
/// Number of runs, each with another seed.
const SEEDS: u32 = 640;
/// Number of runs with spatial reuse alone, where the samples that neighbours share make the mean of a picture noisy.
const MANY_SEEDS: u32 = 1600;
/// Number of samples per pixel of each path-traced moment, and the number of these.
const SAMPLES: u32 = 64;
const TRUE_SEEDS: u32 = 64;
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

/// The mean of the picture in the frame `looked_at` for each seed: of the light that was scattered at least once. With a lens
/// or jitter, the emission that the camera sees is most of the noise. The same seed has the same primary rays without any
/// scattering, so it is subtracted with its noise.
fn means(scene: &Scene, settings: &Settings, seeds: u32, looked_at: u32) -> Vec<f64> {
    let [all, emission] = [2, 0].map(|bounces| {
        let (device, mut renderer) = jittered(scene, settings, bounces);
        let means = (0..seeds).map(|seed| {
            renderer.restart(seed).unwrap();
            for frame in 0..=looked_at {
                let time = f64::from(frame) / FRAMES_A_SECOND;
                renderer.set_time(time);
                renderer.set_camera(&scene.camera_at(0, time).unwrap());
                renderer.single_frame(frame).unwrap();
            }
            let picture = renderer.frame_radiance().unwrap();
            mean(picture.iter().flatten().map(|v| f64::from(*v)))
        });
        let means: Vec<f64> = means.collect();
        assert_eq!(renderer.rejected().unwrap(), 0);
        support::assert_no_messages(&device);
        means
    });
    all.iter().zip(emission).map(|(a, b)| a - b).collect()
}

/// The same for the moment of the frame `looked_at`, by path tracing with `SAMPLES` samples per seed.
fn truth(scene: &Scene, looked_at: u32) -> Vec<f64> {
    let time = f64::from(looked_at) / FRAMES_A_SECOND;
    let still = scene.pose_at(time).unwrap();
    let [all, emission] = [2, 0].map(|bounces| {
        let (device, mut renderer) = jittered(&still, &preset("path-tracing"), bounces);
        let means = (0..TRUE_SEEDS).map(|seed| {
            renderer.restart(seed).unwrap();
            renderer.add_samples(0, SAMPLES).unwrap();
            let picture = renderer.sums().unwrap().mean(SAMPLES);
            mean(picture.iter().flat_map(|pixel| pixel.to_array()))
        });
        let means: Vec<f64> = means.collect();
        support::assert_no_messages(&device);
        means
    });
    all.iter().zip(emission).map(|(a, b)| a - b).collect()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    values.sum::<f64>() / f64::from(3 * WIDTH * HEIGHT)
}

/// A device, and a renderer of the scene's camera with jitter.
fn jittered(scene: &Scene, settings: &Settings, bounces: u32) -> (Arc<Device>, Renderer) {
    let mut view = view(scene.camera_at(0, 0.0).unwrap(), WIDTH, HEIGHT, bounces);
    view.jitter = true;
    renderer(scene, &view, settings)
}

/// Compares the mean of the frame `looked_at` over `seeds` seeds with path tracing.
fn check(name: &str, scene: &Scene, seeds: u32, looked_at: u32, change: impl Fn(&mut Settings)) {
    let mut settings = preset("accurate");
    change(&mut settings);
    let truth = Estimate::of(&truth(scene, looked_at));
    let difference = Estimate::of(&means(scene, &settings, seeds, looked_at)).minus(&truth);
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

/// Sets the reuse of direct and of indirect light.
fn reuse(settings: &mut Settings, mode: ReuseMode) {
    settings.direct.resampling.reuse = mode;
    settings.direct.resampling.light_samples = 24;
    settings.indirect.resampling.reuse = mode;
}

/// Compares reuse over time at rest and in motion, and reuse among neighbours.
fn check_all(name: &str, change: impl Fn(&Camera) -> Camera) {
    let [still, moving] =
        [&[][..], &["camera", "object", "light"]].map(|names| playroom(names, &change));
    for (motion, scene) in [("at rest", &still), ("in motion", &moving)] {
        let name = format!("{name} {motion}, over time");
        check(&name, scene, SEEDS, 2, |settings| {
            reuse(settings, ReuseMode::Temporal);
        });
    }
    // The many seeds take minutes, so they run with `tools/test --all` only.
    if !support::takes_largest() {
        return;
    }
    let name = format!("{name}, among neighbours");
    check(&name, &still, MANY_SEEDS, 0, |settings| {
        reuse(settings, ReuseMode::Spatial);
    });
}

/// An orthographic camera that shows about what the perspective one shows.
fn parallel(camera: &Camera) -> Camera {
    orthographic(camera, 2.5)
}

mod thorough {
    use super::*;

    #[test]
    fn a_lens_is_unbiased() {
        // Focused on the middle of the room.
        check_all("lens", |camera| with_lens(camera, 0.5, 4.0));
    }
}

/// The same checks of the simpler camera, and of sources that few settings use.
mod largest {
    use super::*;

    #[test]
    fn an_orthographic_camera_is_unbiased() {
        check_all("orthographic", parallel);
    }

    #[test]
    fn cells_of_space_are_unbiased_with_an_orthographic_camera() {
        let scene = playroom(&["camera"], parallel);
        check("cells", &scene, SEEDS, 2, |settings| {
            reuse(settings, ReuseMode::Temporal);
            settings.direct.resampling.candidates = Candidates::HashGrid;
            settings.indirect.secondary = Secondary::WorldReservoirs;
            settings.world_reservoirs.min_lights = 0;
        });
    }
}
