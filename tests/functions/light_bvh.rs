//! Tests of the light BVH in the shaders: lights are drawn as often as their probability says, at any point.

use crate::support::random::Random;
use crate::{Function, number};
use glam::{DVec3, Vec3};
use headwater::device_scene::Units;
use headwater::device_scene::environment::EnvironmentTexels;
use headwater::device_scene::light_bvh::{LightBvh, LightBvhContents, LightBvhOptions};
use headwater::device_scene::lights::{Lights, gpu_lights};
use headwater::metrics::statistics::{chi_square_p_value, holm};
use headwater::procedural;
use headwater::scene::{Environment, Scene};
use headwater::shader_interface::Specialisation;
use headwater::shader_interface::{GpuLightNode, RestirConstants, ReuseConstants};

/// GLSL that makes the context of the light sampler at the point `a.xyz`; the number `a.w` decides its normal and
/// directions.
const CONTEXT: &str = "
    uvec4 turns = pcg4d(uvec4(a.w, 1u, 2u, 3u));
    LightSampleContext context;
    context.position = uintBitsToFloat(a.xyz);
    context.normal = normalize(to_unit(turns).xyz - 0.5);
    context.outgoing = normalize(to_unit(pcg4d(turns)).xyz - 0.5);
    if (dot(context.normal, context.outgoing) < 0.0) context.outgoing = -context.outgoing;
    context.bsdf.diffuse = 0.2;
    context.bsdf.specular = to_unit(turns.w) < 0.5 ? 0.0 : 0.04;
    context.bsdf.specular_grazing = 1.0;
    context.bsdf.alpha_squared = to_unit(turns.y) < 0.5 ? 0.01 : 1e-8;
    context.next = 0u;
    context.passed = 0.0;
    context.found = NONE;
    context.own = 0.0;
    context.expected = expected_of_all(context);
";

/// A scene with triangles and punctual lights, some of which are far from the others.
fn lit_scene() -> Scene {
    let mut scene =
        procedural::generate("colourful-mess", &[("lamps".into(), "4".into())]).unwrap();
    let conservatory = procedural::generate("conservatory", &[]).unwrap();
    scene.punctual_lights = conservatory.punctual_lights;
    scene
}

/// The lights of `lit_scene` on the device, one of which is off.
fn lights() -> Lights {
    let scene = lit_scene();
    let mut lights = gpu_lights(&scene, &Units::of(&scene, DVec3::ZERO));
    lights.powers[0] = 0.0;
    lights
}

/// All combinations of options of the light BVH.
fn ways() -> Vec<LightBvhOptions> {
    let mut all = Vec::new();
    for cut in [false, true] {
        for by_power in [false, true] {
            all.push(LightBvhOptions {
                scale: cut.then_some(1.5),
                cut,
                clusters: by_power,
                by_power,
                leaves_out_rare: false,
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
        includes: &["lights/samplers/sources.glsl"],
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

/// Points in the boxes of nodes and around them, and on the faces, edges and corners of boxes exactly.
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

/// The largest deviation from 1, over 10,000 points, of the sum of the probabilities of all lights; and the number of these
/// points that find no light.
fn sums(options: LightBvhOptions, fault: Option<(&str, &str, &str)>) -> (f64, usize) {
    let lights = lights();
    let bvh = LightBvh::new(&lights, &[], &[Vec3::ZERO; 1], options);
    let contents = bvh.contents(&lights);
    let points = points(&contents.nodes, 10_000);
    let body = format!(
        "{CONTEXT}
        // Thousands of equal floats would add up their rounding errors.
        for (uint i = 0u; i < scene.at.light_count && context.expected > 0.0; i += 1u) {{
            x.x += uint(round(near_light_probability(context, i) * 1073741824.0));
        }}
        x.y = floatBitsToUint(context.expected);"
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
        ("entry.leaf >= sibling", "entry.leaf > sibling", true),
        // Moves all boxes alike, which leaves the sums as they are.
        (
            "all(lessThanEqual(point, node.high))",
            "all(lessThan(point, node.high - 0.01))",
            false,
        ),
    ] {
        let fault = ("lights/samplers/light_bvh/light_bvh.glsl", text, planted);
        let (worst, _) = sums(ways()[3], Some(fault));
        assert_eq!(worst > 1e-3, changes_sums, "{text}: {worst}");
    }
}

/// No walk may find a light that is off; a light that has all the power must be the only one that is drawn.
#[test]
fn lights_that_are_off_are_not_drawn() {
    let body = format!(
        "{CONTEXT}
        x = uvec4(NONE, 0u, floatBitsToUint(context.expected), 0u);
        float probability;
        if (context.expected > 0.0) x.x = draw_near_light(context, 0u, 1u, pcg4d(a).xy, probability);
        if (x.x != NONE) x.y = floatBitsToUint(probability);"
    );
    for options in ways().into_iter().filter(|options| options.by_power) {
        let all = lights();
        let contents = LightBvh::new(&all, &[], &[Vec3::ZERO; 1], options).contents(&all);
        // Dark nodes have no entry.
        let points = points(&contents.nodes, 1000);
        for shining in [None, Some(7)] {
            let mut lights = lights();
            lights.powers.fill(0.0);
            if let Some(light) = shining {
                lights.powers[light] = 1.0;
            }
            let contents = LightBvh::new(&lights, &[], &[Vec3::ZERO; 1], options).contents(&lights);
            let inputs: Vec<[u32; 8]> = (0..)
                .zip(&points)
                .map(|(index, point)| input(*point, index))
                .collect();
            let drawn = function(&body, options, &lights, contents).run(&inputs);
            let found = drawn.iter().filter(|output| output[0] != u32::MAX);
            assert_eq!(found.count() > 0, shining.is_some(), "{options:?}");
            for output in drawn {
                let (light, probability, expected) = (output[0], output[1], output[2]);
                let is_right = match number(expected) > 0.0 {
                    true => Some(light as usize) == shining && number(probability) > 0.999_999,
                    false => number(expected) == 0.0,
                };
                assert!(is_right, "{options:?} {shining:?}: {output:?}");
            }
        }
    }
}

/// The expected contribution must be finite in the mirror directions of lights, where narrow lobes have their peak and f32
/// is least precise.
#[test]
fn narrow_lobes_expect_finite_contributions() {
    let lights = lights();
    for options in ways().into_iter().filter(|options| options.by_power) {
        let bvh = LightBvh::new(&lights, &[], &[Vec3::ZERO; 1], options);
        let contents = bvh.contents(&lights);
        let body = format!(
            "{CONTEXT}
            GpuLightNode node = load_light_node(a.w % restir.at.light_node_count);
            context.outgoing = reflect(normalize(context.position - node.center), context.normal);
            context.bsdf.specular = 1.0;
            context.bsdf.alpha_squared = uintBitsToFloat(b.x);
            context.expected = expected_of_all(context);
            uint drawn = NONE;
            float probability = 1.0;
            if (context.expected > 0.0) {{
                drawn = draw_near_light(context, 0u, 1u, pcg4d(a).xy, probability);
                y.x = floatBitsToUint(near_light_probability(context, drawn));
            }}
            x = uvec4(drawn, floatBitsToUint(probability), floatBitsToUint(context.expected), 0u);"
        );
        let function = function(&body, options, &lights, contents.clone());
        for alpha_squared in [0.0_f32, 1e-8, 2.5e-8, 1e-6, 0.01] {
            let inputs: Vec<[u32; 8]> = (0..)
                .zip(points(&contents.nodes, 1000))
                .map(|(index, point)| {
                    let mut words = input(point, index);
                    words[4] = alpha_squared.to_bits();
                    words
                })
                .collect();
            for output in function.run(&inputs) {
                let [drawn, expected, again] = [1, 2, 4].map(|word| number(output[word]));
                assert!(expected.is_finite() && expected >= 0.0, "{expected}");
                if expected > 0.0 {
                    assert!(drawn > 0.0 && drawn <= 1.0 + 1e-5, "{drawn}");
                    assert!((again / drawn - 1.0).abs() < 1e-3, "{again} {drawn}");
                }
            }
        }
    }
}

/// A context draws some light samples from the light BVH and some among all lights, or decides at random for a single
/// sample. Lights must be drawn with their mean probability, and the environment uniformly within each texel.
#[test]
fn the_mixture_of_near_lights_and_all_is_drawn_by_its_density() {
    const DRAWS: u32 = 1 << 19;
    let mut scene = lit_scene();
    let environment = Environment {
        name: "even".into(),
        width: 2,
        height: 1,
        texels: vec![Vec3::ONE; 2].into(),
        rotation: 0.0,
        intensity: 1.0,
    };
    scene.environment = Some(environment.clone());
    let units = Units::of(&scene, DVec3::ZERO);
    let lights = gpu_lights(&scene, &units);
    let count = lights.choices.len();
    let options = ways()[3];
    let bvh = LightBvh::new(&lights, &[], &[Vec3::ZERO; 1], options);
    let contents = bvh.contents(&lights);
    let point = Vec3::new(0.0, 1.0, 0.0);
    let constants = Specialisation {
        light_bvh: true,
        ..Specialisation::default()
    }
    .words();
    let mut p_values = Vec::new();
    for (light_samples, near_samples, near_fraction) in [(1, 1, 0.6), (8, 5, 0.625)] {
        let body = format!(
            "{CONTEXT}
            if (b.z == 0u) {{
                float pdf;
                LightSample drawn = draw_light_sample(context, b.y, pcg4d(uvec4(b.x, 5u, 6u, 7u)), pdf);
                x = uvec4(light_index(drawn.point), drawn.point.uv.x < 0.5, drawn.point.uv.y < 0.5, 0u);
            }} else {{
                float all = load_light_choices(b.x).probability;
                x.x = floatBitsToUint(mean_probability(context, all, near_light_probability(context, b.x)));
                x.y = uint(has_near_lights(context));
            }}"
        );
        let mut function = function(&body, options, &lights, contents.clone());
        function.restir.reuse = ReuseConstants {
            light_samples,
            near_samples,
            near_fraction,
            ..ReuseConstants::default()
        };
        function.constants = &constants;
        function.environment = EnvironmentTexels::of(&environment, &units);
        let words = |index: u32, sample: u32, asks: u32| {
            let mut words = input(point, 1);
            words[4..7].copy_from_slice(&[index, sample, asks]);
            words
        };
        let asked: Vec<[u32; 8]> = (0..count as u32).map(|light| words(light, 0, 1)).collect();
        let probability = function.run(&asked);
        assert!(
            probability.iter().all(|output| output[1] == 1),
            "no light is near"
        );
        let draws: Vec<[u32; 8]> = (0..DRAWS)
            .map(|draw| words(draw, draw % light_samples, 0))
            .collect();
        // Quarters of the environment's texels are counted apart.
        let mut observed = vec![0_u64; count + 3];
        for output in function.run(&draws) {
            let light = output[0] as usize;
            let is_environment = light == count - 1;
            observed[light + usize::from(is_environment) * (2 * output[1] + output[2]) as usize] +=
                1;
        }
        let mut expected: Vec<f64> = probability.iter().map(|output| number(output[0])).collect();
        let quarter = expected[count - 1] / 4.0;
        assert!(quarter > 0.005, "{quarter}");
        expected.truncate(count - 1);
        expected.extend([quarter; 4]);
        assert!((expected.iter().sum::<f64>() - 1.0).abs() < 1e-4);
        let expected = expected
            .iter()
            .map(|p| p * f64::from(DRAWS))
            .collect::<Vec<_>>();
        p_values.push(chi_square_p_value(&observed, &expected));
    }
    assert!(holm(&p_values).iter().all(|p| *p > 1e-4), "{p_values:?}");
}

#[test]
fn lights_are_drawn_as_often_as_their_probability_says() {
    const DRAWS: u32 = 1 << 15;
    let lights = lights();
    let count = lights.choices.len();
    let mut p_values = Vec::new();
    for options in ways() {
        let bvh = LightBvh::new(&lights, &[], &[Vec3::ZERO; 1], options);
        let contents = bvh.contents(&lights);
        let body = format!(
            "{CONTEXT}
            // Draw b.x, which is number b.y of eight in ascending order; or, where b.z is 1, no draw, but the probability of light b.x.
            uint drawn = b.x;
            float probability = 0.0;
            if (context.expected > 0.0) {{
                if (b.z == 0u) {{
                    drawn = draw_near_light(context, b.y, 8u, pcg4d(uvec4(b.x, 5u, 6u, 7u)).xy, probability);
                }}
                y.x = floatBitsToUint(near_light_probability(context, drawn));
            }}
            x = uvec4(drawn, floatBitsToUint(probability), floatBitsToUint(context.expected), 0u);"
        );
        let function = function(&body, options, &lights, contents.clone());
        for (seed, point) in (0..).zip(points(&contents.nodes, 6)) {
            let words = |index: u32, only_asks: bool| {
                let mut words = input(point, seed);
                words[4..7].copy_from_slice(&[index, index % 8, only_asks.into()]);
                words
            };
            let asked: Vec<[u32; 8]> = (0..count as u32).map(|light| words(light, true)).collect();
            let answers = function.run(&asked);
            if number(answers[0][2]) == 0.0 {
                continue;
            }
            let expected: Vec<f64> = (answers.iter())
                .map(|answer| f64::from(DRAWS) * number(answer[4]))
                .collect();
            // With one light there is nothing to compare.
            if expected.iter().filter(|mean| **mean >= 5.0).count() < 2 {
                continue;
            }
            let draws: Vec<[u32; 8]> = (0..DRAWS).map(|draw| words(draw, false)).collect();
            let mut observed = vec![0_u64; count];
            for output in function.run(&draws) {
                let (light, drawn) = (output[0] as usize, number(output[1]));
                // The one that is known from the draw is the one that is found for the light.
                assert!((number(output[4]) / drawn - 1.0).abs() < 1e-4);
                observed[light] += 1;
            }
            assert!(
                observed[0] == 0 || !options.by_power,
                "a light that is off was drawn"
            );
            p_values.push(chi_square_p_value(&observed, &expected));
        }
    }
    assert!(p_values.len() > 12, "{}", p_values.len());
    assert!(holm(&p_values).iter().all(|p| *p > 1e-4), "{p_values:?}");
}
