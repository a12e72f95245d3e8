//! `--resume`: reads the sums of radiance that an earlier run has stored in the first output file, and checks that this run
//! can continue with them. So more samples can be added to a reference that is too noisy or was interrupted.

use super::{Args, PARTS};
use crate::base::printable::{printable, shortened};
use crate::commands::session::Session;
use crate::image::Image;
use crate::render::settings::flatten;
use crate::shader_interface::PixelSums;
use crate::{Error, Result};
use glam::{DVec3, Vec3};
use serde_json::Value;

/// The maximum number of characters that a message quotes of one value from the file that is resumed, because such a
/// value can have any length. The middle of a longer value is left out.
const VALUE_CHARACTERS: usize = 60;

/// The maximum number of settings that a message lists, if settings of the earlier run differ from those of this run. It
/// states only the number of further settings, so that it stays short.
const LISTED: usize = 3;

/// The maximum magnitude of the low part of a sum, as a fraction of its leading part. Each sum is stored as these two
/// numbers; the low part is the rounding error of the leading part. A larger low part shows that the file is damaged,
/// and it is not resumed. The limit leaves room for devices that round differently.
const LOW_PART: f64 = 1e-6;

/// A tolerance for rounding: the mean of a pixel's squared samples may be less than the square of the mean of its samples by
/// at most this fraction of the latter. In exact arithmetic, the mean of the squares is never less. A larger difference
/// shows that the file is damaged, and it is not resumed.
const SPREAD_ROUNDING: f64 = 1e-4;

/// Loads the sums of radiance that an earlier run has stored in the first output file into the renderer. Returns the number
/// of samples per pixel that these sums contain.
///
/// # Errors
/// The file cannot be read, belongs to another picture, or holds values that no sum of samples can have; or the device
/// fails.
pub fn resume(args: &Args, session: &mut Session) -> Result<u32> {
    let path = &args.output[0];
    let earlier = Image::read(path).map_err(|error| {
        Error::input(format!(
            "cannot resume: {error}; start again without --resume"
        ))
    })?;
    let wrong = |what: String| {
        Error::input(format!(
            "cannot resume {}: {what}; give the same arguments, or start again without --resume",
            path.display()
        ))
    };
    if (earlier.width, earlier.height) != (session.view.width, session.view.height) {
        return Err(wrong(format!(
            "it is {} × {}",
            earlier.width, earlier.height
        )));
    }
    // The same picture without a sample has the metadata that must agree.
    let fresh = session.renderer.sums()?;
    let wanted = session.picture(&fresh, 0, &[])?.metadata;
    for (key, value) in &wanted {
        if key != "headwater.samples" && earlier.metadata.get(key) != Some(value) {
            return Err(wrong(match earlier.metadata.get(key) {
                None => format!("it has no {key}"),
                Some(before) => difference(key, before, value),
            }));
        }
    }
    let more = |key: &&String| key.starts_with("headwater.") && !wanted.contains_key(*key);
    if let Some(key) = earlier.metadata.keys().find(more) {
        return Err(wrong(format!("it has {key}, and this run does not")));
    }
    let samples = samples_of(&earlier).map_err(wrong)?;
    let sums = sums_of(&earlier).map_err(wrong)?;
    if let Some(i) = sums.iter().position(|p| !possible(p, samples)) {
        let (x, y) = (i % earlier.width as usize, i / earlier.width as usize);
        return Err(wrong(format!(
            "the sums of pixel {x}, {y} cannot be those of {samples} samples"
        )));
    }
    let coverage = match session.has_alpha() {
        true => coverage_of(&earlier, samples).map_err(wrong)?,
        false => Vec::new(),
    };
    session.renderer.set_sums(&sums, &coverage, samples)?;
    Ok(samples)
}

/// The number of samples per pixel that the metadata of an earlier picture state, at least 1; this run continues the
/// count. The error is a clause for a message; it states why the metadata have no such number.
fn samples_of(earlier: &Image) -> std::result::Result<u32, String> {
    let Some(text) = earlier.metadata.get("headwater.samples") else {
        return Err("it has no headwater.samples".into());
    };
    let samples = text.parse().ok().filter(|samples: &u32| *samples > 0);
    samples.ok_or_else(|| {
        format!(
            "its number of samples is '{}', not 1 to {}",
            shown(text),
            u32::MAX
        )
    })
}

/// The sums of radiance and of squared radiance that an earlier picture stores, to which this run adds its samples: one
/// entry per pixel, row by row from the top. If a channel is missing, the error is a clause for a message, which names the
/// channel.
fn sums_of(earlier: &Image) -> std::result::Result<Vec<PixelSums>, String> {
    let part = |name: &str| {
        let channel = |axis: &str| {
            let name = format!("resume.{name}.{axis}");
            let values = earlier.floats(&name);
            values.ok_or_else(|| format!("it has no channel {name} of floats"))
        };
        let (r, g, b) = (channel("R")?, channel("G")?, channel("B")?);
        let pixels = r.iter().zip(g).zip(b);
        let vectors = pixels.map(|((r, g), b)| Vec3::new(*r, *g, *b));
        Ok::<Vec<Vec3>, String>(vectors.collect())
    };
    let (sum, sum_low) = (part("sum")?, part("sum_low")?);
    let (square, square_low) = (part("square")?, part("square_low")?);
    let pixel = |i| PixelSums {
        sum: sum[i],
        sum_low: sum_low[i],
        square: square[i],
        square_low: square_low[i],
    };
    Ok((0..earlier.pixels()).map(pixel).collect())
}

/// The number of samples of each pixel whose primary ray met a surface, from the channel `A` of an earlier picture of
/// `samples` samples per pixel. If the channel is missing or has another value than such numbers give, the error is a clause
/// for a message.
fn coverage_of(earlier: &Image, samples: u32) -> std::result::Result<Vec<u32>, String> {
    let alpha = earlier.floats("A");
    let alpha = alpha.ok_or_else(|| "it has no channel A of floats".to_owned())?;
    let count = |alpha: &f32| {
        let covered = f64::from(*alpha) * f64::from(samples);
        // Numbers up to 2²⁴ come back from their fraction exactly; larger ones to within the rounding of the channel.
        (0.0..=1.0).contains(alpha).then(|| covered.round() as u32)
    };
    let counts: Option<Vec<u32>> = alpha.iter().map(count).collect();
    counts.ok_or_else(|| "its channel A has values outside of 0 to 1".to_owned())
}

/// True if the sums of a pixel can be those of `samples` samples; if not, the file is damaged. The sums of radiance and of
/// squared radiance must be finite and not negative. Their rounding errors (`sum_low`, `square_low`) must be finite and
/// small. The mean of the squares must not be below the square of the mean, except for rounding.
fn possible(pixel: &PixelSums, samples: u32) -> bool {
    let parts = PARTS.map(|(_, part)| part(pixel).as_dvec3());
    let [sum, sum_low, square, square_low] = parts;
    let fits = |high: DVec3, low: DVec3| {
        high.cmpge(DVec3::ZERO).all() && low.abs().cmple(LOW_PART * high).all()
    };
    let squares = f64::from(samples) * square;
    parts.iter().all(|part| part.is_finite())
        && fits(sum, sum_low)
        && fits(square, square_low)
        // Squares of small values are 0 in f32.
        && (sum * sum * (1.0 - SPREAD_ROUNDING))
            .cmple(squares + f64::from(f32::MIN_POSITIVE) * f64::from(samples).powi(2))
            .all()
}

/// Prepares a value for a message, because the file that is resumed can contain any text: escapes control characters, and
/// shortens the value to at most [`VALUE_CHARACTERS`] characters.
fn shown(text: &str) -> String {
    shortened(&printable(text), VALUE_CHARACTERS)
}

/// The clause of a message that says how the value of the metadata key `key` differs: `before` in the file, `now` in this
/// run. A value is a text or a JSON object; of two objects, the clause lists at most [`LISTED`] differing entries.
fn difference(key: &str, before: &str, now: &str) -> String {
    let parsed = [before, now].map(|text| serde_json::from_str(text).unwrap_or(Value::Null));
    let [before_tree, now_tree] = parsed.map(|tree| {
        let mut flat = Vec::new();
        flatten("", &tree, &mut flat);
        flat
    });
    let value_of = |tree: &[(String, Value)], key: &str| {
        let found = tree.iter().find(|(k, _)| k == key);
        found.map_or("missing".into(), |(_, value)| value.to_string())
    };
    let keys = before_tree.iter().chain(&now_tree).map(|(key, _)| key);
    let mut different: Vec<&String> = keys
        .filter(|key| !key.is_empty() && value_of(&before_tree, key) != value_of(&now_tree, key))
        .collect();
    different.sort();
    different.dedup();
    if different.is_empty() {
        let (before, now) = (shown(before), shown(now));
        return format!("{key} was '{before}' and is now '{now}'");
    }
    let parts = different.iter().take(LISTED).map(|setting| {
        let [before, now] = [&before_tree, &now_tree].map(|tree| shown(&value_of(tree, setting)));
        format!("{} was {before} and is now {now}", shown(setting))
    });
    let mut text = format!("in {key} {}", parts.collect::<Vec<_>>().join(", "));
    if different.len() > LISTED {
        text += &format!(", and {} more differ", different.len() - LISTED);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_that_no_samples_have_are_found() {
        let good = PixelSums {
            sum: Vec3::ONE,
            sum_low: -Vec3::splat(1e-9),
            square: Vec3::ONE,
            square_low: Vec3::ZERO,
        };
        for (sums, samples) in [
            (good, 1),
            (good, 100),
            (PixelSums::default(), 1),
            // A radiance whose square is 0.
            (
                PixelSums {
                    sum: Vec3::splat(3e-23),
                    ..PixelSums::default()
                },
                3,
            ),
        ] {
            assert!(possible(&sums, samples), "{sums:?}");
        }
        for bad in [f32::NAN, f32::INFINITY, -1.0, 1e30] {
            let vector = Vec3::splat(bad);
            let set: [fn(&mut PixelSums) -> &mut Vec3; 4] = [
                |p| &mut p.sum,
                |p| &mut p.sum_low,
                |p| &mut p.square,
                |p| &mut p.square_low,
            ];
            for (i, part) in set.into_iter().enumerate() {
                let mut sums = good;
                *part(&mut sums) = vector;
                // A large sum of squares alone is that of one bright sample.
                assert_eq!(possible(&sums, 2), (i, bad) == (2, 1e30), "{sums:?}");
            }
        }
    }

    #[test]
    fn a_difference_is_short() {
        let long = format!("{{\"a\": \"{}\"}}", "x\n".repeat(4000));
        for (before, now) in [
            (long.as_str(), "{\"a\": 1}"),
            (&long, "no JSON"),
            ("{\"a\":1,\"b\":1,\"c\":1,\"d\":1,\"e\":1}", "{}"),
        ] {
            let text = difference("headwater.settings", before, now);
            assert!(text.chars().count() < 400 && !text.contains('\n'), "{text}");
        }
        let text = difference("k", "{\"a\":1,\"b\":2}", "{\"a\":1,\"b\":3}");
        assert_eq!(text, "in k b was 2 and is now 3");
    }
}
