//! Comparison of what the driver's compiler reports about pipelines (registers, memory, code size, occupancy) with stored
//! reports, to notice changes that make a shader slower.

use super::Pipeline;

/// The tolerance of the comparison of pipelines: the increase of a value over the stored value that does not
/// count as worse. Such a small increase hardly costs time. There is a field for each kind of value that has
/// a tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Slack {
    /// Allowed increase of the number of vector registers per invocation. [`SLACK`] allows 8, because RDNA2 assigns
    /// registers to subgroups of 64 invocations in steps of 8 (RDNA3 in steps of 12).
    pub vgprs: u64,
    /// Allowed increase of the code size (in bytes) and of the number of instructions, as a fraction of the stored value:
    /// 0.02 allows 2 % more.
    pub code: f64,
}

/// The tolerance of [`compare`] for vector registers, code size and number of instructions. The other compared values
/// (spilled registers, scratch memory, shared memory and occupancy) have no tolerance: if one of them is worse at all,
/// `headwater statistics --against` fails.
pub const SLACK: Slack = Slack {
    vgprs: 8,
    code: 0.02,
};

/// A kind of value of a pipeline, such as its number of registers, that is compared with the value of the stored pipeline. A
/// larger value is worse; therefore the occupancy is negated. A value that the driver does not report is not compared.
struct Value {
    name: &'static str,
    of: fn(&Pipeline) -> Option<f64>,
    /// Returns the largest value that a new pipeline may have without counting as worse, including the tolerance. The
    /// argument is the value of the stored pipeline. Both have the unit of this kind of value.
    limit: fn(f64) -> f64,
}

const VALUES: &[Value] = &[
    Value {
        name: "vgprs",
        of: |one| one.vgprs.map(|n| n as f64),
        limit: |stored| stored + SLACK.vgprs as f64,
    },
    Value {
        name: "spilled_vgprs",
        of: |one| one.spilled_vgprs.map(|n| n as f64),
        limit: |stored| stored,
    },
    Value {
        name: "scratch_bytes",
        of: |one| one.scratch_bytes.map(|n| n as f64),
        limit: |stored| stored,
    },
    Value {
        name: "lds_bytes",
        of: |one| one.lds_bytes.map(|n| n as f64),
        limit: |stored| stored,
    },
    Value {
        name: "code_bytes",
        of: |one| one.code_bytes.map(|n| n as f64),
        limit: |stored| stored * (1.0 + SLACK.code),
    },
    Value {
        name: "instructions",
        of: |one| one.instructions.map(|n| n as f64),
        limit: |stored| stored * (1.0 + SLACK.code),
    },
    // Less is worse, so both signs are turned.
    Value {
        name: "occupancy",
        of: |one| one.occupancy.map(|part| -part),
        limit: |stored| stored,
    },
];

/// The outcome of a comparison of pipelines with stored ones: the values that are worse, and the number of pipelines that
/// were not compared. `headwater statistics --against` prints both, and fails if a value is worse.
#[derive(Debug, Default)]
pub struct Compared {
    /// One line of text for each value that is worse than the stored one by more than the tolerance; empty if there is no
    /// such value. A line names the device, the tracer, the pass and the value.
    pub worse: Vec<String>,
    /// Number of pipelines that were not compared, because they have no counterpart among the stored ones. A counterpart is
    /// of the same pass and tracer (the method that traces rays), and has at least one scene and one configuration (named
    /// settings) in common with the pipeline.
    pub without: usize,
}

/// Compares each pipeline in `now` with its counterpart in `stored`: the stored pipeline of the same pass and tracer that
/// has the most uses in common with it. A use is a scene with a configuration (named settings) for which a pipeline was
/// made. If there are several such stored pipelines, each value of the new pipeline is compared with the worst stored one.
/// The caller ensures that all pipelines, in `now` and in `stored`, are of one device and driver.
///
/// Several stored pipelines can have uses in common with a new one, because a change of a shader can split a pipeline that
/// several scenes share, or join the pipelines of several scenes.
pub fn compare(now: &[Pipeline], stored: &[&Pipeline]) -> Compared {
    let mut compared = Compared::default();
    for one in now {
        let same = |old: &&&Pipeline| (&old.tracer, &old.pass) == (&one.tracer, &one.pass);
        let alike = stored
            .iter()
            .filter(same)
            .map(|old| (common_uses(one, old), *old));
        let alike: Vec<(usize, &Pipeline)> = alike.collect();
        let most = alike.iter().map(|(uses, _)| *uses).max().unwrap_or(0);
        if most == 0 {
            compared.without += 1;
            continue;
        }
        for value in VALUES {
            let counterparts = alike.iter().filter(|(uses, _)| *uses == most);
            let worst = counterparts
                .filter_map(|(_, old)| (value.of)(old))
                .reduce(f64::max);
            if let Some((now, stored)) = (value.of)(one).zip(worst)
                && now > (value.limit)(stored)
            {
                compared.worse.push(format!(
                    "worse {} {} {} ({}; {}): {} {} instead of {}",
                    one.device,
                    one.tracer,
                    one.pass,
                    one.scenes.join(" "),
                    one.settings.join(" "),
                    value.name,
                    now.abs(),
                    stored.abs()
                ));
            }
        }
    }
    compared
}

/// The number of the common scenes of two pipelines, times the number of their common configurations (named settings). It is
/// the largest number of uses (a scene with a configuration) that the pipelines can have in common. The exact number of
/// common uses is not known, because a pipeline lists scenes and configurations separately. [`compare`] takes the stored
/// pipeline with the largest result as the counterpart of a pipeline.
fn common_uses(a: &Pipeline, b: &Pipeline) -> usize {
    let common = |a: &[String], b: &[String]| a.iter().filter(|name| b.contains(name)).count();
    common(&a.scenes, &b.scenes) * common(&a.settings, &b.settings)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pipeline(scenes: &[&str]) -> Pipeline {
        Pipeline {
            device: "a GPU".into(),
            tracer: "compute-bvh".into(),
            pass: "path_trace".into(),
            scenes: scenes.iter().map(|name| (*name).to_owned()).collect(),
            settings: vec!["path-tracing".into()],
            vgprs: Some(96),
            spilled_vgprs: Some(0),
            scratch_bytes: Some(0),
            instructions: Some(1000),
            occupancy: Some(0.5),
            ..Pipeline::default()
        }
    }

    #[test]
    fn what_is_worse_beyond_the_slack_has_a_line() {
        let stored = pipeline(&["cornell", "garage"]);
        let check = |change: fn(&mut Pipeline)| {
            let mut now = pipeline(&["garage"]);
            change(&mut now);
            compare(&[now], &[&stored]).worse
        };
        assert_eq!(check(|_| ()), [""; 0]);
        assert_eq!(check(|one| one.vgprs = Some(104)), [""; 0]);
        assert_eq!(check(|one| one.instructions = Some(1020)), [""; 0]);
        assert_eq!(check(|one| one.occupancy = Some(0.6)), [""; 0]);
        assert_eq!(check(|one| one.scenes = vec!["terrain".into()]), [""; 0]);
        for (change, end) in [
            (
                (|one| one.vgprs = Some(105)) as fn(&mut Pipeline),
                "vgprs 105 instead of 96",
            ),
            (
                |one| one.spilled_vgprs = Some(1),
                "spilled_vgprs 1 instead of 0",
            ),
            (
                |one| one.scratch_bytes = Some(4),
                "scratch_bytes 4 instead of 0",
            ),
            (
                |one| one.instructions = Some(1021),
                "instructions 1021 instead of 1000",
            ),
            (
                |one| one.occupancy = Some(0.4375),
                "occupancy 0.4375 instead of 0.5",
            ),
        ] {
            let start = "worse a GPU compute-bvh path_trace (garage; path-tracing): ";
            assert_eq!(check(change), [format!("{start}{end}")]);
        }
    }

    #[test]
    fn the_counterpart_is_the_one_with_most_in_common() {
        let [mut plain, mut textured] = [
            pipeline(&["cornell", "terrain"]),
            pipeline(&["garage", "street", "terrain"]),
        ];
        plain.vgprs = Some(40);
        textured.vgprs = Some(200);
        let check = |scenes: &[&str]| compare(&[pipeline(scenes)], &[&plain, &textured]);
        assert_eq!(check(&["cornell", "terrain"]).worse.len(), 1);
        assert_eq!(check(&["garage", "street"]).worse.len(), 0);
        // As much in common with both: only what is worse than either counts.
        assert_eq!(check(&["terrain"]).worse.len(), 0);
        assert_eq!(check(&["two-rooms"]).without, 1);
    }
}
