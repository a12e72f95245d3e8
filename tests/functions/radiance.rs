//! Tests of shader functions: the rounding of radiance in reservoirs.

use crate::{Function, floats, number};
use headwater::shader_interface::Format;
use headwater::shader_interface::Specialisation;

/// RGB colours of all brightnesses that f32 can hold, some with a dim channel beside bright ones.
fn colours() -> Vec<[f32; 3]> {
    let shapes = [
        [1.0, 1.0, 1.0],
        [1.0, 0.5, 0.02],
        [0.003, 1.9999, 0.7],
        [0.0, 0.0, 1.0],
        [0.999_999_9, 1.000_000_1, 0.123],
        [0.001, 0.998, 0.997],
    ];
    let brightness = [-100, -40, -1, 0, 3, 49, 100].map(|power| 2.0_f32.powi(power));
    brightness
        .iter()
        .flat_map(|b| shapes.map(|shape| shape.map(|c: f32| c * b)))
        .collect()
}

fn largest(colour: [f32; 3]) -> f64 {
    f64::from(colour.iter().copied().fold(0.0, f32::max))
}

/// The stored colour must be right on average over the random numbers that round it. Numbers spread evenly over [0, 1) stand
/// for them, and show an error of 1/4096 of a step.
#[test]
fn colours_are_kept_on_average() {
    let function = Function {
        includes: &["core/radiance.glsl"],
        body: "vec3 colour = uintBitsToFloat(a.xyz), sum = vec3(0.0), low = vec3(0.0);
            float most = max_component(colour);
            for (uint i = 0u; i < 4096u; i += 1u)
                pair_add(sum, low, unpack_color(pack_color(colour, vec3(float(i) / 4096.0))) / most);
            x.xyz = floatBitsToUint((sum + low) / 4096.0);",
        ..Function::default()
    };
    let inputs: Vec<[u32; 8]> = colours().iter().map(|c| floats(c)).collect();
    let nearest = Function {
        fault: Some(("core/radiance.glsl", "uvec3(numbers *", "uvec3(0.5 *")),
        ..function.clone()
    };
    let off = number(nearest.run(&inputs)[2][2]) - 0.7 / 1.9999;
    assert!(off.abs() > 1e-3, "rounding to the nearest: {off}");
    for (colour, words) in colours().into_iter().zip(function.run(&inputs)) {
        for c in 0..3 {
            let fraction = f64::from(colour[c]) / largest(colour);
            let error = number(words[c]) - fraction;
            assert!(error.abs() < 1e-5, "{colour:?}: {error:e}");
        }
    }
}

/// The three floats that a function returns for one input.
fn colour_of(function: &Function, input: [u32; 8]) -> [f64; 3] {
    let words = function.run(&[input])[0];
    [0, 1, 2].map(|c| number(words[c]))
}

#[test]
fn the_largest_step_and_number_stay_finite() {
    let mut function = Function {
        includes: &["core/radiance.glsl"],
        body: "x.xyz = floatBitsToUint(unpack_color(pack_color(uintBitsToFloat(a.xyz), vec3(0.99999994))));",
        ..Function::default()
    };
    let input = floats(&[f32::MAX, 0.0, 255.0 / 256.0]);
    let [largest, zero, rounded_up] = colour_of(&function, input);
    assert!(largest > 3.3e38 && largest.is_finite());
    assert_eq!([zero, rounded_up], [0.0, 1.0]);
    function.fault = Some(("core/radiance.glsl", "0x7F7FFFFFu", "0xFFFFFFFFu"));
    assert!(colour_of(&function, input)[0].is_infinite());
}

/// A channel of −0, which a factor of −0 in a file makes, must be stored as 0.
#[test]
fn minus_zero_stays_zero() {
    let mut function = Function {
        includes: &["core/radiance.glsl"],
        body: "x.xyz = floatBitsToUint(unpack_color(pack_color(uintBitsToFloat(a.xyz), vec3(0.0))));",
        ..Function::default()
    };
    let input = floats(&[-0.0, 0.5, 1.0]);
    assert_eq!(colour_of(&function, input), [0.0, 0.5, 1.0]);
    function.fault = Some(("core/radiance.glsl", " & 0x7FFFFFFFu", ""));
    assert!(colour_of(&function, input)[0] > 3e38);
}

#[test]
fn a_stored_colour_goes_back_as_it_was() {
    let function = Function {
        includes: &["core/radiance.glsl"],
        body:
            "vec3 once = unpack_color(pack_color(uintBitsToFloat(a.xyz), uintBitsToFloat(b.xyz)));
            x.xyz = floatBitsToUint(once);
            y.xyz = floatBitsToUint(unpack_color(pack_color(once, vec3(0.5))));",
        ..Function::default()
    };
    let inputs: Vec<[u32; 8]> = (colours().iter())
        .flat_map(|colour| {
            [[0.0, 0.3, 0.999_999], [0.7, 0.0, 0.5]].map(|numbers: [f32; 3]| {
                let (colour, numbers) = (colour.map(f32::to_bits), numbers.map(f32::to_bits));
                let [r, g, b] = colour;
                let [i, j, k] = numbers;
                [r, g, b, 0, i, j, k, 0]
            })
        })
        .collect();
    for (input, words) in inputs.iter().zip(function.run(&inputs)) {
        assert_eq!(words[..4], words[4..], "{input:?}");
    }
}

/// A channel may be a hundred thousand times dimmer than the brightest one and still be the only channel that a surface
/// reflects. If rounding kept it as rarely as it is dim, it would be far too bright when it is kept.
#[test]
fn dim_channels_are_no_outliers() {
    let function = Function {
        includes: &["core/radiance.glsl"],
        body: "vec3 colour = uintBitsToFloat(a.xyz);
            vec3 most = vec3(0.0);
            for (uint i = 0u; i < 4096u; i += 1u)
                most = max(most, unpack_color(pack_color(colour, vec3((float(i) + 0.5) / 4096.0))));
            x.xyz = floatBitsToUint(most / colour);",
        ..Function::default()
    };
    for dim in [1e-2, 1e-3, 1e-5, 1e-12] {
        let words = function.run(&[floats(&[1.0, dim, 0.7 * dim])])[0];
        let most = [0, 1, 2].map(|c| number(words[c]));
        assert!(most.iter().all(|most| *most < 1.05), "{dim:e}: {most:?}");
    }
}

#[test]
fn full_reservoirs_keep_every_channel_of_a_light() {
    let emission = [1e6, 1.0, 1e-3];
    let constants = Specialisation::default().constants();
    let format = constants
        .iter()
        .find(|c| c.name == "RESERVOIR_FORMAT")
        .unwrap();
    let function = Function {
        includes: &["restir/samples/direct.glsl"],
        body: "LightSample value = empty_light_sample();
            value.normal = vec3(0.0, 0.0, 1.0);
            value.emission = uintBitsToFloat(a.xyz);
            x.xyz = floatBitsToUint(as_stored(value).emission);",
        constants: &[(format.id, Format::Full as u32)],
        ..Function::default()
    };
    let words = function.run(&[floats(&emission)])[0];
    let kept = [0, 1, 2].map(|c| f32::from_bits(words[c]));
    assert_eq!(kept, emission);
}
