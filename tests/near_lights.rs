//! Tests of light very close to a surface, or in a very narrow cone, seen from far away, against closed forms. The rounding
//! of f32 limits these cases: positions seen from a distance D are known to about 1e-7 · D.

mod support;

use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec3};
use headwater::render::presets::Preset;
use headwater::render::{Settings, View};
use headwater::scene::{Instance, Material, PunctualLight, PunctualShape, Scene};
use std::f64::consts::{FRAC_PI_2, PI};

const SIDE: u32 = 15;
const ALBEDO: f32 = 0.5;
/// Height of the camera above the floor, in scene units.
const DISTANCE: f64 = 4.0;

fn preset(name: &str) -> Settings {
    Preset::named(name).unwrap().settings().unwrap()
}

/// A floor at height 0 that reaches from −1 to 1 along x and z.
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

/// Adds a square emitter of radiance 1 that is centred at `at` and emits downwards.
fn add_emitter(scene: &mut Scene, at: DVec3, side: f64) {
    let emitter = Material {
        emission: Vec3::ONE,
        ..Material::lambert("lamp", Vec3::ZERO)
    };
    let corner = Vec3::new(-0.5, 0.0, -0.5);
    support::add(scene, &emitter, &support::quad(corner, Vec3::X, Vec3::Z));
    let mesh = scene.meshes.len() as u32 - 1;
    scene.instances.retain(|instance| instance.mesh != mesh);
    scene.instances.push(Instance {
        name: "lamp".into(),
        mesh,
        object_to_world: DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(side)),
    });
}

/// Rotates the whole scene and the camera of the view.
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

/// The rotations that scenes are tested with; the first is the identity.
fn all_turns() -> [DQuat; 3] {
    let euler = |x, y, z| DQuat::from_euler(EulerRot::XYZ, x, y, z);
    [
        DQuat::IDENTITY,
        euler(0.4, 1.1, -0.7),
        euler(2.3, -0.2, 0.9),
    ]
}

/// The first two of the rotations, or all of them with `--all`.
fn turns() -> Vec<DQuat> {
    let number = if support::takes_largest() { 3 } else { 2 };
    all_turns()[..number].to_vec()
}

/// A view of the floor up to `reach` from the origin, from a direction that is `slant` radians off the vertical.
fn view(reach: f64, slant: f64) -> View {
    let eye = DVec3::new(0.0, slant.cos(), slant.sin()) * DISTANCE;
    View {
        camera: support::look_at(eye, DVec3::ZERO, DVec3::X, 2.0 * (reach / DISTANCE).atan()),
        width: SIDE,
        height: SIDE,
        seed: 3,
        bounces: 1,
        jitter: false,
    }
}

/// The points of the floor that the centres of the pixels show, row by row.
fn points(view: &View, slant: f64) -> Vec<DVec3> {
    let reach = view.camera.projection.half_height();
    let (sine, cosine) = slant.sin_cos();
    let eye = DVec3::new(0.0, cosine, sine) * DISTANCE;
    let (forward, up) = (-eye / DISTANCE, DVec3::X);
    let right = forward.cross(up);
    let pixels = (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE));
    pixels
        .map(|(x, y)| {
            let across = |i: u32| (2.0 * (f64::from(i) + 0.5) / f64::from(SIDE) - 1.0) * reach;
            let way = forward + across(x) * right - across(y) * up;
            eye - way * (eye.y / way.y)
        })
        .collect()
}

/// The green channel of each pixel, row by row, in the mean of `samples` samples per pixel.
fn picture(scene: &Scene, view: &View, settings: &Settings, samples: u32) -> Vec<f64> {
    let (device, selection) = support::open_device(None);
    let rendered = support::render(&device, scene, selection.variant, view, settings, samples);
    support::assert_no_messages(&device);
    rendered.mean.iter().map(|pixel| pixel[1]).collect()
}

/// Asserts that the relative error of the sum of a picture is below `most`. It also prints the largest relative error of a
/// pixel, among those with at least a tenth of the brightest pixel's light.
fn assert_shows(
    what: &str,
    scene: &Scene,
    view: &View,
    settings: &Settings,
    samples: u32,
    expected: &[f64],
    most: f64,
) {
    let found = picture(scene, view, settings, samples);
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

/// Heights of lights above the floor, as a fraction of their distance from the camera; more of them with `--all`.
fn heights() -> &'static [f64] {
    if support::takes_largest() {
        &[0.0123, 1.1e-3, 5e-4, 1.3e-4, 2.5e-5, 7.7e-6, 2e-6]
    } else {
        // At the first one BSDF rays begin to find the emitter.
        &[5e-4, 2.5e-5, 2e-6]
    }
}

/// The maximum relative error of the sum of a picture, for a light at a relative height: 0.5 %, and 5 % below the height
/// down to which f32 is precise enough.
fn tolerance(height: f64) -> f64 {
    if height >= 2.5e-5 { 0.005 } else { 0.05 }
}

/// Names of the presets that are tested; more of them with `--all`.
fn presets() -> &'static [&'static str] {
    if support::takes_largest() {
        &["path-tracing", "fast", "balanced", "accurate", "s1"]
    } else {
        &["path-tracing", "accurate"]
    }
}

/// The radiance that a pixel of the floor shows under an irradiance.
fn reflected(irradiance: f64) -> f64 {
    irradiance * f64::from(ALBEDO) / PI
}

/// The irradiance of a floor point from a square emitter of radiance 1 above the floor, computed with a fine grid.
fn under_an_emitter(point: DVec3, at: DVec3, side: f64) -> f64 {
    const STEPS: u32 = 64;
    let coordinate = |i: u32| ((f64::from(i) + 0.5) / f64::from(STEPS) - 0.5) * side;
    let mut sum = 0.0;
    for i in 0..STEPS * STEPS {
        let toward = at + DVec3::new(coordinate(i % STEPS), 0.0, coordinate(i / STEPS)) - point;
        sum += toward.y * toward.y / toward.length_squared().powi(2);
    }
    sum * (side / f64::from(STEPS)).powi(2)
}

mod thorough {
    use super::*;

    /// Number of samples per pixel of a picture that an emitter lights.
    const SAMPLES: u32 = 256;

    #[test]
    fn points_of_light_close_to_a_floor_light_it_as_they_should() {
        for name in presets() {
            for part in heights() {
                for (turn, slant) in turns().into_iter().zip([0.0, 0.7, 1.2]) {
                    let height = part * DISTANCE;
                    let mut view = view(4.0 * height, slant);
                    let at = DVec3::Y * height;
                    let irradiance = |point: DVec3| {
                        let toward = at - point;
                        toward.y / toward.length().powi(3)
                    };
                    let points = points(&view, slant).into_iter();
                    let expected: Vec<f64> = points.map(|p| reflected(irradiance(p))).collect();
                    let mut scene = floor();
                    scene.punctual_lights = vec![punctual(PunctualShape::Point, at)];
                    turned(&mut scene, &mut view, turn);
                    let what = format!("{name}, point at {part:e} D, slant {slant}");
                    assert_shows(
                        &what,
                        &scene,
                        &view,
                        &preset(name),
                        4,
                        &expected,
                        tolerance(*part),
                    );
                }
            }
        }
    }

    /// Rays begin off the surface. The fault computes arriving light at the origin of the ray instead of at the surface
    /// point.
    #[test]
    fn light_that_is_taken_where_rays_begin_is_found() {
        if !support::takes_largest() {
            return;
        }
        let fault = (
            "restir/samples/light_sample.glsl",
            "arriving_radiance(value, shading_point.position,",
            "arriving_radiance(value, ray_start(shading_point),",
        );
        for test in [
            "points_of_light_close_to_a_floor_light_it_as_they_should",
            "small_emitters_close_to_a_floor_light_it_as_they_should",
        ] {
            let test = format!("thorough::{test}");
            // Without `--all` it tries few heights and presets, which is enough.
            let output = support::run_with_fault(&test, fault, |command| {
                command.env_remove("HEADWATER_TEST_ALL")
            });
            let said = support::said(&output);
            assert!(
                !output.status.success()
                    && said.contains("accurate, ")
                    && said.contains("panicked"),
                "{said}"
            );
        }
    }

    #[test]
    fn small_emitters_close_to_a_floor_light_it_as_they_should() {
        for name in presets() {
            for part in heights() {
                // One as large as its height is high is much noisier: 256 samples leave 0.4 % to the sum.
                for (size, samples) in [(0.2, SAMPLES), (1.0, 8 * SAMPLES)] {
                    for (turn, slant) in turns().into_iter().zip([0.0, 0.7, 1.2]) {
                        let height = part * DISTANCE;
                        let mut view = view((2.0 + size) * height, slant);
                        let at = DVec3::Y * height;
                        let eye = view.camera.camera_to_world.translation;
                        // The emitter's back hides a part of the floor.
                        let is_hidden = |point: DVec3| {
                            let seen = point + (eye - point) * (height / eye.y);
                            seen.x.abs().max(seen.z.abs()) < size * height / 2.0
                        };
                        let of_point = |point: DVec3| match is_hidden(point) {
                            true => 0.0,
                            false => reflected(under_an_emitter(point, at, size * height)),
                        };
                        let expected: Vec<f64> =
                            points(&view, slant).into_iter().map(of_point).collect();
                        let mut scene = floor();
                        add_emitter(&mut scene, at, size * height);
                        turned(&mut scene, &mut view, turn);
                        let what =
                            format!("{name}, emitter of {size} h at {part:e} D, slant {slant}");
                        assert_shows(
                            &what,
                            &scene,
                            &view,
                            &preset(name),
                            samples,
                            &expected,
                            tolerance(*part),
                        );
                    }
                }
            }
        }
    }

    /// A distant emitter stands on the floor, so low that its light grazes the floor.
    #[test]
    fn grazing_light_is_as_bright_as_it_should_be() {
        const AWAY: f64 = 10.0;
        for name in presets() {
            for (degrees, most) in [
                (89.0_f64, 0.005),
                (89.99, 0.005),
                (89.999, 0.005),
                (89.9999, 0.02),
            ] {
                for turn in turns() {
                    // In turned scenes the rounding of vertices and transforms tilts floors by up to 1e-6 radians.
                    if degrees > 89.99 && turn != DQuat::IDENTITY {
                        continue;
                    }
                    let low = AWAY / degrees.to_radians().tan();
                    let mut view = view(0.5, 0.9);
                    let irradiance = |point: DVec3| {
                        const STEPS: u32 = 64;
                        let coordinate = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
                        let mut sum = 0.0;
                        for i in 0..STEPS * STEPS {
                            let height = low * (1.0 + coordinate(i % STEPS));
                            let toward =
                                DVec3::new(-AWAY, height, coordinate(i / STEPS) - 0.5) - point;
                            sum += toward.y * -toward.x / toward.length_squared().powi(2);
                        }
                        sum * low / f64::from(STEPS).powi(2)
                    };
                    let points = points(&view, 0.9).into_iter();
                    let expected: Vec<f64> = points.map(|p| reflected(irradiance(p))).collect();
                    let mut scene = floor();
                    add_emitter(&mut scene, DVec3::ZERO, 1.0);
                    let upright = DAffine3::from_rotation_z(FRAC_PI_2);
                    let last = scene.instances.last_mut().unwrap();
                    last.object_to_world =
                        DAffine3::from_translation(DVec3::new(-AWAY, 1.5 * low, 0.0))
                            * DAffine3::from_scale(DVec3::new(1.0, low, 1.0))
                            * upright;
                    turned(&mut scene, &mut view, turn);
                    let what = format!("{name}, emitter at {degrees}°");
                    assert_shows(&what, &scene, &view, &preset(name), 256, &expected, most);
                }
            }
        }
    }

    /// The crease of a floor and a wall, seen from far away: light from inside must reach both surfaces up to the edge, and
    /// no light may pass the crease from behind.
    #[test]
    fn creases_seen_from_far_away_neither_leak_nor_darken() {
        for name in presets() {
            for degrees in [90.0_f64, 10.0] {
                let angle = degrees.to_radians();
                // Between the floor and the wall, whose pictures are the same up to a mirror.
                let middle = DVec3::new((angle / 2.0).cos(), (angle / 2.0).sin(), 0.0);
                // As long as the gap beside the edge is much wider than rounding.
                let reaches: &[f64] = match degrees {
                    90.0 => &[1e-2, 1e-3, 1e-4],
                    _ => &[1e-2, 1e-3],
                };
                for reach in reaches.iter().map(|part| part * DISTANCE) {
                    for (turn, leaks) in all_turns()
                        .into_iter()
                        .flat_map(|t| [(t, false), (t, true)])
                    {
                        let white = Material::lambert("white", Vec3::splat(ALBEDO));
                        let size = 2.0 * DISTANCE as f32;
                        let wide = Vec3::Z * size;
                        let along = Vec3::new(angle.cos() as f32, angle.sin() as f32, 0.0) * size;
                        let mut scene = support::scene_of(&[
                            (
                                white.clone(),
                                support::quad(-wide / 2.0, wide, Vec3::X * size),
                            ),
                            (white, support::quad(-wide / 2.0, along, wide)),
                        ]);
                        let light = match leaks {
                            false => 0.1 * DISTANCE * middle,
                            true => 0.1 * DISTANCE * DVec3::new(-0.3, 1.0, 0.2),
                        };
                        scene.punctual_lights = vec![punctual(PunctualShape::Point, light)];
                        // No pixel's centre is on the edge.
                        let target = 0.3 * reach / f64::from(SIDE) * middle.cross(DVec3::Z);
                        let eye = DISTANCE * middle;
                        let fov = 2.0 * (reach / DISTANCE).atan();
                        let mut view = View {
                            camera: support::look_at(eye, target, DVec3::Z, fov),
                            ..view(reach, 0.0)
                        };
                        let forward = (target - eye).normalize();
                        let right = forward.cross(DVec3::Z).normalize();
                        let up = right.cross(forward);
                        let wall_normal = DVec3::new(angle.sin(), -angle.cos(), 0.0);
                        let expected: Vec<f64> = (0..SIDE * SIDE)
                            .map(|i| {
                                let across = |i: u32| {
                                    (2.0 * (f64::from(i) + 0.5) / f64::from(SIDE) - 1.0) * reach
                                        / DISTANCE
                                };
                                let way =
                                    forward + across(i % SIDE) * right - across(i / SIDE) * up;
                                let (normal, t) = [DVec3::Y, wall_normal]
                                    .map(|normal| (normal, -normal.dot(eye) / normal.dot(way)))
                                    .into_iter()
                                    .min_by(|a, b| a.1.total_cmp(&b.1))
                                    .unwrap();
                                let toward = light - (eye + way * t);
                                let light = normal.dot(toward) / toward.length().powi(3);
                                if leaks { 0.0 } else { reflected(light) }
                            })
                            .collect();
                        turned(&mut scene, &mut view, turn);
                        let what = format!("{name}, {degrees}°, {reach:e}, leaks {leaks}");
                        let seen = picture(&scene, &view, &preset(name), 4);
                        let worst = seen
                            .iter()
                            .zip(&expected)
                            .map(|(seen, expected)| (seen - expected).abs())
                            .fold(0.0, f64::max);
                        let brightest = expected.iter().copied().fold(0.0, f64::max);
                        println!("{what}: off by {worst:.2e} of {brightest:.3}");
                        assert!(worst <= 0.01 * brightest, "{what}: {worst} of {brightest}");
                    }
                }
            }
        }
    }

    #[test]
    fn spots_of_any_angle_are_cones() {
        // One for each format of reservoirs.
        for name in ["path-tracing", "accurate", "s1"] {
            for outer in [1e-5, 1e-3, 0.5, FRAC_PI_2] {
                for inner in [0.0, 0.5 * outer, outer] {
                    let at = DVec3::Y * DISTANCE;
                    let mut view = view(DISTANCE * (1.3 * outer).min(1.0).tan(), 0.0);
                    let part = |point: DVec3| {
                        let toward = at - point;
                        let angle = (toward.x.hypot(toward.z)).atan2(toward.y);
                        let square = |angle: f64| (angle / 2.0).sin().powi(2);
                        let between = (square(outer) - square(inner)).max(1e-30);
                        let fraction = ((square(outer) - square(angle)) / between).clamp(0.0, 1.0);
                        fraction * fraction * toward.y / toward.length().powi(3)
                    };
                    let points = points(&view, 0.0).into_iter();
                    let expected: Vec<f64> = points.map(|p| reflected(part(p))).collect();
                    let mut scene = floor();
                    for position in &mut scene.meshes[0].positions {
                        *position *= 20.0;
                    }
                    scene.punctual_lights =
                        vec![punctual(PunctualShape::Spot { inner, outer }, at)];
                    turned(&mut scene, &mut view, turns()[1]);
                    let what = format!("{name}, spot of {outer} and {inner} radians");
                    assert_shows(&what, &scene, &view, &preset(name), 4, &expected, 0.005);
                }
            }
        }
    }
}
