//! Tests of the light BVH: lights are drawn as often as their probability says, at any point.

use crate::support::random::Random;
use crate::{Function, number};
use glam::{DVec3, Vec3};
use headwater::layouts::{GpuLightNode, RestirConstants};
use headwater::metrics::statistics::{chi_square_p_value, holm};
use headwater::scene::procedural;
use headwater::tracing::Units;
use headwater::tracing::light_bvh::{LightBvh, LightBvhContents, LightBvhOptions};
use headwater::tracing::lights::{Lights, gpu_lights};

/// The receiver at a point `a.xyz`, with normals and directions by the number `a.w`.
const RECEIVER: &str = "
    uvec4 turns = pcg4d(uvec4(a.w, 1u, 2u, 3u));
    Receiver receiver;
    receiver.position = uintBitsToFloat(a.xyz);
    receiver.normal = normalize(to_unit(turns).xyz - 0.5);
    receiver.outgoing = normalize(to_unit(pcg4d(turns)).xyz - 0.5);
    if (dot(receiver.normal, receiver.outgoing) < 0.0) receiver.outgoing = -receiver.outgoing;
    receiver.outgoing_cosine = dot(receiver.normal, receiver.outgoing);
    receiver.diffuse = 0.2;
    receiver.specular = to_unit(turns.w) < 0.5 ? 0.0 : 0.04;
    receiver.specular_grazing = 1.0;
    receiver.alpha_squared = 0.01;
    receiver.next = 0u;
    receiver.passed = 0.0;
    receiver.found = NONE;
    receiver.own = 0.0;
    receiver.expected = expected_of_all(receiver);
";

/// Lights of two kinds, some of which are far from the others, and one that is off.
fn lights() -> Lights {
    let mut scene =
        procedural::generate("colourful-mess", &[("lamps".into(), "4".into())]).unwrap();
    let conservatory = procedural::generate("conservatory", &[]).unwrap();
    scene.punctual_lights = conservatory.punctual_lights;
    let mut lights = gpu_lights(&scene, &Units::of(&scene, DVec3::ZERO));
    lights.powers[0] = 0.0;
    lights
}

/// Every way to build it.
fn ways() -> Vec<LightBvhOptions> {
    let mut all = Vec::new();
    for cut in [false, true] {
        for by_power in [false, true] {
            all.push(LightBvhOptions {
                scale: cut.then_some(1.5),
                cut,
                clusters: by_power,
                by_power,
            });
        }
    }
    all
}

fn function<'a>(
    body: &'a str,
    options: LightBvhOptions,
    lights: &Lights,
    contents: LightBvhContents,
) -> Function<'a> {
    Function {
        includes: &["lights/sources.glsl"],
        body,
        lights: lights.clone(),
        restir: RestirConstants {
            light_node_count: contents.nodes.len() as u32,
            light_bvh_joins: options.cut.into(),
            light_bvh_uniform: (!options.by_power).into(),
            ..RestirConstants::default()
        },
        light_bvh: contents,
        ..Function::default()
    }
}

/// Points in boxes, around them, and on their faces, edges and corners to the last bit.
fn points(nodes: &[GpuLightNode], count: u32) -> Vec<Vec3> {
    let mut random = Random(1);
    let finite: Vec<&GpuLightNode> = nodes.iter().filter(|n| n.low.is_finite()).collect();
    let mut point = || {
        let node = finite[random.index(finite.len())];
        let mut at = |axis: usize| {
            let (low, high) = (node.low[axis], node.high[axis]);
            match random.index(6) {
                0 => low,
                1 => high,
                2 => low.next_down(),
                3 => high.next_up(),
                4 => low + (high - low) * random.unit() as f32,
                _ => low + (high - low) * (3.0 * random.unit() as f32 - 1.0),
            }
        };
        Vec3::new(at(0), at(1), at(2))
    };
    (0..count).map(|_| point()).collect()
}

fn input(point: Vec3, number: u32) -> [u32; 8] {
    let [x, y, z] = point.to_array().map(f32::to_bits);
    [x, y, z, number, 0, 0, 0, 0]
}

/// The largest deviation from 1 of the sum of all probabilities over 10,000 points, and how many of these find no light.
fn sums(options: LightBvhOptions, fault: Option<(&str, &str, &str)>) -> (f64, usize) {
    let lights = lights();
    let bvh = LightBvh::new(&lights, &[], &[Vec3::ZERO; 1], options);
    let contents = bvh.contents(&lights);
    let points = points(&contents.nodes, 10_000);
    let body = format!(
        "{RECEIVER}
        // Thousands of equal floats would add up their rounding errors.
        for (uint i = 0u; i < scene.at.light_count && receiver.expected > 0.0; i += 1u) {{
            x.x += uint(round(near_light_probability(receiver, i) * 1073741824.0));
        }}
        x.y = floatBitsToUint(receiver.expected);"
    );
    let mut function = function(&body, options, &lights, contents);
    function.fault = fault;
    let inputs: Vec<[u32; 8]> = (0..).zip(&points).map(|(i, p)| input(*p, i)).collect();
    let (mut worst, mut empty) = (0.0_f64, 0);
    for output in function.run(&inputs) {
        if number(output[1]) > 0.0 {
            worst = worst.max((f64::from(output[0]) / f64::from(1 << 30) - 1.0).abs());
        } else {
            empty += 1;
        }
    }
    (worst, empty)
}

#[test]
fn probabilities_add_up_to_one_at_every_point() {
    for options in ways() {
        let (worst, empty) = sums(options, None);
        println!("{options:?}: {worst:.1e}, {empty} of 10000 points find no light");
        assert!(worst < 1e-5, "{options:?}: {worst}");
        assert!(empty < 9_000, "{options:?}");
    }
}

#[test]
fn a_walk_to_the_wrong_node_is_found() {
    for (text, planted, changes_sums) in [
        ("place.leaf >= sibling", "place.leaf > sibling", true),
        // Moves all boxes alike, which leaves the sums as they are.
        (
            "all(lessThanEqual(point, node.high))",
            "all(lessThan(point, node.high - 0.01))",
            false,
        ),
    ] {
        let fault = ("lights/light_bvh.glsl", text, planted);
        let (worst, _) = sums(ways()[3], Some(fault));
        assert_eq!(worst > 1e-3, changes_sums, "{text}: {worst}");
    }
}

#[test]
fn lights_are_drawn_as_often_as_their_probability_says() {
    const DRAWS: u32 = 1 << 15;
    let lights = lights();
    let mut p_values = Vec::new();
    for options in ways() {
        let bvh = LightBvh::new(&lights, &[], &[Vec3::ZERO; 1], options);
        let contents = bvh.contents(&lights);
        let body = format!(
            "{RECEIVER}
            // Number b.y of eight draws, which are in ascending order.
            uint drawn = NONE;
            float probability = 0.0;
            if (receiver.expected > 0.0) {{
                drawn = draw_near_light(receiver, b.y, 8u, pcg4d(uvec4(b.x, 5u, 6u, 7u)).xy, probability);
                y.x = floatBitsToUint(near_light_probability(receiver, drawn));
            }}
            x = uvec4(drawn, floatBitsToUint(probability), floatBitsToUint(receiver.expected), 0u);"
        );
        let function = function(&body, options, &lights, contents.clone());
        for (seed, point) in (0..).zip(points(&contents.nodes, 6)) {
            let inputs: Vec<[u32; 8]> = (0..DRAWS)
                .map(|draw| {
                    let mut words = input(point, seed);
                    (words[4], words[5]) = (draw, draw % 8);
                    words
                })
                .collect();
            let mut observed = vec![0_u64; lights.choices.len()];
            let mut probability = vec![0.0; observed.len()];
            for output in function.run(&inputs) {
                if number(output[2]) == 0.0 {
                    break;
                }
                let (light, drawn) = (output[0] as usize, number(output[1]));
                // The one that is known from the draw is the one that is found for the light.
                assert!((number(output[4]) / drawn - 1.0).abs() < 1e-4);
                observed[light] += 1;
                probability[light] = drawn;
            }
            assert!(
                observed[0] == 0 || !options.by_power,
                "a light that is off was drawn"
            );
            let seen: Vec<usize> = (0..observed.len()).filter(|i| observed[*i] > 0).collect();
            if seen.len() < 2 {
                continue;
            }
            // Those that were never drawn are one cell.
            let rest = (1.0 - seen.iter().map(|i| probability[*i]).sum::<f64>()).max(0.0);
            let mut counts: Vec<u64> = seen.iter().map(|i| observed[*i]).collect();
            let mut expected: Vec<f64> = seen
                .iter()
                .map(|i| probability[*i] * f64::from(DRAWS))
                .collect();
            // Cells of few are one, too.
            let (mut few, mut few_expected) = (0, rest * f64::from(DRAWS));
            for index in (0..counts.len()).rev() {
                if expected[index] < 10.0 {
                    few += counts.swap_remove(index);
                    few_expected += expected.swap_remove(index);
                }
            }
            if few_expected > 5.0 {
                counts.push(few);
                expected.push(few_expected);
            }
            p_values.push(chi_square_p_value(&counts, &expected));
        }
    }
    assert!(p_values.len() > 12, "{}", p_values.len());
    assert!(holm(&p_values).iter().all(|p| *p > 1e-4), "{p_values:?}");
}
