//! Tests of shader functions: random numbers and their streams, the selection of rare candidates, jitter, and sums of many
//! samples.

use crate::{Function, floats, number};
use glam::Vec2;
use headwater::metrics::statistics::{chi_square_p_value, holm};
use headwater::shader_interface::RestirConstants;
use headwater::shader_interface::{
    STREAM_INDIRECT, STREAM_INITIAL, STREAM_PILOTS, STREAM_SPATIAL, STREAM_TEMPORAL,
};

/// The hash pcg4d (Jarzynski and Olano), written a second time in Rust.
fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let [mut x, mut y, mut z, mut w] =
        v.map(|n| n.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(w));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        w = w.wrapping_add(y.wrapping_mul(z));
        if round == 0 {
            [x, y, z, w] = [x, y, z, w].map(|n| n ^ (n >> 16));
        }
    }
    [x, y, z, w]
}

/// Two draws of random words for many pixels, samples and seeds.
fn draws() -> (Vec<[u32; 8]>, Vec<[u32; 8]>) {
    let inputs: Vec<[u32; 8]> = (0..40_000_u32)
        .map(|i| [i % 4096, i / 4096, 7 * (i % 3), 0, 0, 0, 0, 0])
        .collect();
    let body = "Random random = random_start(a.x, a.y, a.z); x = random_bits(random); y = random_bits(random);";
    let function = Function {
        includes: &["core/random.glsl"],
        body,
        ..Function::default()
    };
    let outputs = function.run(&inputs);
    (inputs, outputs)
}

#[test]
fn draws_are_the_hash_of_their_counters() {
    let (inputs, outputs) = draws();
    for (input, output) in inputs.iter().zip(&outputs) {
        let counter = |n| pcg4d([input[0], input[1], input[2], n]);
        assert_eq!(output[..4], counter(1));
        assert_eq!(output[4..], counter(2));
    }
}

/// Every word of both draws must be uniform, and so must pairs of neighbouring words.
#[test]
fn draws_are_even() {
    let (_, outputs) = draws();
    let mut p_values = Vec::new();
    for word in 0..8 {
        let mut single = vec![0; 256];
        let mut paired = vec![0; 256];
        for output in &outputs {
            single[output[word] as usize >> 24] += 1;
            let other = output[(word + 1) % 8];
            paired[(output[word] as usize >> 28) * 16 + (other as usize >> 28)] += 1;
        }
        let even = vec![outputs.len() as f64 / 256.0; 256];
        p_values.push(chi_square_p_value(&single, &even));
        p_values.push(chi_square_p_value(&paired, &even));
    }
    assert!(holm(&p_values).iter().all(|p| *p > 1e-4), "{p_values:?}");
}

/// The maximum number of spatial passes in a frame.
const MOST_PASSES: u32 = 8;
/// The upper bound of the indices of the random streams of a frame.
const STREAMS: u32 = STREAM_INDIRECT + STREAM_SPATIAL + MOST_PASSES;

/// The first draws of two streams at the same pixels must be independent.
#[test]
fn streams_are_independent() {
    let p_values = streams_p_values(None);
    assert!(holm(&p_values).iter().all(|p| *p > 1e-4), "{p_values:?}");
    let high_bits_alone = streams_p_values(Some((
        "core/random.glsl",
        "stream * 0x9E3779B9u",
        "stream << 24u",
    )));
    assert!(holm(&high_bits_alone).iter().any(|p| *p < 1e-12));
}

fn streams_p_values(fault: Option<(&str, &str, &str)>) -> Vec<f64> {
    const PIXELS: u32 = 1 << 14;
    let passes: Vec<u32> = [0, STREAM_INDIRECT]
        .iter()
        .flat_map(|first| {
            let named = [STREAM_INITIAL, STREAM_TEMPORAL, STREAM_PILOTS];
            let spatial = STREAM_SPATIAL..STREAM_SPATIAL + MOST_PASSES;
            named
                .into_iter()
                .chain(spatial)
                .map(move |pass| first + pass)
        })
        .collect();
    let inputs: Vec<[u32; 8]> = (passes.iter())
        .flat_map(|pass| (0..PIXELS).map(|pixel| [pixel, *pass, 0, 0, 0, 0, 0, 0]))
        .collect();
    let function = Function {
        includes: &["core/random.glsl"],
        body: "Random random = random_stream(a.x, 1u, 123456789u, a.y);
            x = random_bits(random); y = random_bits(random);",
        fault,
        ..Function::default()
    };
    let outputs = function.run(&inputs);
    let streams: Vec<&[[u32; 8]]> = outputs.chunks(PIXELS as usize).collect();
    let even = vec![f64::from(PIXELS) / 256.0; 256];
    let mut p_values = Vec::new();
    for (i, one) in streams.iter().enumerate() {
        for other in &streams[..i] {
            for word in 0..8 {
                let mut paired = vec![0; 256];
                for (a, b) in one.iter().zip(*other) {
                    paired[(a[word] as usize >> 28) * 16 + (b[word] as usize >> 28)] += 1;
                }
                p_values.push(chi_square_p_value(&paired, &even));
            }
        }
    }
    p_values
}

/// A frame must draw fewer numbers from each stream than there are between the starts of two streams.
#[test]
fn streams_do_not_meet() {
    let inputs: Vec<[u32; 8]> = (0..STREAMS).map(|n| [n, 0, 0, 0, 0, 0, 0, 0]).collect();
    let function = Function {
        includes: &["core/random.glsl"],
        body: "x.x = random_stream(1u, 2u, 3u, a.x).counter.w;",
        ..Function::default()
    };
    let starts: Vec<u32> = function.run(&inputs).iter().map(|words| words[0]).collect();
    for (i, one) in starts.iter().enumerate() {
        for other in &starts[..i] {
            let apart = one.wrapping_sub(*other);
            assert!(apart.min(apart.wrapping_neg()) > 1 << 25, "{i}");
        }
    }
}

#[test]
fn pairs_add_up_where_floats_alone_lose() {
    // Many small values beside a large one, by the same steps as a pixel's sums; fewer than the turns
    // after which Mesa 22.3 ends a loop.
    let body = "vec3 high = vec3(uintBitsToFloat(a.x)), low = vec3(0.0);
        for (uint i = 0u; i < 60000u; i += 1u) pair_add(high, low, vec3(uintBitsToFloat(a.y)));
        x.x = floatBitsToUint(high.x); x.y = floatBitsToUint(low.x);";
    let function = Function {
        body,
        ..Function::default()
    };
    let (large, small) = (16_777_216.0_f32, 0.1_f32);
    let output = function.run(&[floats(&[large, small])])[0];
    let sum = number(output[0]) + number(output[1]);
    let exact = f64::from(large) + 6e4 * f64::from(small);
    // The low part rounds too, but a float alone would not move at all.
    assert!((sum - exact).abs() < 1e-9 * exact, "{sum} {exact}");
}

/// A candidate that is a hundred million times dimmer than the sum must be selected as rarely as its weight says, because a
/// selected candidate gets the weight of all candidates.
#[test]
fn rare_candidates_are_selected_as_rarely_as_their_weight_says() {
    const INPUTS: u32 = 1 << 12;
    const DRAWS: u32 = 1 << 16;
    let function = Function {
        includes: &["core/random.glsl", "restir/algebra.glsl"],
        body: "Random random = random_start(a.x, 1u, 2u);
            float weight = uintBitsToFloat(b.x);
            for (uint i = 0u; i < a.y; i += 1u) {
                Stream stream = Stream(1.0, 0u, 1.0);
                if (stream_add(stream, 1u, weight, 1.0, random_choice(random))) x.x += 1u;
            }",
        ..Function::default()
    };
    for fraction in [2e-9_f32, 1e-6, 1e-3] {
        let inputs: Vec<[u32; 8]> = (0..INPUTS)
            .map(|i| [i, DRAWS, 0, 0, fraction.to_bits(), 0, 0, 0])
            .collect();
        let selected: u32 = function.run(&inputs).iter().map(|words| words[0]).sum();
        let expected = f64::from(fraction) * f64::from(INPUTS) * f64::from(DRAWS);
        println!("{fraction}: {selected} of {expected:.1}");
        // The 1e-6 quantiles of the normal distribution, and room for the few of the first fraction.
        let most = expected + 4.9 * expected.sqrt() + 4.0;
        let least = expected - 4.9 * expected.sqrt();
        let seen = f64::from(selected);
        assert!(
            seen <= most && seen >= least,
            "{fraction}: {selected} of {expected}"
        );
    }
}

/// Jitter must differ between the pixels of a row and reach all parts of a pixel: over the pixels of any row or column its
/// mean is close to the centre, and each quarter of the pixel has its fraction of the positions.
#[test]
fn jitter_differs_from_pixel_to_pixel() {
    const SIDE: u32 = 160;
    let function = Function {
        includes: &["restir/frame.glsl"],
        body: "x.xy = floatBitsToUint(position_in_pixel(a.xy, restir.at.jitter));",
        restir: RestirConstants {
            jitters: 1,
            jitter: Vec2::new(0.37, 0.92),
            ..RestirConstants::default()
        },
        ..Function::default()
    };
    for line in [0, 1, 77, 4095] {
        for is_row in [true, false] {
            let pixel = |i| if is_row { [i, line] } else { [line, i] };
            let inputs: Vec<[u32; 8]> = (0..SIDE)
                .map(|i| [pixel(i)[0], pixel(i)[1], 0, 0, 0, 0, 0, 0])
                .collect();
            let words = function.run(&inputs);
            for axis in 0..2 {
                let at: Vec<f64> = words.iter().map(|w| number(w[axis])).collect();
                let mean = at.iter().sum::<f64>() / f64::from(SIDE);
                assert!((mean - 0.5).abs() < 0.02, "{line}, axis {axis}: {mean}");
                for quarter in 0..4 {
                    let low = 0.25 * f64::from(quarter);
                    let count = at.iter().filter(|v| (low..low + 0.25).contains(*v)).count();
                    assert!((35..=45).contains(&count), "{line}, axis {axis}: {count}");
                }
            }
        }
    }
}
