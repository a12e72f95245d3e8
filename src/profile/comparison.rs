//! Comparison of a profile with an earlier one of the same subject (scene, device, camera, picture size and others), to find
//! out whether frames became slower or need more memory.

use super::{Circumstances, Profile, Spread, Subject, VERSION};
use crate::{Error, Result};

/// The limits up to which a profile may be worse than an earlier one, so that noise of the measurement is not reported. If a
/// value exceeds its limit, `headwater profile --against` fails.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The largest allowed increase of the median time of the whole frame, and of the median time of each pass, as a
    /// fraction of the earlier median: 0.1 allows 10 % more.
    pub time: f64,
    /// The largest allowed increase of the size of all buffers and images on the device together, as a fraction of the
    /// earlier size: 0.02 allows 2 % more.
    pub memory: f64,
}

/// Minimum median time of a pass that is compared with the earlier profile, as a fraction of the frame's
/// median time. Shorter times are mostly noise of the timer, and hardly change the time of the frame.
const SMALLEST_PASS: f64 = 0.02;

/// Checks that the profile to be made can be compared with the profile `earlier`. It is called before anything is rendered,
/// so that no time is lost with a wrong file. `ours` and `circumstances` describe the profile to be made; `earlier_name` is
/// the file name of the earlier one, for the error message.
///
/// # Errors
/// The two profiles differ in the format version, in the number of frames in flight, or in a part of the subject other than
/// the settings and the number of timed frames.
pub fn check_comparable(
    ours: &Subject,
    circumstances: &Circumstances,
    earlier: &Profile,
    earlier_name: &str,
) -> Result<()> {
    let theirs = &earlier.subject;
    let size = |subject: &Subject| format!("{} × {}", subject.width, subject.height);
    let in_flight = |circumstances: &Circumstances| circumstances.in_flight.to_string();
    let pairs = [
        ("version", earlier.version.to_string(), VERSION.to_string()),
        ("scene", theirs.scene.clone(), ours.scene.clone()),
        ("device", theirs.device.clone(), ours.device.clone()),
        ("size", size(theirs), size(ours)),
        (
            "number of bounces",
            theirs.bounces.to_string(),
            ours.bounces.to_string(),
        ),
        ("camera", theirs.camera.clone(), ours.camera.clone()),
        ("seed", theirs.seed.to_string(), ours.seed.to_string()),
        (
            "warm-up",
            theirs.warm_up.to_string(),
            ours.warm_up.to_string(),
        ),
        (
            "clock",
            format!("{:?}", theirs.clock),
            format!("{:?}", ours.clock),
        ),
        // Without waits it is the host that is timed.
        (
            "number of frames in flight",
            in_flight(&earlier.circumstances),
            in_flight(circumstances),
        ),
    ];
    match pairs.into_iter().find(|(_, theirs, ours)| theirs != ours) {
        Some((what, theirs, ours)) => Err(Error::input(format!(
            "{earlier_name} is a profile of another {what} ({theirs} instead of {ours}); profiles compare only if they show the same"
        ))),
        None => Ok(()),
    }
}

/// Compares the profile `now` with the profile `earlier`, and returns one sentence for each time or memory size that is
/// worse than `limits` allow; the list is empty if none is. A median time that exceeds its limit is worse only if it also
/// exceeds the earlier 95th percentile of this time, because smaller differences can be noise. Passes that now take less
/// than 2 % of the frame's time are ignored. Each other pass that is missing from the earlier profile is new, and gets a
/// sentence.
pub fn slower(now: &Profile, earlier: &Profile, limits: Limits) -> Vec<String> {
    let mut found = Vec::new();
    // Beyond the limit, and beyond what the earlier frames themselves varied by.
    let mut check = |what: &str, now: f64, before: Spread, limit: f64| {
        let Spread {
            median: before,
            p95,
        } = before;
        if now > before * (1.0 + limit) && now > p95 {
            found.push(format!(
                "{what} takes {:+.1} % ({} instead of {})",
                100.0 * (now / before - 1.0),
                figure(now),
                figure(before)
            ));
        }
    };
    check(
        "the frame",
        now.whole().median,
        earlier.whole(),
        limits.time,
    );
    let mut new = Vec::new();
    for pass in &now.passes {
        let time = pass.milliseconds.median;
        if time < SMALLEST_PASS * now.whole().median {
            continue;
        }
        let mut passes = earlier.passes.iter();
        match passes.find(|before| before.name == pass.name) {
            Some(before) => {
                let what = format!("pass {}", pass.name);
                check(&what, time, before.milliseconds, limits.time);
            }
            None => new.push(format!("pass {} is new and takes {time:.3} ms", pass.name)),
        }
    }
    let bytes = Spread::of(std::iter::once(earlier.bytes() as f64));
    check("memory", now.bytes() as f64, bytes, limits.memory);
    found.extend(new);
    found
}

fn figure(value: f64) -> String {
    if value >= 1e6 {
        format!("{value:.0}")
    } else {
        format!("{value:.3}")
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Memory, Pass};
    use super::*;

    fn profile(frame: f64, passes: &[(&str, f64)], bytes: u64) -> Profile {
        let spread = |median| Spread {
            median,
            p95: median,
        };
        Profile {
            version: VERSION,
            frame: spread(frame),
            passes: (passes.iter())
                .map(|(name, time)| Pass {
                    name: (*name).into(),
                    milliseconds: spread(*time),
                    ..Pass::default()
                })
                .collect(),
            memory: vec![Memory {
                name: "all".into(),
                count: 1,
                bytes,
            }],
            ..Profile::default()
        }
    }

    const LIMITS: Limits = Limits {
        time: 0.1,
        memory: 0.02,
    };

    #[test]
    fn only_what_is_beyond_a_limit_is_worse() {
        let before = profile(100.0, &[("a", 90.0), ("b", 1.0)], 1000);
        let within = profile(109.0, &[("a", 98.0), ("b", 1.9)], 1020);
        assert_eq!(slower(&within, &before, LIMITS), Vec::<String>::new());
        let beyond = profile(111.0, &[("a", 100.0), ("b", 11.0)], 1021);
        let found = slower(&beyond, &before, LIMITS).join("; ");
        for what in ["the frame", "pass a", "pass b", "memory"] {
            assert!(found.contains(what), "{found}");
        }
        // Noise of the earlier frames is no reason.
        let mut noisy = before.clone();
        noisy.passes[0].milliseconds.p95 = 101.0;
        assert!(
            !slower(&beyond, &noisy, LIMITS)
                .join("; ")
                .contains("pass a")
        );
        // A pass that was not there before.
        let new = profile(100.0, &[("a", 80.0), ("c", 10.0)], 1000);
        assert!(slower(&new, &before, LIMITS).join("").contains("pass c"));
    }

    #[test]
    fn profiles_of_other_subjects_are_refused() {
        let now = profile(1.0, &[], 1);
        let check = |earlier: &Profile| {
            check_comparable(&now.subject, &now.circumstances, earlier, "old.json")
        };
        assert!(check(&now).is_ok());
        let mut other = now.clone();
        other.subject.scene = "b".into();
        let error = check(&other).unwrap_err().to_string();
        assert!(
            error.starts_with("old.json is a profile of another scene"),
            "{error}"
        );
        let mut other = now.clone();
        other.version = 0;
        assert!(check(&other).is_err());
        let mut other = now.clone();
        other.circumstances.in_flight = 3;
        assert!(check(&other).is_err());
    }
}
