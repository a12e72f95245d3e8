//! Tests of the bias check, on runs whose bias is known.

use super::*;

use super::samples::{BLOCKS, noisy_reference, reference, runs};

fn confirmation(offset: [f64; BLOCKS]) -> Confirmation {
    let (first, fresh) = (runs(64, 0, offset), runs(128, 1000, offset));
    let (first, fresh): (Vec<_>, Vec<_>) = (first.iter().collect(), fresh.iter().collect());
    Confirmation::measure(&first, &fresh, &reference())
}

#[test]
fn a_bias_that_cancels_over_the_image_is_confirmed_by_its_pattern() {
    let found = confirmation([0.02, -0.02, 0.0, 0.02, -0.02, 0.0]);
    assert!(found.bias.p_values[0] > 0.01, "{found:?}");
    assert!(found.pattern_p_value < 1e-4, "{found:?}");
}

#[test]
fn one_block_that_is_off_raises_an_alarm() {
    let control = runs(64, 5000, [0.0; BLOCKS]);
    let control: Vec<_> = control.iter().collect();
    let alarm = |offset| {
        let off = runs(64, 0, offset);
        blocks_p_value(&off.iter().collect::<Vec<_>>(), &control, &reference())
    };
    assert!(alarm([0.0, 0.0, 0.05, 0.0, 0.0, 0.0]) < 1e-4);
    assert!(alarm([0.0; BLOCKS]) > 0.01);
}

#[test]
fn no_bias_is_not_confirmed() {
    let found = confirmation([0.0; BLOCKS]);
    assert!(
        found.bias.p_values[0] > 0.01 && found.pattern_p_value > 0.01,
        "{found:?}"
    );
}

#[test]
fn a_reference_as_noisy_as_the_runs_confirms_nothing() {
    const TRIALS: u32 = 200;
    let found = (0..TRIALS).filter(|trial| {
        let seed = |what: u32| 100_000 * (trial + 1) + 1000 * what;
        let noisy = noisy_reference(seed(0), [64; BLOCKS]);
        let first = runs(64, seed(6), [0.0; BLOCKS]);
        let fresh = runs(128, seed(7), [0.0; BLOCKS]);
        let (first, fresh): (Vec<_>, Vec<_>) = (first.iter().collect(), fresh.iter().collect());
        Confirmation::measure(&first, &fresh, &noisy).pattern_p_value < 0.1
    });
    // Of 200 at one in ten more than 35 come once in two thousand times. The level is not quite
    // reached; none at all would say that too much is taken off.
    let found = found.count();
    assert!(
        (2..=35).contains(&found),
        "{found} of {TRIALS} were confirmed"
    );
}

#[test]
fn a_black_channel_asks_for_no_samples() {
    let mut red = reference();
    for (mean, error) in red.mean.iter_mut().zip(&mut red.error) {
        (*mean, *error) = ([1.0, 0.0, 0.0], [0.001, 0.0, 0.0]);
    }
    // With as many as it has, it knows what it knows.
    let again = red.samples_for(red.half_width());
    assert!((again / 4096.0 - 1.0).abs() < 1e-3, "{again}");
}

#[test]
fn a_detectable_bias_is_beyond_the_threshold() {
    let plain = runs(64, 0, [0.0; BLOCKS]);
    let plain: Vec<&Run> = plain.iter().collect();
    let bias = Bias::measure(&plain, &reference());
    let found = bias.detectable(1);
    assert!(
        found > bias.largest_half_width() && found < 2.0 * bias.largest_half_width(),
        "{bias:?} {found}"
    );
    // More tests need larger differences.
    assert!(bias.detectable(100) > found);
}

/// The scene shows emission alone, which has no noise: all runs are equal, and the reference differs from them only by
/// its rounding.
#[test]
fn without_noise_there_is_neither_alarm_nor_infinity() {
    for (emission, sums_rounding) in [(0.0, 0.0), (7.0, 0.0), (7.0, 3e-7)] {
        let mut truth = reference();
        truth.emission = vec![[emission; 3]; truth.mean.len()];
        truth.mean = vec![[emission + sums_rounding; 3]; truth.mean.len()];
        truth.error = vec![[sums_rounding; 3]; truth.mean.len()];
        let mut same = runs(8, 0, [0.0; BLOCKS]);
        for run in &mut same {
            run.mean = [0.0; 3];
            run.blocks = vec![0.0; BLOCKS];
        }
        let same: Vec<&Run> = same.iter().collect();
        let bias = Bias::measure(&same, &truth);
        assert_eq!(bias.relative, [0.0; 3]);
        assert_eq!((bias.half_width, bias.p_values), ([0.0; 3], [1.0; 3]));
        assert_eq!(bias.detectable(100), 0.0);
        assert_eq!(blocks_p_value(&same, &same, &truth), 1.0);
        assert_eq!(truth.half_width(), 0.0);
    }
    // Light where there should be none is a bias, though it has no noise either.
    let mut black = reference();
    black.mean = vec![[0.0; 3]; black.mean.len()];
    black.error = black.mean.clone();
    let mut lit = runs(8, 0, [0.0; BLOCKS]);
    for run in &mut lit {
        run.mean = [0.25; 3];
    }
    let bias = Bias::measure(&lit.iter().collect::<Vec<_>>(), &black);
    assert_eq!((bias.relative, bias.p_values), ([0.25; 3], [0.0; 3]));
}

#[test]
fn missing_seeds_are_as_many_as_make_the_interval_narrow() {
    let measure = |count| {
        let plain = runs(count, 0, [0.0; BLOCKS]);
        Bias::measure(&plain.iter().collect::<Vec<_>>(), &reference())
    };
    let few = measure(16);
    assert!(few.largest_half_width() > 2.0 * MAX_HALF_WIDTH, "{few:?}");
    let more = few.missing_seeds().unwrap();
    let enough = measure(16 + more as u32);
    assert!(
        (0.6..1.3).contains(&(enough.largest_half_width() / MAX_HALF_WIDTH)),
        "{more}"
    );
    assert_eq!(measure(4096).missing_seeds(), Some(0.0));
    let mut vague = reference();
    vague.error = vec![[1.0; 3]; vague.error.len()];
    let plain = runs(64, 0, [0.0; BLOCKS]);
    let bias = Bias::measure(&plain.iter().collect::<Vec<_>>(), &vague);
    assert_eq!(bias.missing_seeds(), None);
}

#[test]
fn a_control_has_the_noise_of_what_it_controls() {
    let loud = runs(64, 0, [0.0; BLOCKS]);
    let mut quiet = runs(64, 0, [0.0; BLOCKS]);
    for block in quiet.iter_mut().flat_map(|run| &mut run.blocks) {
        *block = 1.0 + (*block - 1.0) / 3.0;
    }
    let (loud, quiet): (Vec<_>, Vec<_>) = (loud.iter().collect(), quiet.iter().collect());
    assert_eq!(control_samples(&quiet, &loud), 8);
    assert_eq!(control_samples(&loud, &quiet), 1);
}
