//! Tests of shader functions: directions and texture coordinates of the environment, its radiance, and the density of its
//! samples.

use crate::{Function, floats, number, vector};
use glam::{DVec2, DVec3, Vec3};
use headwater::device_scene::Units;
use headwater::device_scene::environment::EnvironmentTexels;
use headwater::device_scene::lights::{Lights, gpu_lights};
use headwater::metrics::statistics::chi_square_p_value;
use headwater::scene::{Environment, Scene};
use std::f64::consts::{PI, TAU};

const WIDTH: u32 = 24;
const HEIGHT: u32 = 11;

/// An environment in which every texel is different and some are black, rotated by 30 degrees.
fn uneven() -> Environment {
    let texel = |index: u32| match (index * 7919) % 13 {
        0..5 => Vec3::ZERO,
        k => Vec3::new(1.0, 0.5, 2.0) * 1.5_f32.powi(k as i32),
    };
    Environment {
        name: "uneven".into(),
        width: WIDTH,
        height: HEIGHT,
        texels: (0..WIDTH * HEIGHT).map(texel).collect(),
        rotation: 30.0,
        intensity: 0.5,
    }
}

/// The units of a scene with this environment, its texels in these units, and its lights.
fn uploaded(environment: Environment) -> (Units, EnvironmentTexels, Lights) {
    let scene = Scene {
        environment: Some(environment.clone()),
        ..Scene::default()
    };
    let units = Units::of(&scene, DVec3::ZERO);
    let texels = EnvironmentTexels::of(&environment, &units);
    (units, texels, gpu_lights(&scene, &units))
}

/// The radiance (RGB) of the environment in a direction, computed in f64.
fn radiance(environment: &Environment, direction: DVec3) -> DVec3 {
    let turn = -environment.rotation.to_radians();
    let (x, z) = (
        turn.cos() * direction.x + turn.sin() * direction.z,
        turn.cos() * direction.z - turn.sin() * direction.x,
    );
    let at = DVec2::new(
        0.5 + x.atan2(-z) / TAU,
        direction.y.clamp(-1.0, 1.0).acos() / PI,
    );
    let at = at * DVec2::new(f64::from(environment.width), f64::from(environment.height)) - 0.5;
    let texel = |dx: f64, dy: f64| {
        let column = (at.x.floor() + dx).rem_euclid(f64::from(environment.width)) as u32;
        let row = (at.y.floor() + dy).clamp(0.0, f64::from(environment.height - 1)) as u32;
        environment.texels[(row * environment.width + column) as usize].as_dvec3()
    };
    let part = at - at.floor();
    let top = texel(0.0, 0.0).lerp(texel(1.0, 0.0), part.x);
    let bottom = texel(0.0, 1.0).lerp(texel(1.0, 1.0), part.x);
    top.lerp(bottom, part.y) * f64::from(environment.intensity)
}

/// Unit directions over the sphere: a spiral, the axes, and some near the poles and near the seam of the image.
fn directions() -> Vec<DVec3> {
    let spiral = (0..4000).map(|i| {
        let y = 1.0 - (f64::from(i) + 0.5) / 2000.0;
        let around = 2.399_963 * f64::from(i);
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * around.cos(), y, r * around.sin())
    });
    let mut all: Vec<DVec3> = spiral.collect();
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        all.extend([axis, -axis]);
        all.extend(
            [DVec3::new(1e-5, 1.0, 2e-5), DVec3::new(1e-6, 0.3, 1.0)]
                .map(|d| d * axis.y.mul_add(2.0, -1.0)),
        );
    }
    all.into_iter().map(DVec3::normalize).collect()
}

fn seen(fault: Option<(&'static str, &'static str, &'static str)>) -> f64 {
    let environment = uneven();
    let (units, texels, _) = uploaded(environment.clone());
    let function = Function {
        includes: &["lights/kinds/environment.glsl"],
        body: "vec2 uv = environment_uv(uintBitsToFloat(a.xyz));
            float sine;
            x.xyz = floatBitsToUint(environment_radiance(uv));
            y.xyz = floatBitsToUint(environment_direction(uv, sine));",
        environment: texels,
        fault,
        ..Function::default()
    };
    let directions = directions();
    let inputs: Vec<[u32; 8]> = (directions.iter())
        .map(|d| floats(&d.as_vec3().to_array()))
        .collect();
    let brightest = f64::from(environment.brightest());
    let answers = function.run(&inputs);
    let off = directions.iter().zip(&answers).map(|(direction, words)| {
        let light = vector(words) * units.radiance - radiance(&environment, *direction);
        let back = vector(&words[4..]) - *direction;
        // At a pole every longitude is the same direction.
        let light = if direction.x == 0.0 && direction.z == 0.0 {
            DVec3::ZERO
        } else {
            light
        };
        (light.abs().max_element() / brightest).max(back.length())
    });
    off.fold(0.0, f64::max)
}

#[test]
fn what_is_seen_in_a_direction_is_what_the_image_has_there() {
    let off = seen(None);
    assert!(off < 2e-5, "{off}");
}

#[test]
fn an_environment_that_is_turned_the_wrong_way_is_found() {
    let fault = (
        "lights/kinds/environment.glsl",
        "turn.x * direction.x - turn.y * direction.z",
        "turn.x * direction.x + turn.y * direction.z",
    );
    assert!(seen(Some(fault)) > 0.01);
}

/// Texels must be drawn as often as their density says, the density must integrate to 1 over the sphere, and every direction
/// from which light comes must be drawn.
#[test]
fn points_are_drawn_by_their_density() {
    const COUNT: u32 = 1 << 18;
    let environment = uneven();
    let (_, texels, lights) = uploaded(environment.clone());
    let function = Function {
        includes: &["lights/light_point.glsl"],
        body: "Random random = random_start(a.x, 1u, 2u);
            uvec4 bits = random_bits(random);
            LightPoint p = draw_point(pick_light(0u, scene.at.light_count, bits.xy), bits);
            float sine;
            vec3 direction = environment_direction(texel_corner(p.index) + p.uv, sine);
            float pdf = pdf_own_measure(p, direction, light_probability(p));
            LightPoint same = environment_point(direction);
            x = uvec4(p.kind, p.index, floatBitsToUint(pdf), same.index);
            y.xy = floatBitsToUint(p.uv);",
        environment: texels,
        lights,
        ..Function::default()
    };
    let inputs: Vec<[u32; 8]> = (0..COUNT).map(|i| [i, 0, 0, 0, 0, 0, 0, 0]).collect();
    let cell = TAU / f64::from(WIDTH) * PI / f64::from(HEIGHT);
    let mut observed = vec![0_u64; (WIDTH * HEIGHT) as usize];
    let mut probability = vec![0.0; (WIDTH * HEIGHT) as usize];
    let (mut quarters, mut inverse, mut elsewhere) = ([0_u64; 4], 0.0, 0);
    for words in function.run(&inputs) {
        assert_eq!(words[0], headwater::shader_interface::LIGHT_ENVIRONMENT);
        let (texel, uv) = (words[1], [number(words[4]), number(words[5])]);
        let row = f64::from(texel / WIDTH);
        let sine = (PI * (row + uv[1]) / f64::from(HEIGHT)).sin();
        let pdf = number(words[2]);
        observed[texel as usize] += 1;
        probability[texel as usize] = pdf * sine * cell;
        quarters[usize::from(uv[0] >= 0.5) + 2 * usize::from(uv[1] >= 0.5)] += 1;
        inverse += 1.0 / pdf;
        // By rounding a direction may lie beyond the edge.
        elsewhere += u32::from(words[3] != texel);
    }
    let drawn = (0..observed.len()).filter(|i| observed[*i] > 0);
    let drawn: Vec<usize> = drawn.collect();
    // The uniform fraction alone would draw each of them dozens of times.
    assert!(drawn.len() as u32 > WIDTH * (HEIGHT - 1));
    let sum: f64 = probability.iter().sum();
    assert!((sum - 1.0).abs() < 1e-3, "{sum}");
    let of = |values: &[u64]| drawn.iter().map(|i| values[*i]).collect::<Vec<_>>();
    let expected: Vec<f64> = (drawn.iter())
        .map(|i| probability[*i] / sum * f64::from(COUNT))
        .collect();
    let p = chi_square_p_value(&of(&observed), &expected);
    assert!(p > 1e-4, "{p}");
    let p = chi_square_p_value(&quarters, &[f64::from(COUNT) / 4.0; 4]);
    assert!(p > 1e-4, "{quarters:?}");
    // ∫ dω, of which the uniform fraction bounds each term by 4π/0.02.
    let sphere = inverse / f64::from(COUNT) / (2.0 * TAU);
    assert!(
        (sphere - 1.0).abs() < 5.0 * 7.0 / f64::from(COUNT).sqrt(),
        "{sphere}"
    );
    assert!(elsewhere < COUNT / 1000, "{elsewhere}");
}
