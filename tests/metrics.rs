//! Tests of error metrics through the public interface: against values computed by hand, and against properties that FLIP
//! must have.

use headwater::metrics::error::Errors;
use headwater::metrics::flip::flip;

fn close(got: f64, expected: f64, what: &str) {
    let scale = expected.abs().max(1e-12);
    assert!(
        (got - expected).abs() <= 1e-6 * scale,
        "{what}: {got} is not {expected}"
    );
}

/// The mean FLIP error between two uniformly grey pictures of `side` × `side` pixels.
fn grey_flip(picture: f32, reference: f32, side: u32) -> f64 {
    let grey = |value: f32| vec![[value; 3]; (side * side) as usize];
    flip(&grey(picture), &grey(reference), (side, side), 0.0).mean
}

#[test]
fn errors_of_two_pixels_are_what_a_hand_computes() {
    // Differences: 0.5, 0, 2 and −0.25, 0, 0; squared they sum to 4.3125.
    let picture = [[0.75, 0.5, 3.0], [0.0, 0.25, 1.0]];
    let reference = [[0.25, 0.5, 1.0], [0.25, 0.25, 1.0]];
    let errors = Errors::between(&picture, &reference);
    close(errors.rmse, (4.3125_f64 / 6.0).sqrt(), "rmse");
    // Clamped, the difference of 2 vanishes.
    close(errors.rmse_clamped, (0.3125_f64 / 6.0).sqrt(), "clamped");
    let relative = 0.25 / 0.0725 + 4.0 / 1.01 + 0.0625 / 0.0725;
    close(errors.relmse, relative / 6.0, "relmse");
    close(errors.mean_ratio, 5.5 / 3.25, "mean ratio");
}

#[test]
fn negative_values_clamp_to_black_and_only_relmse_knows_which_is_the_reference() {
    let (dark, light) = ([[-1.0; 3]], [[0.5; 3]]);
    let (there, back) = (
        Errors::between(&dark, &light),
        Errors::between(&light, &dark),
    );
    close(there.rmse, 1.5, "rmse");
    close(there.rmse_clamped, 0.5, "clamped");
    close(back.rmse, there.rmse, "rmse, swapped");
    close(there.relmse, 2.25 / 0.26, "relmse");
    close(back.relmse, 2.25 / 1.01, "relmse, swapped");
}

#[test]
fn the_ratio_of_means_is_one_for_black_pictures_and_infinite_over_black() {
    let (black, light) = ([[0.0; 3]; 2], [[0.5; 3]; 2]);
    assert_eq!(Errors::between(&black, &black).mean_ratio, 1.0);
    assert_eq!(Errors::between(&light, &black).mean_ratio, f64::INFINITY);
    assert_eq!(Errors::between(&black, &light).mean_ratio, 0.0);
}

#[test]
fn sums_over_many_pixels_keep_their_figures() {
    // In 32 bits a running sum of this many would be off in the third figure.
    let count = 1 << 21;
    let errors = Errors::between(&vec![[0.1; 3]; count], &vec![[0.3; 3]; count]);
    let (a, b) = (f64::from(0.1_f32), f64::from(0.3_f32));
    close(errors.rmse, b - a, "rmse");
    close(errors.mean_ratio, a / b, "mean ratio");
}

#[test]
fn flip_rises_from_none_to_nearly_one_with_the_step_from_black() {
    assert_eq!(grey_flip(0.0, 0.0, 32), 0.0);
    let steps: Vec<f64> = [0.0, 0.01, 0.05, 0.2, 0.5, 1.0]
        .map(|value| grey_flip(value, 0.0, 32))
        .to_vec();
    assert!(steps.windows(2).all(|pair| pair[0] < pair[1]), "{steps:?}");
    assert!(steps[5] > 0.9 && steps[5] <= 1.0, "{steps:?}");
}

#[test]
fn flip_sees_what_a_display_shows() {
    // Beyond white both are white, until the exposure brings them down.
    let shown = |ev| flip(&[[4.0; 3]], &[[2.0; 3]], (1, 1), ev).mean;
    assert_eq!(shown(0.0), 0.0);
    close(shown(-2.0), grey_flip(1.0, 0.5, 1), "two stops down");
}

#[test]
fn flip_of_a_large_picture_keeps_its_figures() {
    // One grey against another has the same error everywhere, so the size must not matter.
    let small = grey_flip(0.4, 0.5, 16);
    close(grey_flip(0.4, 0.5, 1600), small, "1600 × 1600");
}
