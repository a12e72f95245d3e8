//! Tests that reuse over time is unbiased where something moves: the mean over many seeds against path tracing of the same
//! moment.

use crate::{playroom, support};
use glam::{DAffine3, DQuat, DVec3};
use headwater::device_scene::GpuScene;
use headwater::metrics::statistics::Estimate;
use headwater::procedural;
use headwater::render::presets::Preset;
use headwater::render::settings::{Candidates, ReuseMode, Secondary};
use headwater::render::{Renderer, Settings, View};
use headwater::scene::motion::tracks::{Interpolation, Track};
use headwater::scene::motion::{AnimatedTransform, Node, Transform};
use headwater::scene::{Instance, Motion, Scene};
use headwater::shader_interface::{Format, Tracer};
use std::sync::Arc;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;
const FRAMES_A_SECOND: f64 = 4.0;
/// Number of runs, each with another seed.
const SEEDS: u32 = 96;
/// Number of runs where there is less light, so that the noise is larger.
const MANY_SEEDS: u32 = 600;
/// Indices of the compared frames: the first frame after the sign went off, and the first frame after it went on.
const LOOKED_AT: [u32; 2] = [1, 2];
/// Number of samples per pixel of the path-traced moments.
const SAMPLES: u32 = 1152;
/// The probability that a correct mean lies within its confidence interval.
const CONFIDENCE: f64 = 0.999;
/// The maximum half-width of the confidence interval, as a fraction of the mean; with a wider one, the comparison would
/// prove nothing.
const MAX_HALF_WIDTH: f64 = 0.01;

fn view(scene: &Scene, bounces: u32) -> View {
    View {
        camera: scene.cameras[0].clone(),
        width: WIDTH,
        height: HEIGHT,
        seed: 0,
        bounces,
        jitter: false,
    }
}

fn mean(picture: &[[f32; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|c| {
        let sum: f64 = picture.iter().map(|p| f64::from(p[c])).sum();
        sum / picture.len() as f64
    })
}

/// For each channel, the mean over the picture at a time, by path tracing: of light that was scattered at least once (with
/// its error), and of emission that the camera sees.
fn moment(scene: &Scene, time: f64, bounces: u32) -> ([Estimate; 3], [f64; 3]) {
    let still = scene.pose_at(time).unwrap();
    let (device, selection) = support::open_device(None);
    let render = |bounces, samples| {
        let view = view(&still, bounces);
        let settings = Settings::default();
        support::render(
            &device,
            &still,
            selection.variant,
            &view,
            &settings,
            samples,
        )
    };
    let (dark, lit) = (render(0, 1), render(bounces, SAMPLES));
    let pixels = f64::from(WIDTH * HEIGHT);
    let sum = |c: usize, of: &[[f64; 3]]| of.iter().map(|p| p[c]).sum::<f64>() / pixels;
    let emission = [0, 1, 2].map(|c| sum(c, &dark.mean));
    let lit = [0, 1, 2].map(|c| Estimate {
        mean: sum(c, &lit.mean) - emission[c],
        standard_error: (sum(c, &lit.error_squared) / pixels).sqrt(),
        samples: u64::from(SAMPLES) * u64::from(WIDTH * HEIGHT),
    });
    support::assert_no_messages(&device);
    (lit, emission)
}

/// Renders direct light with every seed, and compares the mean with path tracing.
fn check(name: &str, scene: Scene, tracer: Option<Tracer>, change: fn(&mut Settings)) {
    check_at(1, SEEDS, name, scene, tracer, change);
}

/// Renders light of up to `bounces` scattering events with `seeds` seeds, and compares the mean with path tracing.
pub fn check_at(
    bounces: u32,
    seeds: u32,
    name: &str,
    mut scene: Scene,
    tracer: Option<Tracer>,
    change: fn(&mut Settings),
) {
    // Highlights are most of the noise, and none of what is looked for.
    for material in &mut scene.materials {
        (material.metallic, material.specular) = (0.0, 0.0);
    }
    let scene = &scene;
    let variant = match tracer {
        None => None,
        Some(tracer) => match support::variants(tracer).first() {
            Some(variant) => Some(*variant),
            None => return,
        },
    };
    let (device, selection) = support::open_device(variant);
    let mut settings = Preset::named("accurate").unwrap().settings().unwrap();
    change(&mut settings);
    let view = view(scene, bounces);
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, scene, origin, selection.variant).unwrap();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, &settings).unwrap();
    let time = |frame: u32| f64::from(frame) / FRAMES_A_SECOND;
    let mut means = LOOKED_AT.map(|_| Vec::new());
    for seed in 0..seeds {
        renderer.restart(seed).unwrap();
        for frame in 0..=LOOKED_AT[LOOKED_AT.len() - 1] {
            renderer.set_time(time(frame));
            renderer.set_camera(&scene.camera_at(0, time(frame)).unwrap());
            renderer.single_frame(frame).unwrap();
            if let Some(which) = LOOKED_AT.iter().position(|looked_at| *looked_at == frame) {
                means[which].push(mean(&renderer.frame_radiance().unwrap()));
            }
        }
    }
    assert_eq!(renderer.rejected().unwrap(), 0);
    support::assert_no_messages(&device);
    for (frame, means) in LOOKED_AT.iter().zip(means) {
        let (expected, emission) = moment(scene, time(*frame), bounces);
        for c in 0..3 {
            let lit: Vec<f64> = means.iter().map(|mean| mean[c] - emission[c]).collect();
            let difference = Estimate::of(&lit).minus(&expected[c]);
            let bias = difference.mean / expected[c].mean;
            let half_width = difference.t_interval_half_width(CONFIDENCE) / expected[c].mean;
            let text = format!(
                "{name}, frame {frame}, channel {c}: {:+.3} % ± {:.3} %",
                100.0 * bias,
                100.0 * half_width
            );
            println!("{text}");
            assert!(half_width <= MAX_HALF_WIDTH, "{text}: too noisy to tell");
            assert!(bias.abs() <= half_width, "{text}");
        }
    }
}

/// Switches to temporal reuse alone. Spatial reuse is left out, because samples that neighbours share make the mean of a
/// picture less certain.
pub fn temporal(settings: &mut Settings) {
    settings.direct.resampling.reuse = ReuseMode::Temporal;
    settings.direct.resampling.light_samples = 24;
    settings.indirect.resampling.reuse = ReuseMode::Temporal;
}

/// A scene in which one instance is moved or scaled between frames 0 and 1.
fn with_a_step(
    mut scene: Scene,
    instance: usize,
    translations: [DVec3; 2],
    scales: [DVec3; 2],
) -> Scene {
    let step = |values: [DVec3; 2]| {
        Some(Track {
            interpolation: Interpolation::Step,
            times: vec![0.0, 1.0 / FRAMES_A_SECOND],
            values: values.to_vec(),
        })
    };
    let mut moving = AnimatedTransform::still(translations[0], DQuat::IDENTITY, scales[0]);
    moving.translation.track = step(translations);
    moving.scale.track = step(scales);
    scene.instances[instance].object_to_world =
        DAffine3::from_scale_rotation_translation(scales[0], DQuat::IDENTITY, translations[0]);
    let mut nodes = vec![None; scene.instances.len()];
    nodes[instance] = Some(0);
    scene.motion = Some(Motion {
        nodes: vec![Node {
            parent: None,
            transform: Transform::Moving(Box::new(moving)),
        }],
        instances: nodes,
        cameras: vec![None; scene.cameras.len()],
        lights: vec![],
        emission: Vec::new(),
        deformations: Vec::new(),
    });
    scene
}

/// Runs a test of this file again in a new process with a fault in temporal reuse, and asserts that it fails.
pub fn assert_seen(test: &str, file: &str, right: &str, wrong: &str) {
    let fault = (file, right, wrong);
    let output = support::run_with_fault(test, fault, |command| command.arg("--nocapture"));
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    let (said, failed) = (text(&output.stdout), text(&output.stderr));
    println!("{said}{failed}");
    // It ran, and came to another mean, which is no matter of noise.
    assert!(!output.status.success() && said.contains("channel 0:"));
    assert!(failed.contains("panicked") && !failed.contains("too noisy to tell"));
}

#[test]
fn an_area_that_is_left_out_is_seen() {
    assert_seen(
        "bias::thorough::indirect_light_from_a_floor_that_grows",
        "restir/samples/path_sample.glsl",
        "return ratio(measure.x, old_measure.x) * ",
        "return ",
    );
}

mod thorough {
    use super::*;

    #[test]
    fn a_moving_camera() {
        check("camera", playroom(&["camera"], 4.0), None, temporal);
    }

    #[test]
    fn moving_objects() {
        check("object", playroom(&["object"], 2.0), None, temporal);
    }

    #[test]
    fn moving_and_growing_lights() {
        check("light", playroom(&["light"], 2.0), None, temporal);
    }

    #[test]
    fn lights_that_go_on_and_off() {
        check("toggle", playroom(&["toggle"], 1.0), None, temporal);
    }

    #[test]
    fn moving_lights_in_the_light_bvh() {
        let emitters = playroom(&["light", "toggle"], 2.0);
        check("light BVH", emitters, None, |settings| {
            temporal(settings);
            settings.direct.resampling.candidates = Candidates::LightBvh;
        });
    }

    /// The cells are small, because samples that pixels share make the mean of a picture less certain.
    #[test]
    fn moving_lights_in_the_hash_grid() {
        let emitters = playroom(&["camera", "light", "toggle"], 2.0);
        check("hash grid", emitters, None, |settings| {
            temporal(settings);
            settings.direct.resampling.candidates = Candidates::HashGrid;
            (settings.hash_grid.cell, settings.hash_grid.reservoirs) = (4, 2);
        });
    }

    #[test]
    fn indirect_light_of_moving_objects_with_full_reservoirs() {
        let objects = playroom(&["camera", "object"], 2.0);
        check_at(3, SEEDS, "indirect, objects", objects, None, |settings| {
            temporal(settings);
            settings.reservoirs.format = Format::Full;
        });
    }

    #[test]
    fn indirect_light_of_emitters_that_move_and_go_on_and_off() {
        let emitters = playroom(&["light", "toggle"], 1.0);
        check_at(3, SEEDS, "indirect, emitters", emitters, None, temporal);
    }

    #[test]
    fn indirect_light_that_world_reservoirs_find_where_emitters_move() {
        let emitters = playroom(&["camera", "light", "toggle"], 1.0);
        check_at(3, SEEDS, "world reservoirs", emitters, None, |settings| {
            temporal(settings);
            settings.indirect.secondary = Secondary::WorldReservoirs;
            settings.world_reservoirs.min_lights = 0;
            settings.world_reservoirs.depth = 2;
        });
    }

    #[test]
    fn indirect_light_where_everything_moves_with_ray_query_and_full_reservoirs() {
        let all = playroom(&["camera", "object", "light", "toggle"], 1.0);
        let tracer = Some(Tracer::RayQuery);
        check_at(3, SEEDS, "indirect, all", all, tracer, |settings| {
            temporal(settings);
            settings.reservoirs.format = Format::Full;
        });
    }

    /// A board moves between the emitter and the surfaces that it lit, so that paths of the last frame end in its shadow.
    #[test]
    fn indirect_light_that_a_board_cuts_off() {
        let mut scene = procedural::generate("cornell", &[]).unwrap();
        let block = scene.instances.last().unwrap().clone();
        let board = scene.instances.len();
        scene.instances.push(Instance {
            name: "board".into(),
            ..block
        });
        let (outside, inside) = (DVec3::new(5.0, 1.4, 0.0), DVec3::new(0.0, 1.4, 0.0));
        let size = DVec3::new(1.0, 0.02, 1.0);
        let scene = with_a_step(scene, board, [outside, inside], [size; 2]);
        check_at(2, MANY_SEEDS, "board", scene, None, temporal);
    }

    /// The floor grows between two frames, and with it the area that a sample on the floor stands for.
    #[test]
    fn indirect_light_from_a_floor_that_grows() {
        let scales = [DVec3::ONE, DVec3::new(1.6, 1.0, 1.6)];
        let scene = procedural::generate("cornell", &[]).unwrap();
        let scene = with_a_step(scene, 0, [DVec3::ZERO; 2], scales);
        check_at(2, SEEDS, "floor", scene, None, temporal);
    }

    #[test]
    fn what_has_come_behind_the_second_vertex_is_seen_if_it_is_not_looked_for() {
        assert_seen(
            "bias::thorough::indirect_light_that_a_board_cuts_off",
            "restir/temporal.glsl",
            "MOVES ? segment_count(value) : 1u",
            "1u",
        );
    }

    #[test]
    fn paths_that_are_kept_though_what_lies_behind_may_have_changed_are_seen() {
        assert_seen(
            "bias::thorough::indirect_light_of_emitters_that_move_and_go_on_and_off",
            "restir/samples/path_sample.glsl",
            "if (value.kind == PATH_ONWARD) return 0.0;",
            "if (value.kind == PATH_ONWARD) return 1.0;",
        );
    }

    #[test]
    fn everything_at_once_with_ray_query_and_full_reservoirs() {
        let all = playroom(&["camera", "object", "light", "toggle"], 1.0);
        check("all", all, Some(Tracer::RayQuery), |settings| {
            settings.reservoirs.format = Format::Full;
            settings.direct.resampling.light_samples = 24;
        });
    }
}
