//! The verdict on a case of the regression tests: the comparison of its picture, and of the hashes of the buffers that its
//! passes write, with the golden frame.

use super::golden::{Golden, Step};
use crate::Result;
use crate::image::Image;

/// The result of rendering a case on the driver under test: its picture, and the hashes of its buffers. Both are compared
/// with those of the golden frame, which is the stored result of a trusted driver.
pub struct Rendered {
    /// The picture of the case, from a run in which each frame is submitted as a whole, as in normal use. The hashes in
    /// `steps` come from a second run, in which the passes run one by one.
    pub image: Image,
    /// The hashes of the buffers that passes may write: one per pass and buffer, in the order in which the passes ran. They
    /// show which pass first differs from the golden frame.
    pub steps: Vec<Step>,
}

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
/// The largest allowed difference between the means of two drivers' pictures (of R + G + B over all pixels), as a multiple
/// of the standard error of this difference. The case fails if the difference is larger and also exceeds [`ROUNDING`]:
/// neither noise nor rounding then explains it.
const MAX_DEVIATIONS: f64 = 4.0;
/// The largest difference between the means of two drivers' pictures (of R + G + B over all pixels) that is always accepted,
/// because rounding alone can shift the mean this far. It is a fraction of the mean of the golden picture.
const ROUNDING: f64 = 1e-4;

/// The verdict on a case whose golden frame is from the same driver, or for which `regress --exact` was given: every bit of
/// the picture, and of the buffers that passes may write, must be equal. `picture` is the golden picture. The text of a
/// failure names the first frame, pass and buffer that differ.
pub fn judge_exactly(rendered: &Rendered, golden: &Golden, picture: &Image) -> Verdict {
    let pairs = rendered.steps.iter().zip(&golden.steps);
    if let Some((now, before)) = pairs.clone().find(|(now, before)| now != before) {
        return Verdict::Failed(
            match (&now.pass, &now.buffer) == (&before.pass, &before.buffer) {
                true => format!(
                    "frame {}: pass {} wrote another {}",
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

/// The verdict on a case whose golden frame is from another driver, so that rounding may change some values. The case fails
/// if the pictures differ in size, if more than 5 % of the pixels disagree, or if the means of the pictures differ by more
/// than noise and rounding explain. Two pixels disagree if their values of R, G or B differ by more than 0.1 % of the larger
/// one. `picture` is the golden picture.
///
/// # Errors
/// One of the pictures lacks the channel `R`, `G` or `B`.
pub fn judge_loosely(rendered: &Rendered, picture: &Image) -> Result<Verdict> {
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
    let sum = |pixel: &[f32; 3]| pixel.iter().map(|v| f64::from(*v)).sum::<f64>();
    let differences: Vec<f64> = now
        .iter()
        .zip(&before)
        .map(|(a, b)| sum(a) - sum(b))
        .collect();
    let mean = differences.iter().sum::<f64>() / pixels;
    let variance =
        differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (pixels - 1.0).max(1.0);
    let deviation = (variance / pixels).sqrt();
    let level = before.iter().map(sum).sum::<f64>() / pixels;
    let relative = mean / level.max(f64::MIN_POSITIVE);
    let found = format!(
        "{:.2} % of the pixels differ, the mean by {:+.5} ± {:.5} %",
        100.0 * apart,
        100.0 * relative,
        100.0 * deviation / level.max(f64::MIN_POSITIVE)
    );
    let fails = apart > MAX_APART
        || !relative.is_finite()
        || (relative.abs() > ROUNDING && mean.abs() > MAX_DEVIATIONS * deviation);
    Ok(match fails {
        true => Verdict::Failed(found),
        false => Verdict::Passed(found),
    })
}

#[cfg(test)]
mod tests {
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
            arguments: String::new(),
            picture: String::new(),
            steps: vec![step("a", "1"), step("b", "2"), step("c", "3")],
        };
        let picture = image(|_| 1.0);
        let judge = |steps: &[Step], red: f32| {
            let rendered = Rendered {
                image: image(|_| red),
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
        failed(judge(&steps, 1.0), "frame 1: pass b wrote another color");
        failed(judge(&golden.steps[..2], 1.0), "2 buffers instead of 3");
        failed(judge(&golden.steps, 1.5), "channels R");
        let steps = [step("a", "1"), step("d", "2"), step("c", "3")];
        failed(
            judge(&steps, 1.0),
            "pass d wrote color where pass b wrote color",
        );
    }

    #[test]
    fn other_drivers_may_round_but_not_shift() {
        let golden = image(|_| 1.0);
        let judge = |value: &dyn Fn(usize) -> f32| {
            let rendered = Rendered {
                image: image(value),
                steps: Vec::new(),
            };
            judge_loosely(&rendered, &golden).unwrap()
        };
        let passes = |verdict| matches!(verdict, Verdict::Passed(_));
        assert!(passes(judge(&|_| 1.0)));
        // Rounding, and few paths that go elsewhere.
        assert!(passes(judge(&|i| if i % 2 == 0 {
            1.00001
        } else {
            0.99999
        })));
        assert!(passes(judge(&|i| if i % 50 == 0 {
            (i % 100) as f32 / 25.0
        } else {
            1.0
        })));
        // Many paths, or a little more light everywhere.
        assert!(!passes(judge(&|i| if i % 10 == 0 {
            (i % 20) as f32 / 5.0
        } else {
            1.0
        })));
        assert!(!passes(judge(&|_| 1.0009)));
        assert!(!passes(judge(&|_| f32::NAN)));
    }
}
