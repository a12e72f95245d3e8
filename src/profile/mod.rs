//! Profiles: measurements of each pass of a frame (its time, its counts, such as rays, and its memory traffic), made after a
//! warm-up. A profile is written as text, as JSON or as a trace, and can be compared with an earlier profile.

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

/// Version of the JSON format of profiles, which is written into each file. A profile of another version is not compared,
/// because its values could mean something else.
pub const VERSION: u32 = 1;

/// The subject of a profile: the scene, the device, and the frames that are rendered. Two profiles can be compared only if
/// their subjects agree in everything but `settings` and `frames`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Subject {
    /// BLAKE3 hash of the scene's contents, 64 hexadecimal digits. It shows whether two profiles have the same scene.
    pub scene: String,
    /// The settings of the renderer as a JSON object. A setting that was `auto` has the value that was chosen for this
    /// scene. Profiles with different settings can be compared, to find out which settings are faster.
    pub settings: serde_json::Value,
    /// Name of the device that renders, as the driver reports it. Times of different devices are not compared.
    pub device: String,
    /// Width of the picture in pixels. Two profiles can be compared only if it is equal in both.
    pub width: u32,
    /// Height of the picture in pixels. Two profiles can be compared only if it is equal in both.
    pub height: u32,
    /// The maximum number of scattering events of a path between emitter and camera; direct light has one.
    pub bounces: u32,
    /// Seed of all random numbers. With the same seed, a frame does the same work in every run, so times differ only by
    /// noise.
    pub seed: u32,
    /// Position, orientation and field of view of the camera as one text. Two profiles have the same camera if these texts
    /// are equal.
    pub camera: String,
    /// The clock of the animation: first the time in the scene that frame 0 shows, in seconds, then the number of frames per
    /// second of scene time. The second value is `None` if all frames show the same time. The whole field is `None` if
    /// nothing in the scene moves. Profiles are compared only if this field is equal in both.
    pub clock: Option<(f64, Option<f64>)>,
    /// Number of frames that are rendered before the timed ones. During them, the shaders are compiled and the history (the
    /// data that a frame reuses of earlier frames) is filled, so that the timed frames do only the usual work of a frame.
    pub warm_up: u32,
    /// Number of timed frames, from which the medians and percentiles are computed. It may differ between compared profiles.
    pub frames: u32,
}

/// The conditions of a run that are not part of its [`Subject`]; they can explain why two profiles differ. Two profiles can
/// be compared although their conditions differ, except if `in_flight` differs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Circumstances {
    /// Name and version of the device's driver, as one text.
    pub driver: String,
    /// Name of the tracer, the method that traces rays: `ray-query` (Vulkan's ray queries) or `compute-bvh` (a BVH that
    /// compute shaders traverse).
    pub tracer: String,
    /// Name of the method by which shaders read the scene's buffers: `storage-buffers` (bindings of descriptor sets) or
    /// `buffer-addresses` (addresses in device memory).
    pub geometry: String,
    /// Git commit from which the program was built: the first 12 hexadecimal digits of its hash, then a `+` if tracked files
    /// had been changed. Empty if the program was built outside a checkout.
    pub commit: String,
    /// The maximum number of frames that are submitted to the device but not finished. With more than 1, the time of a whole
    /// frame is known only by the clock of the host ([`Profile::host`]).
    pub in_flight: u32,
}

/// Median and 95th percentile of several times, in milliseconds. The times are those of the timed frames: of whole frames,
/// or of one pass in each of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Median of the times, in milliseconds; half of the times are not longer.
    pub median: f64,
    /// 95th percentile of the times, in milliseconds: 95 % of the times are not longer. Its distance from the median shows
    /// how much the times vary.
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

/// The measurements of one pass of a frame, which show what the pass costs and why. A pass is a compute shader that runs one
/// or more times in a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// Name of the pass, such as `initial_direct`. A pass of an earlier profile is found by this name.
    pub name: String,
    /// Number of runs of the pass in the last timed frame. With path tracing it is 1, because all runs of the pass in a
    /// frame are reported as one.
    pub runs: u32,
    /// Time on the device of all runs of the pass in a frame together, in milliseconds: median and 95th percentile over the
    /// timed frames.
    pub milliseconds: Spread,
    /// Time on the device of the very first run of the pass, in milliseconds. Some drivers compile the pass during this run.
    /// 0 if the run was not timed.
    pub first_run: f64,
    /// Time on the host that the driver needed to make the pipeline of the pass, in milliseconds. If the pass has several
    /// pipelines, it is the time for the first one. 0 if the time was not recorded.
    pub pipeline: f64,
    /// Counts of the pass in one frame, such as its rays, the active lanes of its subgroups, and the bytes that it reads and
    /// writes. Counting takes time, so this frame is rendered again in a separate run, with shaders that count; it has the
    /// same index as the first timed frame. All are 0 if the pass counts nothing.
    pub counts: Counts,
    /// Values that the driver's compiler reports about the pass, such as the number of registers, as pairs of a name and a
    /// value. If the pass has several pipelines, the values of all of them follow each other. Empty if the driver reports
    /// none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub statistics: Vec<(String, String)>,
}

/// An entry of the list of memory on the device: the memory that all buffers with one name use together, or the memory that
/// all images use together. The list shows what needs the memory; only the sum of all entries is compared between profiles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Name that all buffers of this entry have, such as `reservoirs`. It is `images` if this is the entry of all images.
    pub name: String,
    /// Number of the buffers on the device that have the name `name`; in the entry `images`, the number of all images.
    pub count: u32,
    /// Size in bytes of these buffers or images together. The sum over all entries is compared with that of an earlier
    /// profile.
    pub bytes: u64,
}

/// A profile: the times, counts and memory of a sequence of frames, and a description of what was measured. It shows which
/// passes are slow and why. It can also be compared with an earlier profile, to find out whether frames became slower.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Version of the JSON format in which the profile was made. It is [`VERSION`] in new profiles, and can differ in
    /// profiles that were read from a file; such a profile is not compared.
    pub version: u32,
    /// The subject: scene, settings, device, picture and numbers of frames.
    pub subject: Subject,
    /// The conditions of the run that are not part of the subject, such as driver and tracer. They can explain why two
    /// profiles differ.
    pub circumstances: Circumstances,
    /// Time of a frame in milliseconds, from its submission to the end of the wait for the device: median and 95th
    /// percentile over the timed frames. Both are 0 with several frames in flight, because the host then does not wait for
    /// each frame.
    pub frame: Spread,
    /// Time by the clock of the host from the start of a frame to the start of the next one, in milliseconds: median and
    /// 95th percentile over the timed frames.
    pub host: Spread,
    /// The passes that ran in the last timed frame, one entry per pass, in the order of their first runs in this frame.
    pub passes: Vec<Pass>,
    /// The memory on the device that is allocated after the last frame: one entry per name of buffers and one for all
    /// images, the largest first.
    pub memory: Vec<Memory>,
}

impl Profile {
    /// Computes a profile from the times of the frames: `warm_up` has the frames of the warm-up, and `timed`
    /// has the timed frames, both in the order of rendering. `counts` has the counts of each pass in the
    /// first timed frame, and `memory` the buffers and images that exist after the last frame. `compiled` has
    /// the time to make each pipeline and the report of the driver's compiler. From the warm-up, only the
    /// time of the first run of each pass is taken.
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

    /// Median and 95th percentile of the time of a whole frame, in milliseconds, with which two profiles are compared:
    /// [`Profile::frame`], or with several frames in flight [`Profile::host`].
    pub fn whole(&self) -> Spread {
        match self.circumstances.in_flight {
            ..=1 => self.frame,
            _ => self.host,
        }
    }

    /// Size in bytes of all buffers and images on the device together, after the last frame. The comparison of two profiles
    /// reports an increase of this size.
    pub fn bytes(&self) -> u64 {
        self.memory.iter().map(|memory| memory.bytes).sum()
    }

    /// Number of rays that all passes together traced in the first timed frame, which profiles in text form show.
    pub fn rays(&self) -> u64 {
        self.passes.iter().map(|pass| pass.counts.rays).sum()
    }
}
