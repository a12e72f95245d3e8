//! Tests of lights together: direct and indirect light, rendered separately, add up to all light, and lights without power
//! change nothing.

use super::{environment, floor, from_above, picture, preset, punctual};
use glam::{DVec3, Vec3};
use headwater::procedural;
use headwater::render::View;
use headwater::render::settings::{DirectMode, IndirectMode, Integrator};
use headwater::scene::PunctualShape;
use headwater::shader_interface::Tracer;

/// The maximum relative difference. It is small, because both sides have the same random numbers and differ by rounding
/// only.
const TOLERANCE: f64 = 1e-4;

#[test]
fn direct_and_indirect_light_alone_add_up_to_all() {
    let settings = [("finish", "metal"), ("roughness", "0")]
        .map(|(key, value)| (key.to_owned(), value.to_owned()));
    let cornell = procedural::generate("cornell", &settings).unwrap();
    let view = |bounces| View {
        camera: cornell.cameras[0].clone(),
        width: 24,
        height: 24,
        seed: 1,
        bounces,
        jitter: false,
    };
    for name in ["path-tracing", "accurate"] {
        let all = preset(name);
        let mut indirect = all.clone();
        indirect.direct.mode = DirectMode::Off;
        let mut direct = all.clone();
        let mut bounces = 4;
        match all.integrator {
            Integrator::PathTracing => bounces = 1,
            Integrator::Restir => direct.indirect.mode = IndirectMode::Off,
        }
        let pictures = [(&all, 4), (&indirect, 4), (&direct, bounces), (&all, 0)].map(
            |(settings, bounces)| {
                picture(&cornell, &view(bounces), settings, Tracer::ComputeBvh, 3).unwrap()
            },
        );
        let [all, indirect, direct, emitted] = pictures;
        let mut light = [0.0; 2];
        for pixel in 0..all.len() {
            for channel in 0..3 {
                let [all, indirect, direct, emitted] =
                    [&all, &indirect, &direct, &emitted].map(|picture| picture[pixel][channel]);
                let off = all - (indirect + direct - emitted);
                assert!(
                    off.abs() <= TOLERANCE * all.max(1.0),
                    "{name}: pixel {pixel} is off by {off}"
                );
                light[0] += direct - emitted;
                light[1] += indirect - emitted;
            }
        }
        assert!(light.iter().all(|sum| *sum > 1.0), "{name}: {light:?}");
    }
}

/// A single light has no noise on a floor. Lights without power beside it add none: no sample is wasted on them.
#[test]
fn lights_without_power_add_no_noise() {
    let lamp = |y: f64, intensity: f32| {
        let mut light = punctual(PunctualShape::Point, DVec3::Y * y, DVec3::NEG_Y);
        light.intensity = Vec3::splat(intensity);
        light
    };
    let mut alone = floor();
    alone.punctual_lights = vec![lamp(2.0, 10.0)];
    let mut beside = alone.clone();
    let mut sun = lamp(1.0, 0.0);
    sun.shape = PunctualShape::Directional;
    beside.punctual_lights.insert(0, lamp(1.0, 0.0));
    beside.punctual_lights.push(sun);
    beside.environment = Some(environment(4, 2, |_, _| Vec3::ZERO));
    for name in ["path-tracing", "balanced"] {
        let settings = preset(name);
        let one_sample = |scene, seed| {
            picture(
                scene,
                &from_above(1, seed),
                &settings,
                Tracer::ComputeBvh,
                1,
            )
            .unwrap()
        };
        let expected = one_sample(&alone, 1);
        for seed in 1..4 {
            let found = one_sample(&beside, seed);
            for (found, expected) in found.iter().zip(&expected) {
                let off = (found[0] - expected[0]).abs();
                assert!(off < 1e-4 * expected[0], "{name}: {found:?} {expected:?}");
            }
        }
    }
}
