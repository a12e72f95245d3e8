//! Pipelines against stored ones.

use super::Pipeline;

/// The largest differences by which a value may be worse than the stored one.
#[derive(Clone, Copy, Debug)]
pub struct Slack {
    /// Vector registers: the granule in which RDNA2 gives them to subgroups of 64 (that of RDNA3 is 12).
    pub vgprs: u64,
    /// Code and instructions, as a fraction of the stored value.
    pub code: f64,
}

/// The slack of a check. Spilled registers, scratch and shared memory have none, and neither has occupancy.
pub const SLACK: Slack = Slack {
    vgprs: 8,
    code: 0.02,
};

/// A value of a pipeline, where more is worse.
struct Value {
    name: &'static str,
    of: fn(&Pipeline) -> Option<f64>,
    /// The largest value that passes, from the stored one.
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

/// A line for each value that is worse than those of every stored pipeline of the same pass and tracer that a common scene
/// uses with common settings. `stored` has pipelines of this device and driver alone.
///
/// A change of a shader may split what was one pipeline for several scenes, or join several. A pipeline without a
/// counterpart is in no line.
pub fn compare(now: &[Pipeline], stored: &[&Pipeline]) -> Vec<String> {
    let common = |a: &[String], b: &[String]| a.iter().any(|name| b.contains(name));
    let mut lines = Vec::new();
    for one in now {
        let counterparts: Vec<&&Pipeline> = (stored.iter())
            .filter(|old| (&old.tracer, &old.pass) == (&one.tracer, &one.pass))
            .filter(|old| common(&old.scenes, &one.scenes) && common(&old.settings, &one.settings))
            .collect();
        for value in VALUES {
            let worst = (counterparts.iter())
                .filter_map(|old| (value.of)(old))
                .reduce(f64::max);
            if let Some((now, stored)) = (value.of)(one).zip(worst)
                && now > (value.limit)(stored)
            {
                lines.push(format!(
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
    lines
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
            compare(&[now], &[&stored])
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
}
