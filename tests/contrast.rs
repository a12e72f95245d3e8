//! Tests of scenes with lights of very different brightness. An opaque wall divides a room, both halves have emitters, and
//! an emitter that the camera does not see is far brighter than the others. The picture must still have the light of the dim
//! emitters. Resampling that compares candidates before their shadow rays gives a clean picture that is nearly black, so the
//! tests check the median over the pixels as well as the mean. `headwater study --plan contrast` has many more cases, with
//! confidence intervals.

mod support;

use glam::{DAffine3, DQuat, Vec3};
use headwater::device_scene::GpuScene;
use headwater::metrics::error::median_ratio;
use headwater::metrics::statistics::Estimate;
use headwater::procedural;
use headwater::render::presets::Preset;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::{PunctualLight, PunctualShape, Scene};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

const FRAMES: u32 = 64;
/// Number of samples per pixel of the true picture, which path tracing renders without the bright emitter.
const TRUE_SAMPLES: u32 = 4096;
const WIDTH: u32 = 32;
const HEIGHT: u32 = 24;
/// Width in pixels of pictures of shadow edges, which need more pixels than the other pictures.
const EDGE_WIDTH: u32 = 96;
const EDGE_HEIGHT: u32 = 72;
const BESIDE_EDGE: usize = 5;
/// The sum of the channels of a pixel at and above which the pixel shows an emitter; such pixels are not compared.
const EMITTER: f64 = 17.0;

fn divided_room(more: &str) -> Scene {
    let settings = more.split(',').filter_map(|pair| pair.split_once('='));
    let settings: Vec<_> = settings
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .collect();
    procedural::generate("divided-room", &settings).unwrap()
}

/// The room without the emitter of this name ("bright lamp" or "dim lamp"), and without motion.
fn without(mut scene: Scene, emitter: &str) -> Scene {
    scene.instances.retain(|instance| instance.name != emitter);
    scene.motion = None;
    scene
}

fn preset(name: &str, change: &[&str]) -> Settings {
    let settings = Preset::named(name).unwrap().settings().unwrap();
    change.iter().fold(settings, |settings, change| {
        let change = Settings::parse_change(change).unwrap();
        settings.with(&change).unwrap()
    })
}

fn view(scene: &Scene, bounces: u32, seed: u32, width: u32, height: u32) -> View {
    View {
        camera: scene.cameras[0].clone(),
        width,
        height,
        seed,
        bounces,
        jitter: false,
    }
}

/// The sum of the channels of each pixel, row by row, in the mean of `samples` samples per pixel.
fn picture(scene: &Scene, settings: &Settings, view: &View, samples: u32) -> Vec<f64> {
    let (device, selection) = support::open_device(None);
    let rendered = support::render(&device, scene, selection.variant, view, settings, samples);
    support::assert_no_messages(&device);
    (rendered.mean.iter())
        .map(|pixel| pixel.iter().sum())
        .collect()
}

/// The true picture of a room: the light of its dim emitters alone. Rooms that differ only in contrast share it.
fn truth_of(room: &str, scene: &Scene, view: &View) -> Vec<f64> {
    static TRUTHS: Mutex<BTreeMap<(String, u32), Vec<f64>>> = Mutex::new(BTreeMap::new());
    let emitters = room.split(',').filter(|pair| !pair.starts_with("contrast"));
    let mut truths = TRUTHS.lock().unwrap_or_else(PoisonError::into_inner);
    let truth = truths
        .entry((emitters.collect(), view.bounces))
        .or_insert_with(|| {
            let mut dim = without(scene.clone(), "bright lamp");
            dim.punctual_lights.clear();
            picture(&dim, &preset("path-tracing", &[]), view, TRUE_SAMPLES)
        });
    truth.clone()
}

/// The cases of a test: `all` with `--all`, otherwise `few`.
fn of<T>(all: &'static [T], few: &'static [T]) -> &'static [T] {
    if support::takes_largest() { all } else { few }
}

/// Renders a room with a preset, and compares median and mean of its pixels with the true picture. The mean of one picture
/// has an error of about 1 %.
fn assert_dim_emitters_are_seen(room: &str, name: &str, change: &[&str], bounces: u32) {
    assert_scene_shows(&divided_room(room), room, name, change, bounces);
}

/// Renders a scene with a preset, and compares it with the true picture of `room`; the scene is that room with additional
/// lights that the camera does not see.
fn assert_scene_shows(scene: &Scene, room: &str, name: &str, change: &[&str], bounces: u32) {
    let view = view(scene, bounces, 3, WIDTH, HEIGHT);
    let truth = truth_of(room, scene, &view);
    let found = picture(scene, &preset(name, change), &view, FRAMES);
    let pairs: Vec<(f64, f64)> = (found.into_iter().zip(truth))
        .filter(|(_, truth)| *truth > 0.0 && *truth < EMITTER)
        .collect();
    assert!(pairs.len() > 600);
    let median = median_ratio(pairs.iter().copied());
    let mean = pairs.iter().map(|p| p.0).sum::<f64>() / pairs.iter().map(|p| p.1).sum::<f64>();
    let what =
        format!("{name} {change:?}, {bounces} bounces, {room}: median {median:.3}, mean {mean:.3}");
    println!("{what}");
    assert!((0.9..1.1).contains(&median), "{what}");
    assert!((mean - 1.0).abs() < 0.04, "{what}");
}

/// Indices of pixels in the shadow of the bright emitter, two to five pixels from the shadow's edge. Pixels at the edge are
/// left out, since some of them see a small part of the emitter that the few samples of this picture miss.
fn beside_the_edge(scene: &Scene, view: &View) -> Vec<usize> {
    let bright = without(scene.clone(), "dim lamp");
    let light = picture(&bright, &preset("path-tracing", &[]), view, 256);
    let (width, height) = (view.width as usize, view.height as usize);
    let is_lit_within = |pixel: usize, reach: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let near = |at: usize, size: usize| at.saturating_sub(reach)..=(at + reach).min(size - 1);
        near(y, height).any(|y| near(x, width).any(|x| light[y * width + x] > 0.0))
    };
    (0..light.len())
        .filter(|pixel| !is_lit_within(*pixel, 1) && is_lit_within(*pixel, BESIDE_EDGE))
        .collect()
}

/// For each of `seeds` runs, the value that a preset finds and the true value at each pixel beside the shadow's edge. At
/// rest, the values are means of all frames; with a moving camera, of the last frame alone.
fn umbra(
    contrast: &str,
    name: &str,
    moving: bool,
    seeds: u32,
    true_samples: u32,
) -> Vec<Vec<(f64, f64)>> {
    let speed = if moving { "1" } else { "0" };
    let mut scene = divided_room(&format!(
        "wall=short,lamps=4,contrast={contrast},camera={speed}"
    ));
    // Its highlights are noise of single pixels.
    for material in &mut scene.materials {
        (material.metallic, material.specular) = (0.0, 0.0);
    }
    let time = |frame: u32| if moving { f64::from(frame) / 30.0 } else { 0.0 };
    let mut view = view(&scene, 1, 3, EDGE_WIDTH, EDGE_HEIGHT);
    let settings = preset(name, &[]);
    let (device, selection) = support::open_device(None);
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, &scene, origin, selection.variant).unwrap();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, &settings).unwrap();
    let runs: Vec<Vec<f64>> = (0..seeds)
        .map(|seed| {
            renderer.restart(3 + seed).unwrap();
            for frame in 0..FRAMES {
                renderer.set_time(time(frame));
                renderer.set_camera(&scene.camera_at(0, time(frame)).unwrap());
                if moving {
                    renderer.single_frame(frame).unwrap();
                } else {
                    renderer.add_samples(frame, 1).unwrap();
                }
            }
            if moving {
                renderer.keep_single_frame().unwrap();
            }
            let samples = if moving { 1 } else { FRAMES };
            let mean = renderer.sums().unwrap().mean(samples);
            mean.iter().map(|pixel| pixel.element_sum()).collect()
        })
        .collect();
    support::assert_no_messages(&device);
    view.camera = scene.camera_at(0, time(FRAMES - 1)).unwrap();
    let dim = without(scene.clone(), "bright lamp");
    let truth = picture(&dim, &preset("path-tracing", &[]), &view, true_samples);
    let lit: Vec<usize> = (beside_the_edge(&scene, &view).into_iter())
        .filter(|pixel| truth[*pixel] > 0.0 && truth[*pixel] < EMITTER)
        .collect();
    assert!(lit.len() > 100, "{}", lit.len());
    let pairs = |found: &Vec<f64>| {
        lit.iter()
            .map(|pixel| (found[*pixel], truth[*pixel]))
            .collect()
    };
    runs.iter().map(pairs).collect()
}

/// Asserts that the median of found over true values is right beside the edge of the bright emitter's shadow.
fn assert_umbra_is_right(contrast: &str, name: &str, moving: bool) {
    let pairs = umbra(contrast, name, moving, 1, 1024).remove(0);
    let median = median_ratio(pairs.iter().copied());
    let what = format!(
        "{name}, contrast {contrast}, moving {moving}, {} pixels: median {median:.3}",
        pairs.len()
    );
    println!("{what}");
    assert!((0.9..1.1).contains(&median), "{what}");
}

#[test]
fn a_dim_emitter_is_seen_beside_a_hidden_bright_one() {
    assert_dim_emitters_are_seen("contrast=1e4", "fast", &[], 1);
}

mod thorough {
    use super::*;

    #[test]
    #[should_panic(expected = "median 0.0")]
    fn dim_emitters_that_are_resampled_with_the_bright_one_are_missed() {
        assert_dim_emitters_are_seen("contrast=1e6", "fast", &["direct.rare_lights=0"], 1);
    }

    #[test]
    fn presets_see_dim_emitters_at_every_contrast_and_number() {
        const ROOMS: &[&str] = &[
            "contrast=1e9",
            "lamps=1000,contrast=1e6",
            "contrast=50",
            "contrast=300",
            "lamps=30",
        ];
        for name in ["fast", "accurate", "balanced"] {
            for room in of(ROOMS, &ROOMS[..2]) {
                assert_dim_emitters_are_seen(room, name, &[], 1);
            }
        }
    }

    #[test]
    fn indirect_light_of_dim_emitters_is_seen() {
        for name in of(&["fast", "accurate", "balanced"], &["fast", "accurate"]) {
            assert_dim_emitters_are_seen("contrast=1e9", name, &[], 3);
        }
    }

    #[test]
    fn a_sun_that_walls_shut_out_hides_no_emitter() {
        for brightness in [1e3, 1e6] {
            let mut scene = divided_room("contrast=1");
            scene.punctual_lights.push(PunctualLight {
                name: "sun".into(),
                light_to_world: DAffine3::from_quat(DQuat::from_rotation_x(-1.0)),
                shape: PunctualShape::Directional,
                intensity: Vec3::splat(brightness),
                range: None,
            });
            for name in of(&["fast", "accurate", "balanced"], &["fast", "accurate"]) {
                assert_scene_shows(&scene, "contrast=1", name, &[], 1);
            }
        }
    }

    #[test]
    fn every_source_of_candidates_sees_dim_emitters() {
        for source in ["uniform", "light-bvh", "hash-grid"] {
            let change = format!("direct.candidates={source}");
            assert_dim_emitters_are_seen("lamps=30,contrast=1e6", "accurate", &[&change], 1);
        }
        let change = [
            "indirect.secondary=world-reservoirs",
            "world_reservoirs.min_lights=0",
        ];
        assert_dim_emitters_are_seen("contrast=1e6", "accurate", &change, 3);
    }

    #[test]
    fn shadows_of_a_bright_emitter_have_the_light_of_dim_ones() {
        for name in of(&["fast", "accurate", "balanced"], &["fast", "accurate"]) {
            for contrast in of(&["1e9", "1e4"], &["1e9"]) {
                assert_umbra_is_right(contrast, name, false);
                assert_umbra_is_right(contrast, name, true);
            }
        }
    }
}

mod largest {
    use super::*;

    /// Asserts that the mean of the pixels beside the edge of the bright emitter's shadow is right. The 99 % interval must
    /// lie within ±1 % at rest, and within ±3 % for a single frame with a moving camera, which is noisier and needs more
    /// seeds.
    fn assert_mean_umbra_is_right(name: &str) {
        for (contrast, moving, seeds, most) in [
            ("1e4", false, 32, 0.01),
            ("1e9", false, 32, 0.01),
            ("1e9", true, 128, 0.03),
        ] {
            let ratio = |pairs: &Vec<(f64, f64)>| {
                let sum = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>();
                sum(|pair| pair.0) / sum(|pair| pair.1)
            };
            let runs = umbra(contrast, name, moving, seeds, 1 << 14);
            let estimate = Estimate::of(&runs.iter().map(ratio).collect::<Vec<_>>());
            let (bias, half) = (estimate.mean - 1.0, estimate.t_interval_half_width(0.99));
            let what = format!(
                "{name}, contrast {contrast}, moving {moving}: {:+.2} ± {:.2} %",
                100.0 * bias,
                100.0 * half
            );
            println!("{what}");
            assert!(bias.abs() + half < most, "{what}");
        }
    }

    #[test]
    fn fast_has_the_mean_light_of_dim_emitters_in_a_bright_ones_shadow() {
        assert_mean_umbra_is_right("fast");
    }

    #[test]
    fn balanced_has_the_mean_light_of_dim_emitters_in_a_bright_ones_shadow() {
        assert_mean_umbra_is_right("balanced");
    }

    #[test]
    fn accurate_has_the_mean_light_of_dim_emitters_in_a_bright_ones_shadow() {
        assert_mean_umbra_is_right("accurate");
    }
}
