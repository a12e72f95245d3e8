//! Tests of shader functions: the frequency with which each light is drawn, points on lights, and their densities.

use crate::{Function, number, vector};
use glam::DVec3;
use headwater::device_scene::Units;
use headwater::device_scene::lights::{Lights, gpu_lights};
use headwater::metrics::statistics::{chi_square_p_value, holm};
use headwater::procedural;
use headwater::shader_interface::{GpuLightChoice, RestirConstants, ReuseConstants};

const BODY: &str = "Random random = random_start(a.x, 1u, 2u);
    uvec4 bits = random_bits(random);
    LightPoint p = draw_point(pick_light(0u, a.y, bits.xy), bits);
    float pdf_area = pdf_own_measure(p, vec3(0.0), light_probability(p));
    x = uvec4(floatBitsToUint(light_position(light_at(p.index, CURRENT), p.uv)), p.index); y.x = floatBitsToUint(pdf_area);";

fn draw(lights: &Lights, count: u32) -> Vec<[u32; 8]> {
    let function = Function {
        includes: &["lights/light_point.glsl"],
        body: BODY,
        lights: lights.clone(),
        ..Function::default()
    };
    let inputs: Vec<[u32; 8]> = (0..count)
        .map(|i| [i, lights.choices.len() as u32, 0, 0, 0, 0, 0, 0])
        .collect();
    function.run(&inputs)
}

#[test]
fn lights_are_picked_as_often_as_their_probability_says() {
    const COUNT: u32 = 1 << 19;
    let scene = procedural::generate("night-city", &[]).unwrap();
    let lights = gpu_lights(&scene, &Units::of(&scene, DVec3::ZERO));
    let drawn = draw(&lights, COUNT);
    let count = lights.choices.len();
    let mut observed = vec![0_u64; count];
    // Σ 1/(p N) over picks is the number of lights over itself: one.
    let mut inverse = 0.0;
    for output in &drawn {
        let light = output[3] as usize;
        observed[light] += 1;
        let probability = number(output[4]) * f64::from(lights.triangles[light].area);
        assert!((probability / f64::from(lights.choices[light].probability) - 1.0).abs() < 1e-5);
        inverse += 1.0 / (probability * count as f64);
    }
    let expected: Vec<f64> = (lights.choices)
        .iter()
        .map(|l| f64::from(l.probability) * f64::from(COUNT))
        .collect();
    let p = chi_square_p_value(&observed, &expected);
    assert!(p > 1e-4, "{p}");
    // The uniform fraction bounds 1/(p N) by ten, and so this mean's deviation.
    let mean = inverse / f64::from(COUNT);
    assert!(
        (mean - 1.0).abs() < 5.0 * 3.0 / f64::from(COUNT).sqrt(),
        "{mean}"
    );
}

#[test]
fn points_lie_evenly_on_their_triangle() {
    const SIDE: usize = 8;
    let scene = procedural::generate("cornell", &[]).unwrap();
    let lights = gpu_lights(&scene, &Units::of(&scene, DVec3::ZERO));
    let mut p_values = Vec::new();
    for (number, light) in lights.triangles.iter().enumerate() {
        let [corner, e, f] = [light.corner, light.edge1, light.edge2].map(|v| v.as_dvec3());
        let mut observed = vec![0_u64; SIDE * SIDE];
        for output in draw(&lights, 1 << 16) {
            if output[3] as usize != number {
                continue;
            }
            let p = vector(&output) - corner;
            // Barycentric weights by the triangle's own plane.
            let normal = e.cross(f);
            let u = p.cross(f).dot(normal) / normal.length_squared();
            let v = e.cross(p).dot(normal) / normal.length_squared();
            assert!(u > -1e-5 && v > -1e-5 && u + v < 1.0 + 1e-5);
            // Cells of equal area.
            let row = (((1.0 - (1.0 - u).powi(2)) * SIDE as f64) as usize).min(SIDE - 1);
            let column = ((v / (1.0 - u).max(1e-9) * SIDE as f64) as usize).min(SIDE - 1);
            observed[row * SIDE + column] += 1;
        }
        let each = observed.iter().sum::<u64>() as f64 / (SIDE * SIDE) as f64;
        assert!(each > 50.0);
        p_values.push(chi_square_p_value(&observed, &vec![each; SIDE * SIDE]));
    }
    assert!(holm(&p_values).iter().all(|p| *p > 1e-4), "{p_values:?}");
}

/// Each light sampler must draw every light as often as its density says (χ² test), and must be able to draw all lights: the
/// mean of 1 / (p N) over the draws is 1.
#[test]
fn candidate_sources_draw_by_their_density() {
    const COUNT: u32 = 1 << 18;
    let scene = procedural::generate("night-city", &[]).unwrap();
    let lights = gpu_lights(&scene, &Units::of(&scene, DVec3::ZERO));
    for uniform_candidates in [0, 1] {
        let function = Function {
            includes: &["lights/samplers/sources.glsl"],
            body: "Random random = random_start(a.x, 1u, 2u);
                LightSampleContext context = distant_context();
                float pdf_area;
                LightSample s = draw_light_sample(context, 0u, random_bits(random), pdf_area);
                x = uvec4(s.point.index, floatBitsToUint(pdf_area), 0u, 0u);",
            lights: lights.clone(),
            restir: RestirConstants {
                reuse: ReuseConstants {
                    uniform_candidates,
                    ..ReuseConstants::default()
                },
                ..RestirConstants::default()
            },
            ..Function::default()
        };
        let inputs: Vec<[u32; 8]> = (0..COUNT).map(|i| [i, 0, 0, 0, 0, 0, 0, 0]).collect();
        let count = lights.choices.len();
        let probability = |light: &GpuLightChoice| match uniform_candidates {
            0 => f64::from(light.probability),
            _ => 1.0 / count as f64,
        };
        let mut observed = vec![0_u64; count];
        let mut inverse = 0.0;
        for output in function.run(&inputs) {
            let light = output[0] as usize;
            let selected = number(output[1]) * f64::from(lights.triangles[light].area);
            let expected = probability(&lights.choices[light]);
            assert!((selected / expected - 1.0).abs() < 1e-5);
            observed[output[0] as usize] += 1;
            inverse += 1.0 / (selected * count as f64);
        }
        let expected: Vec<f64> = (lights.choices.iter())
            .map(|light| probability(light) * f64::from(COUNT))
            .collect();
        let p = chi_square_p_value(&observed, &expected);
        assert!(p > 1e-4, "{p}");
        // 1/(p N) is at most ten, by the uniform fraction of the selection by power.
        let mean = inverse / f64::from(COUNT);
        let limit = 5.0 * 3.0 / f64::from(COUNT).sqrt();
        assert!((mean - 1.0).abs() < limit, "{mean}");
    }
}

/// At the random words on the border between two lights, a rounding error would select the wrong light, and change
/// probabilities by one part in a thousand where there are ten million lights.
#[test]
fn every_light_gets_its_exact_fraction_of_the_random_words() {
    const COUNT: u64 = 1_000_003;
    let choice = |index: u64| GpuLightChoice {
        keep_below: (index as u32).wrapping_mul(0x9E37_79B9),
        alias: u32::MAX - index as u32,
        ..bytemuck::Zeroable::zeroed()
    };
    let choices: Vec<GpuLightChoice> = (0..COUNT).map(choice).collect();
    let function = Function {
        includes: &["lights/light_point.glsl"],
        body: "x.x = pick_light(0u, a.x, a.yz);",
        lights: Lights {
            choices: choices.clone(),
            ..Lights::default()
        },
        ..Function::default()
    };
    // The last word of one light, the first of the next, and the words around where that one is no longer kept.
    let words: Vec<u64> = (1..COUNT)
        .step_by(101)
        .flat_map(|index| {
            let first = |fraction: u32| {
                let product = u128::from(index) << 64 | u128::from(fraction) << 32;
                product.div_ceil(u128::from(COUNT)) as u64
            };
            let [start, middle] = [first(0), first(choices[index as usize].keep_below)];
            [start - 1, start, middle - 1, middle]
        })
        .collect();
    let inputs: Vec<[u32; 8]> = words
        .iter()
        .map(|w| [COUNT as u32, (w >> 32) as u32, *w as u32, 0, 0, 0, 0, 0])
        .collect();
    let expected = words.iter().map(|word| {
        let product = u128::from(*word) * u128::from(COUNT);
        let (index, fraction) = ((product >> 64) as usize, (product >> 32) as u32);
        match fraction < choices[index].keep_below {
            true => index as u32,
            false => choices[index].alias,
        }
    });
    let picked = function.run(&inputs);
    let wrong = picked
        .iter()
        .zip(expected)
        .filter(|(p, e)| p[0] != *e)
        .count();
    assert_eq!(wrong, 0, "of {} words", words.len());
}
