//! Profiles: the time, the counts and the memory traffic of each pass of a frame, after a warm-up; as text, as JSON, as a
//! trace, and against an earlier profile.

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

/// Version of the JSON form.
pub const VERSION: u32 = 1;

/// The subject of the profile. Only profiles that agree in all but settings and frames are compared.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Subject {
    /// Hash of the scene's contents.
    pub scene: String,
    /// The settings, resolved.
    pub settings: serde_json::Value,
    /// The device.
    pub device: String,
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The maximum number of scattering events.
    pub bounces: u32,
    /// Seed of all random numbers.
    pub seed: u32,
    /// The camera.
    pub camera: String,
    /// The time of frame 0 and the number of frames per second, if anything moves.
    pub clock: Option<(f64, Option<f64>)>,
    /// The number of frames before the timed ones.
    pub warm_up: u32,
    /// The number of timed frames.
    pub frames: u32,
}

/// The conditions of the run; profiles that differ here, except in frames in flight, are worth comparing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Circumstances {
    /// Name and version of the driver.
    pub driver: String,
    /// The way in which rays are traced.
    pub tracer: String,
    /// The access of shaders to the scene.
    pub geometry: String,
    /// The revision of Headwater.
    pub commit: String,
    /// The maximum number of frames in flight.
    pub in_flight: u32,
}

/// The middle and the upper end of a set of times, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The median.
    pub median: f64,
    /// The 95th percentile.
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

/// A pass of the frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// The name.
    pub name: String,
    /// The number of runs per frame.
    pub runs: u32,
    /// The time of all runs in a frame, in milliseconds.
    pub milliseconds: Spread,
    /// The time of its first run, in which some drivers compile it, in milliseconds.
    pub first_run: f64,
    /// The time in which the driver made its pipeline, on the host, in milliseconds.
    pub pipeline: f64,
    /// The counts in the first timed frame, in a separate run.
    pub counts: Counts,
    /// The report of the driver's compiler, if the driver has one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub statistics: Vec<(String, String)>,
}

/// The buffers, or images, of one name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// The name of the buffers.
    pub name: String,
    /// The number of buffers with this name.
    pub count: u32,
    /// The size of all these buffers in bytes.
    pub bytes: u64,
}

/// A profile.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// The version of this form.
    pub version: u32,
    /// The subject of the profile.
    pub subject: Subject,
    /// The conditions of the run.
    pub circumstances: Circumstances,
    /// The time of a frame on the device, in milliseconds: from the submission to the end of the wait for it. 0 with several
    /// frames in flight.
    pub frame: Spread,
    /// The time of a frame on the host, in milliseconds: from the start of one to the start of the next.
    pub host: Spread,
    /// The passes in order.
    pub passes: Vec<Pass>,
    /// The memory that is allocated after the last frame, the largest buffers first.
    pub memory: Vec<Memory>,
}

impl Profile {
    /// A profile of timed frames, in order. `first` are the runs of the warm-up, `counts` the counts of one frame.
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

    /// The time of a frame: on the device or, with several frames in flight, on the host.
    pub fn whole(&self) -> Spread {
        match self.circumstances.in_flight {
            ..=1 => self.frame,
            _ => self.host,
        }
    }

    /// The size of all buffers and images in bytes.
    pub fn bytes(&self) -> u64 {
        self.memory.iter().map(|memory| memory.bytes).sum()
    }

    /// The number of rays in a frame.
    pub fn rays(&self) -> u64 {
        self.passes.iter().map(|pass| pass.counts.rays).sum()
    }
}
