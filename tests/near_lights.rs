//! Light in a very narrow cone, against closed forms.

mod support;

use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec3};
use headwater::render::presets::Preset;
use headwater::render::{Settings, View};
use headwater::scene::{Material, PunctualLight, PunctualShape, Scene};
use std::f64::consts::{FRAC_PI_2, PI};

const SIDE: u32 = 15;
const ALBEDO: f32 = 0.5;
/// Height of the camera above the floor.
const DISTANCE: f64 = 4.0;

fn preset(name: &str) -> Settings {
    Preset::named(name).unwrap().settings().unwrap()
}

/// A floor at height 0 that reaches from −1 to 1.
fn floor() -> Scene {
    let white = Material::lambert("floor", Vec3::splat(ALBEDO));
    let corner = Vec3::new(-1.0, 0.0, -1.0);
    support::scene_of(&[(white, support::quad(corner, Vec3::Z * 2.0, Vec3::X * 2.0))])
}

fn punctual(shape: PunctualShape, at: DVec3) -> PunctualLight {
    PunctualLight {
        name: "lamp".into(),
        light_to_world: DAffine3::from_translation(at) * DAffine3::from_rotation_x(-FRAC_PI_2),
        shape,
        intensity: Vec3::ONE,
        range: None,
    }
}

/// The whole scene and what looks at it, turned.
fn turned(scene: &mut Scene, view: &mut View, turn: DQuat) {
    let turn = DAffine3::from_quat(turn);
    for instance in &mut scene.instances {
        instance.object_to_world = turn * instance.object_to_world;
    }
    for light in &mut scene.punctual_lights {
        light.light_to_world = turn * light.light_to_world;
    }
    view.camera.camera_to_world = turn * view.camera.camera_to_world;
}

/// A view from above of so much of the floor around the origin, to each side.
fn view(reach: f64) -> View {
    let eye = DVec3::Y * DISTANCE;
    View {
        camera: support::look_at(eye, DVec3::ZERO, DVec3::X, 2.0 * (reach / DISTANCE).atan()),
        width: SIDE,
        height: SIDE,
        seed: 3,
        bounces: 1,
        jitter: false,
    }
}

/// The points of the floor in the centres of the pixels.
fn points(view: &View) -> impl Iterator<Item = DVec3> {
    let reach = (view.camera.vertical_fov / 2.0).tan() * DISTANCE;
    let across = move |i: u32| (2.0 * (f64::from(i) + 0.5) / f64::from(SIDE) - 1.0) * reach;
    let pixels = (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE));
    // Up in the picture is x, and right is z.
    pixels.map(move |(x, y)| DVec3::new(-across(y), 0.0, across(x)))
}

/// A picture's error is that of its sum, relative; the largest of a pixel, of those with a tenth of the brightest one's light, is
/// printed beside it.
fn assert_shows(
    what: &str,
    scene: &Scene,
    view: &View,
    settings: &Settings,
    samples: u32,
    expected: &[f64],
    most: f64,
) {
    let (device, selection) = support::open_device(None);
    let rendered = support::render(&device, scene, selection.variant, view, settings, samples);
    support::assert_no_messages(&device);
    let found: Vec<f64> = rendered.mean.iter().map(|pixel| pixel[1]).collect();
    let error = found.iter().sum::<f64>() / expected.iter().sum::<f64>() - 1.0;
    let brightest = expected.iter().copied().fold(0.0, f64::max);
    let pairs = found
        .iter()
        .zip(expected)
        .filter(|(_, e)| **e > 0.1 * brightest);
    let worst = pairs.map(|(f, e)| (f / e - 1.0).abs()).fold(0.0, f64::max);
    let what = format!(
        "{what}: error {:+.3} %, of a pixel up to {:.3} %",
        100.0 * error,
        100.0 * worst
    );
    println!("{what}");
    assert!(error.abs() < most, "{what}");
}

/// One for each format of reservoirs; all with `--all`.
fn presets() -> &'static [&'static str] {
    if support::takes_largest() {
        &["path-tracing", "fast", "balanced", "accurate", "s1"]
    } else {
        &["path-tracing", "accurate", "s1"]
    }
}

/// The radiance with which a pixel shows an irradiance.
fn reflected(irradiance: f64) -> f64 {
    irradiance * f64::from(ALBEDO) / PI
}

mod thorough {
    use super::*;

    #[test]
    fn spots_of_any_angle_are_cones() {
        for name in presets() {
            for outer in [1e-5, 1e-3, 0.5, FRAC_PI_2] {
                for inner in [0.0, 0.5 * outer, outer] {
                    let at = DVec3::Y * DISTANCE;
                    let mut view = view(DISTANCE * (1.3 * outer).min(1.0).tan());
                    let part = |point: DVec3| {
                        let toward = at - point;
                        let angle = (toward.x.hypot(toward.z)).atan2(toward.y);
                        let square = |angle: f64| (angle / 2.0).sin().powi(2);
                        let between = (square(outer) - square(inner)).max(1e-30);
                        let share = ((square(outer) - square(angle)) / between).clamp(0.0, 1.0);
                        share * share * toward.y / toward.length().powi(3)
                    };
                    let expected: Vec<f64> = points(&view).map(|p| reflected(part(p))).collect();
                    let mut scene = floor();
                    for position in &mut scene.meshes[0].positions {
                        *position *= 20.0;
                    }
                    scene.punctual_lights =
                        vec![punctual(PunctualShape::Spot { inner, outer }, at)];
                    let turn = DQuat::from_euler(EulerRot::XYZ, 0.4, 1.1, -0.7);
                    turned(&mut scene, &mut view, turn);
                    let what = format!("{name}, spot of {outer} and {inner} radians");
                    assert_shows(&what, &scene, &view, &preset(name), 4, &expected, 0.005);
                }
            }
        }
    }
}
