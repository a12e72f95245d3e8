//! Profiles: the time, the counts and the memory traffic of each pass of a frame, after a warm-up. A profile is written as
//! text, as JSON or as a trace, and compared with an earlier profile.

mod comparison;
mod measure;
pub mod statistics;
mod text;
mod trace;

pub use comparison::{Limits, check_comparable, slower};
pub use measure::{Frame, Plan, measure};
pub use text::{difference, table};
pub use trace::trace;

use crate::gpu::{Compiled, PassTime};
use crate::metrics::statistics::{median, quantile};
use crate::render::counters::Counts;
use serde::{Deserialize, Serialize};

/// Version of the JSON format of profiles. Profiles of different versions are not compared.
pub const VERSION: u32 = 1;

/// What a profile measures. Two profiles are compared only if their subjects agree in everything but `settings` and
/// `frames`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Subject {
    /// BLAKE3 hash of the scene's contents, 64 hexadecimal digits.
    pub scene: String,
    /// The settings of the renderer as a JSON object, in which each `auto` is replaced by the choice for this scene.
    pub settings: serde_json::Value,
    /// Name of the device that renders, as the driver reports it.
    pub device: String,
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// The maximum number of scattering events of a path between emitter and camera; direct light has one.
    pub bounces: u32,
    /// Seed of all random numbers, so that each frame is the same work in every run.
    pub seed: u32,
    /// Position, orientation and field of view of the camera as text, which is different for different cameras.
    pub camera: String,
    /// The time of frame 0 in seconds, and the number of frames per second (`None` if all frames show this time). The whole
    /// is `None` if nothing in the scene moves.
    pub clock: Option<(f64, Option<f64>)>,
    /// Number of frames that are rendered before the timed ones, to compile the shaders and to fill the history (what a
    /// frame reuses of earlier frames).
    pub warm_up: u32,
    /// Number of timed frames, from which medians and percentiles are computed.
    pub frames: u32,
}

/// The conditions of a run that are not part of its [`Subject`]. Two profiles can be compared although their conditions
/// differ, except if `in_flight` differs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Circumstances {
    /// Name and version of the device's driver, as one text.
    pub driver: String,
    /// Name of the tracer, the method that traces rays: `ray-query` or `compute-bvh`.
    pub tracer: String,
    /// Name of the way in which shaders access the scene's buffers: `storage-buffers` (by bindings) or `buffer-addresses`.
    pub geometry: String,
    /// Git commit of Headwater, the first 12 digits of its hash; a `+` follows if tracked files had been changed. Empty for
    /// a build outside a checkout.
    pub commit: String,
    /// The maximum number of frames that are submitted but not finished. With more than 1, only the host's times cover whole
    /// frames.
    pub in_flight: u32,
}

/// Median and 95th percentile of a set of times, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Median of the times, in milliseconds.
    pub median: f64,
    /// 95th percentile of the times, in milliseconds; it shows how much the times vary.
    pub p95: f64,
}

impl Spread {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        Self {
            median: median(values.clone()),
            p95: quantile(values, 0.95),
        }
    }
}

/// The measurements of one pass of the frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// Name of the pass.
    pub name: String,
    /// Number of runs of the pass in the last timed frame. Path tracing reports all runs of a frame as one.
    pub runs: u32,
    /// Time on the device of all runs of the pass in a frame, in milliseconds, over the timed frames.
    pub milliseconds: Spread,
    /// Time on the device of the first run of the pass, in milliseconds, in which some drivers compile it; 0 if it was not
    /// timed.
    pub first_run: f64,
    /// Time in which the driver made the pipeline of the pass, on the host, in milliseconds. If the pass has several
    /// pipelines, it is that of the first one; 0 if there is no record.
    pub pipeline: f64,
    /// Number of rays, active lanes of subgroups, bytes read and written, and others, of the pass in the first timed frame.
    /// They are counted in a separate run with other shaders; all are 0 if the pass counts nothing.
    pub counts: Counts,
    /// Statistics of the driver's compiler about the pass, pairs of name and value; empty if the driver reports none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub statistics: Vec<(String, String)>,
}

/// The memory on the device of all buffers with one name, or of all images.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Name of the buffers; `images` stands for all images.
    pub name: String,
    /// Number of buffers or images with this name.
    pub count: u32,
    /// Size of all these buffers or images together, in bytes.
    pub bytes: u64,
}

/// A profile: the times, counts and memory of a sequence of frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Version of the JSON format; [`VERSION`] in new profiles.
    pub version: u32,
    /// What was measured: scene, settings, device, picture and numbers of frames.
    pub subject: Subject,
    /// The conditions of the run, such as driver and tracer.
    pub circumstances: Circumstances,
    /// Time of a frame in milliseconds, from its submission to the end of the wait for it, over the timed frames. 0 with
    /// several frames in flight, because the host does not wait for each frame.
    pub frame: Spread,
    /// Time on the host in milliseconds, from the start of a frame to the start of the next one, over the timed frames.
    pub host: Spread,
    /// The passes of the last timed frame, in the order of their first runs in it.
    pub passes: Vec<Pass>,
    /// The memory that is allocated after the last frame, one entry per name, the largest first.
    pub memory: Vec<Memory>,
}

impl Profile {
    /// Computes a profile from the frames of the warm-up and the timed frames, both in order. `counts` has the counts of one
    /// frame, `compiled` the driver's results for all pipelines, and `memory` the memory in use after the last frame.
    pub fn new(
        subject: Subject,
        circumstances: Circumstances,
        [warm_up, timed]: [&[Frame]; 2],
        counts: &[Counts],
        compiled: &[Compiled],
        memory: &crate::gpu::records::MemoryUse,
    ) -> Self {
        let runs = |frames: &[Frame], name: &str| -> Vec<(u32, f64)> {
            let of = |frame: &Frame| {
                let own = frame.passes.iter().filter(|pass| pass.name == name);
                own.fold((0, 0.0), |(runs, sum), pass| {
                    (runs + 1, sum + pass.milliseconds)
                })
            };
            frames.iter().map(of).collect()
        };
        let passes = PassTime::by_name(
            timed
                .last()
                .map_or_else(Vec::new, |frame| frame.passes.clone()),
        );
        let passes = passes.into_iter().map(|PassTime { name, .. }| {
            let own = runs(timed, &name);
            let mut all = warm_up.iter().chain(timed).flat_map(|frame| &frame.passes);
            let first_run = all.find(|pass| pass.name == name && pass.first_run);
            let of_name = || compiled.iter().filter(|compiled| compiled.name == name);
            Pass {
                runs: own.last().map_or(0, |(runs, _)| *runs),
                milliseconds: Spread::of(own.iter().map(|(_, milliseconds)| *milliseconds)),
                first_run: first_run.map_or(0.0, |pass| pass.milliseconds),
                pipeline: of_name()
                    .next()
                    .map_or(0.0, |compiled| compiled.milliseconds),
                counts: (counts.iter().find(|counts| counts.pass == name).cloned())
                    .unwrap_or_default(),
                statistics: of_name()
                    .flat_map(|compiled| compiled.report.statistics.clone())
                    .collect(),
                name,
            }
        });
        let mut memory: Vec<Memory> = (memory.iter())
            .map(|(name, (count, bytes))| Memory {
                name: name.clone(),
                count: *count,
                bytes: *bytes,
            })
            .collect();
        memory.sort_by(|a, b| b.bytes.cmp(&a.bytes).then_with(|| a.name.cmp(&b.name)));
        Self {
            version: VERSION,
            subject,
            circumstances,
            frame: Spread::of(timed.iter().map(|frame| frame.submitted)),
            host: Spread::of(timed.iter().map(|frame| frame.host)),
            passes: passes.collect(),
            memory,
        }
    }

    /// Time of a whole frame in milliseconds: [`Profile::frame`] or, with several frames in flight, [`Profile::host`].
    pub fn whole(&self) -> Spread {
        match self.circumstances.in_flight {
            ..=1 => self.frame,
            _ => self.host,
        }
    }

    /// Size of all buffers and images together after the last frame, in bytes.
    pub fn bytes(&self) -> u64 {
        self.memory.iter().map(|memory| memory.bytes).sum()
    }

    /// Number of rays that all passes together trace in the first timed frame.
    pub fn rays(&self) -> u64 {
        self.passes.iter().map(|pass| pass.counts.rays).sum()
    }
}
