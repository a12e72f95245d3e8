//! Registers, memory and occupancy of the pipelines of every pass, as the driver's compiler reports them. They show whether
//! a change makes a shader slower on a GPU, even if this GPU is missing: the pipelines are only compiled, no shader runs,
//! and some drivers can compile without their GPU.

mod check;
mod collect;
mod settings;
mod text;

pub use check::{Compared, SLACK, Slack, compare};
pub use collect::Compiler;
pub use settings::CONFIGURATIONS;
pub use text::table;

use crate::base::input_files;
use crate::gpu::CompilerReport;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The report of the driver's compiler about one pipeline: a pass with certain SPIR-V, compiled by one driver for one device.
/// The values are compared with stored ones, to find changes that make the pass slower. Several scenes and configurations
/// can share a pipeline. An optional value is `None` if the driver does not report it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pipeline {
    /// Name of the device for which the pass was compiled. Only pipelines of the same device and driver are compared.
    pub device: String,
    /// Name and version of the driver that compiled the pass, as one text. Only pipelines of the same driver and device are
    /// compared.
    pub driver: String,
    /// Name of the tracer (the method that traces rays) for which the pass was compiled: `ray-query` or `compute-bvh`.
    pub tracer: String,
    /// Name of the pass. Several pipelines can have the same name, because the SPIR-V of a pass depends on the scene and the
    /// settings.
    pub pass: String,
    /// Names of the scenes that are rendered with this pipeline. A pipeline is compared with a stored one that has scenes in
    /// common with it.
    pub scenes: Vec<String>,
    /// Names of the [configurations](CONFIGURATIONS) (named settings) that use this pipeline. A pipeline is compared with a
    /// stored one that has configurations in common with it.
    pub settings: Vec<String>,
    /// Number of invocations in a subgroup of the pass, which tables show; 0 if the driver does not report it.
    pub subgroup_size: u32,
    /// Number of vector registers that each invocation uses. The more registers it uses, the fewer subgroups
    /// can run at once. `None` if the driver does not report it.
    pub vgprs: Option<u64>,
    /// Number of vector registers whose values the compiler moved to scratch memory, because an invocation
    /// can have no more registers. `None` if the driver does not report it.
    pub spilled_vgprs: Option<u64>,
    /// Size of the scratch memory (for spilled registers and local arrays) of each subgroup, in bytes; `None`
    /// if the driver does not report it.
    pub scratch_bytes: Option<u64>,
    /// Size of the shared memory (LDS) that each workgroup uses, in bytes; `None` if the driver does not
    /// report it. A larger size can lower the occupancy.
    pub lds_bytes: Option<u64>,
    /// Size of the machine code of the pass, in bytes; `None` if the driver does not report it.
    pub code_bytes: Option<u64>,
    /// Number of instructions in the machine code of the pass; `None` if the driver does not report it.
    pub instructions: Option<u64>,
    /// The maximum number of subgroups of this pass that a SIMD unit holds at once, as the driver counts them: RADV counts a
    /// subgroup of 64 invocations as two.
    pub waves: Option<u64>,
    /// `waves` divided by the value of `waves` for a shader that needs no registers, in [0, 1]. A lower value is worse,
    /// because fewer subgroups hide the time in which others wait for memory.
    pub occupancy: Option<f64>,
}

impl Pipeline {
    /// Copies the values of the compiler's report into the pipeline, and computes its occupancy. `most_waves` is the largest
    /// possible [`Self::waves`]: the number of subgroups that a SIMD unit holds at once if the shader needs no registers. If
    /// it is `None`, or the report does not contain `waves`, the occupancy is `None`, too.
    fn set(&mut self, report: &CompilerReport, most_waves: Option<f64>) {
        self.subgroup_size = report.subgroup_size;
        self.vgprs = value(report, "VGPRs");
        self.spilled_vgprs = value(report, "Spilled VGPRs");
        self.scratch_bytes = value(report, "Scratch size");
        self.lds_bytes = value(report, "LDS size");
        self.code_bytes = value(report, "Code size");
        self.instructions = value(report, "Instructions");
        self.waves = value(report, WAVES);
        let part = self
            .waves
            .zip(most_waves)
            .map(|(waves, most)| waves as f64 / most);
        self.occupancy = part.map(|part| (part * 1e4).round() / 1e4);
    }
}

/// The name under which the driver RADV reports the maximum number of subgroups that a SIMD unit holds at once (`waves`).
/// Other drivers may not report it.
const WAVES: &str = "Subgroups per SIMD";

/// The value of the statistic that the driver calls `name`, such as `VGPRs`. `None` if the report does not contain it, or if
/// it is not a non-negative integer.
fn value(report: &CompilerReport, name: &str) -> Option<u64> {
    let mut statistics = report.statistics.iter();
    let (_, value) = statistics.find(|(own, _)| own == name)?;
    value.parse().ok()
}

/// Reads the pipelines from the file at `path`, which contains a text that [`json()`] made. New pipelines are compared with
/// them, or replace them in the file.
///
/// # Errors
/// The file cannot be read, is too large, or is not a JSON array of pipelines.
pub fn read(path: &Path) -> Result<Vec<Pipeline>> {
    let text = input_files::read_text(path, input_files::MAX_JSON_BYTES)?;
    serde_json::from_str(&text).map_err(|e| {
        Error::input(format!(
            "{} has no statistics of pipelines ({e}); 'headwater statistics --output' writes them",
            path.display()
        ))
    })
}

/// The pipelines as the text of a JSON array with one line per pipeline, so that a change of one pipeline changes only one
/// line of a file under version control.
///
/// # Errors
/// A value cannot be written as JSON, which does not happen for pipelines.
pub fn json(pipelines: &[Pipeline]) -> Result<String> {
    let lines = pipelines.iter().map(serde_json::to_string);
    let lines: std::result::Result<Vec<String>, _> = lines.collect();
    let lines = lines.map_err(|e| Error::failed(format!("statistics as JSON: {e}")))?;
    Ok(format!("[\n{}\n]", lines.join(",\n")))
}
