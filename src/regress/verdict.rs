//! The verdict on a case of the regression tests: the comparison of its picture, and of the hashes of the buffers that its
//! passes write, with the golden frame.

use super::golden::{Golden, Rendered};
use crate::Result;
use crate::image::Image;
use crate::metrics::statistics::Estimate;

/// The result of the test of one case. If at least one case failed, `headwater regress` fails. Each text is a message for
/// the user.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The case agrees with its golden frame. The text says how much the pictures differ; it is empty if every bit is equal.
    Passed(String),
    /// The result of the case differs from its golden frame, the golden frames of this driver do not contain the case, or
    /// the driver failed. If every bit must be equal, the case also fails if the device lacks a feature that the driver of
    /// the golden frame had. The text says why.
    Failed(String),
    /// The case was not compared, for example because the device lacks a feature that the case needs. This is no failure,
    /// unless all cases are skipped. The text says why.
    Skipped(String),
}

/// The tolerance for values of a channel in the pictures of two drivers, so that rounding is allowed. Two values agree if
/// their difference is at most this fraction of the larger value. Two pixels disagree if their values in at least one
/// channel do not agree.
const NEAR: f32 = 1e-3;
/// The largest fraction of pixels in which the pictures of two drivers may disagree; with more, the case fails. Some pixels
/// always disagree, because rounding can change a random decision, and a path then takes another direction.
const MAX_APART: f64 = 0.05;
/// The number of seeds with which a case is rendered to compare the levels (mean values of the picture) of
/// two drivers. One picture does not show whether a difference is noise or a wrong level, because reuse
/// spreads one changed decision over many pixels, so that they are not independent. Pictures with different
/// seeds are independent.
pub const SEEDS: u32 = 16;
/// The probability with which the confidence interval of the difference between the levels of two drivers
/// contains the true difference. A case fails if its interval does not contain 0; if the true difference is
/// 0, this happens in one case of 10,000.
const CONFIDENCE: f64 = 0.9999;
/// The largest half-width of the confidence interval of the difference between two levels with which a case
/// can pass, as a fraction of the golden level. A wider interval could hide a wrong level.
const MAX_NOISE: f64 = 0.01;
/// The largest difference between the levels of two drivers that is always accepted, because rounding alone can shift the
/// level this far. It is a fraction of the golden level.
const ROUNDING: f64 = 1e-4;

/// The level of a picture: the mean of the values of R, G and B over all pixels, in the unit of their
/// radiance. [`judge_loosely`] compares the levels of two drivers.
///
/// # Errors
/// The picture lacks the channel `R`, `G` or `B`.
pub fn level(picture: &Image) -> Result<f64> {
    let pixels = picture.rgb()?;
    let sum: f64 = pixels.iter().flatten().map(|v| f64::from(*v)).sum();
    Ok(sum / pixels.len() as f64)
}

/// The verdict on a case whose golden frame is from the same driver, or for which `regress --exact` was given: every bit of
/// the picture, and of the buffers that passes may write, must be equal. `picture` is the golden picture. The text of a
/// failure names the first frame, pass and buffer that differ.
pub fn judge_exactly(rendered: &Rendered, golden: &Golden, picture: &Image) -> Verdict {
    let pairs = rendered.steps.iter().zip(&golden.steps);
    if let Some((now, before)) = pairs.clone().find(|(now, before)| now != before) {
        return Verdict::Failed(
            match (&now.pass, &now.buffer) == (&before.pass, &before.buffer) {
                true => format!(
                    "frame {}: pass {} wrote different {}",
                    now.frame, now.pass, now.buffer
                ),
                false => format!(
                    "frame {}: pass {} wrote {} where pass {} wrote {}",
                    now.frame, now.pass, now.buffer, before.pass, before.buffer
                ),
            },
        );
    }
    let (now, before) = (rendered.steps.len(), golden.steps.len());
    if now != before {
        return Verdict::Failed(format!("passes wrote {now} buffers instead of {before}"));
    }
    let different = rendered.image.different_channels(picture);
    if different.is_empty() {
        return Verdict::Passed(String::new());
    }
    Verdict::Failed(format!(
        "each pass by itself writes the same, but the picture of whole frames has other channels {}: something between the passes is wrong, such as a barrier",
        different.join(", ")
    ))
}

/// The verdict on a case whose golden frame is from another driver, so that rounding may change some values.
/// The case fails if the pictures differ in size, or if more than 5 % of the pixels disagree. It also fails
/// if the levels of the two drivers, which are compared seed by seed, differ by more than noise and rounding
/// explain. Two pixels disagree if their values of R, G or B differ by more than 0.1 % of the larger one.
/// `picture` is the golden picture.
///
/// # Errors
/// One of the pictures lacks the channel `R`, `G` or `B`.
pub fn judge_loosely(rendered: &Rendered, golden: &Golden, picture: &Image) -> Result<Verdict> {
    let (now, before) = (rendered.image.rgb()?, picture.rgb()?);
    if (rendered.image.width, rendered.image.height) != (picture.width, picture.height) {
        return Ok(Verdict::Failed("the picture has another size".into()));
    }
    let near = |a: f32, b: f32| (a - b).abs() <= NEAR * a.abs().max(b.abs());
    let agree = now.iter().zip(&before);
    let agree = agree
        .filter(|(a, b)| a.iter().zip(*b).all(|(a, b)| near(*a, *b)))
        .count();
    let pixels = now.len() as f64;
    let apart = 1.0 - agree as f64 / pixels;
    let pairs = rendered.levels.iter().zip(&golden.levels);
    let shifts: Vec<f64> = pairs
        .map(|(now, before)| (now - before) / before.max(f64::MIN_POSITIVE))
        .collect();
    let shift = Estimate::of(&shifts);
    // One seed says nothing about noise.
    let noise = match shift.samples {
        1 => 0.0,
        _ => shift.t_interval_half_width(CONFIDENCE),
    };
    let interval = match shift.samples {
        1 => String::new(),
        seeds => format!(" ± {:.5} % in {seeds} seeds", 100.0 * noise),
    };
    let found = format!(
        "{:.2} % of the pixels differ, the level by {:+.5} %{interval}",
        100.0 * apart,
        100.0 * shift.mean,
    );
    let is_near = shift.mean.abs() <= noise.max(ROUNDING) && noise <= MAX_NOISE;
    let fails = apart > MAX_APART || !shift.mean.is_finite() || !is_near;
    Ok(match fails {
        true => Verdict::Failed(found),
        false => Verdict::Passed(found),
    })
}

#[cfg(test)]
mod tests {
    use super::super::golden::Step;
    use super::*;

    fn image(value: impl Fn(usize) -> f32) -> Image {
        let mut image = Image::new(40, 25);
        let values: Vec<[f32; 3]> = (0..1000).map(|i| [value(i), 1.0, 0.5]).collect();
        image.set_vectors("", ["R", "G", "B"], &values);
        image
    }

    fn step(pass: &str, hash: &str) -> Step {
        Step {
            frame: 1,
            pass: pass.into(),
            buffer: "color".into(),
            hash: hash.into(),
        }
    }

    #[test]
    fn the_first_pass_that_differs_is_named() {
        let golden = Golden {
            steps: vec![step("a", "1"), step("b", "2"), step("c", "3")],
            ..golden(Vec::new())
        };
        let picture = image(|_| 1.0);
        let judge = |steps: &[Step], red: f32| {
            let rendered = Rendered {
                image: image(|_| red),
                levels: Vec::new(),
                steps: steps.to_vec(),
            };
            judge_exactly(&rendered, &golden, &picture)
        };
        assert_eq!(judge(&golden.steps, 1.0), Verdict::Passed(String::new()));
        let failed = |verdict: Verdict, expected: &str| {
            assert!(
                matches!(&verdict, Verdict::Failed(why) if why.contains(expected)),
                "{verdict:?}"
            );
        };
        let steps = [step("a", "1"), step("b", "x"), step("c", "y")];
        failed(judge(&steps, 1.0), "frame 1: pass b wrote different color");
        failed(judge(&golden.steps[..2], 1.0), "2 buffers instead of 3");
        failed(judge(&golden.steps, 1.5), "channels R");
        let steps = [step("a", "1"), step("d", "2"), step("c", "3")];
        failed(
            judge(&steps, 1.0),
            "pass d wrote color where pass b wrote color",
        );
    }

    fn golden(levels: Vec<f64>) -> Golden {
        Golden {
            arguments: String::new(),
            picture: String::new(),
            levels,
            steps: Vec::new(),
        }
    }

    /// The verdict of [`judge_loosely`] on pictures with [`SEEDS`] seeds, whose pixel `i` has the red value
    /// `value(i, seed)`. The red value of the golden picture is 1 in all pixels.
    fn judge(value: &dyn Fn(usize, u32) -> f32) -> Verdict {
        let of_seed = |seed| image(|i| value(i, seed));
        let rendered = Rendered {
            image: of_seed(0),
            levels: (0..SEEDS).map(|s| level(&of_seed(s)).unwrap()).collect(),
            steps: Vec::new(),
        };
        let before = image(|_| 1.0);
        let golden = golden(vec![level(&before).unwrap(); SEEDS as usize]);
        judge_loosely(&rendered, &golden, &before).unwrap()
    }

    fn passes(verdict: &Verdict) -> bool {
        matches!(verdict, Verdict::Passed(_))
    }

    #[test]
    fn other_drivers_may_round_but_not_shift() {
        assert!(passes(&judge(&|_, _| 1.0)));
        let rounding = |i, _| if i % 2 == 0 { 1.00001 } else { 0.99999 };
        assert!(passes(&judge(&rounding)));
        let few_paths = |i, _| match i % 50 {
            0 => (i % 100) as f32 / 25.0,
            _ => 1.0,
        };
        assert!(passes(&judge(&few_paths)));
        let many_paths = |i, _| match i % 10 {
            0 => (i % 20) as f32 / 5.0,
            _ => 1.0,
        };
        assert!(!passes(&judge(&many_paths)));
        assert!(!passes(&judge(&|_, _| 1.0009)), "a little more everywhere");
        assert!(!passes(&judge(&|_, _| f32::NAN)));
    }

    /// Reuse gives all pixels of a surface the sample that one of them has found. If rounding changes one
    /// decision, the whole surface can therefore become brighter with one seed, and darker with another. Such
    /// random changes must pass. A very large change with a single seed, and a shift with all seeds, must
    /// fail.
    #[test]
    fn a_decision_that_reuse_spreads_is_no_shift() {
        let surface = |change: fn(u32) -> f32| {
            move |i, seed| match i < 40 {
                true => 1.0 + change(seed),
                false => 1.0,
            }
        };
        let random = surface(|seed| [0.4, 0.0, -0.3, 0.0, 0.0, -0.1, 0.2, -0.3][seed as usize % 8]);
        assert!(passes(&judge(&random)), "{:?}", judge(&random));
        let rarely = surface(|seed| if seed == 3 { 90.0 } else { 0.0 });
        assert!(!passes(&judge(&rarely)), "{:?}", judge(&rarely));
        let always = surface(|seed| [0.4, 0.1, 0.3, 0.2][seed as usize % 4]);
        assert!(!passes(&judge(&always)), "{:?}", judge(&always));
    }
}
