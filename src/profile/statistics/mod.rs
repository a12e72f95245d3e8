//! Registers, memory and occupancy of every pass, as the driver's compiler reports them. Nothing runs, so the device may be a
//! driver without its GPU.

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

/// One pipeline: a pass in one SPIR-V, compiled by one driver for one device. A value that the driver does not report is
/// `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pipeline {
    /// The device.
    pub device: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Name of the tracer.
    pub tracer: String,
    /// The pass.
    pub pass: String,
    /// The scenes that use it.
    pub scenes: Vec<String>,
    /// The [configurations](CONFIGURATIONS) that use it.
    pub settings: Vec<String>,
    /// Invocations in a subgroup.
    pub subgroup_size: u32,
    /// Vector registers of each invocation.
    pub vgprs: Option<u64>,
    /// The number of vector registers that were moved to scratch memory because there were too few.
    pub spilled_vgprs: Option<u64>,
    /// Bytes of scratch memory of each subgroup.
    pub scratch_bytes: Option<u64>,
    /// The memory of a workgroup in bytes.
    pub lds_bytes: Option<u64>,
    /// Bytes of machine code.
    pub code_bytes: Option<u64>,
    /// Instructions of the machine code.
    pub instructions: Option<u64>,
    /// Subgroups that a SIMD unit holds at once, as the driver counts them: RADV counts one of 64 invocations as two.
    pub waves: Option<u64>,
    /// `waves` divided by the maximum of the unit, in [0, 1].
    pub occupancy: Option<f64>,
}

impl Pipeline {
    /// Sets the values from a report. `most_waves` is the value of `waves` for a shader that needs no registers.
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

/// RADV's name for subgroups that a SIMD unit holds at once.
const WAVES: &str = "Subgroups per SIMD";

/// A statistic by the name that RADV gives it.
fn value(report: &CompilerReport, name: &str) -> Option<u64> {
    let mut statistics = report.statistics.iter();
    let (_, value) = statistics.find(|(own, _)| own == name)?;
    value.parse().ok()
}

/// Reads a file of pipelines.
///
/// # Errors
/// The file cannot be read or has another form.
pub fn read(path: &Path) -> Result<Vec<Pipeline>> {
    let text = input_files::read_text(path, input_files::MAX_JSON_BYTES)?;
    serde_json::from_str(&text).map_err(|e| {
        Error::input(format!(
            "{} has no statistics of pipelines ({e}); 'headwater statistics --output' writes them",
            path.display()
        ))
    })
}

/// Pipelines as a JSON array with one line each, so that a change of a pipeline changes one line of the file.
///
/// # Errors
/// Never with finite values.
pub fn json(pipelines: &[Pipeline]) -> Result<String> {
    let lines = pipelines.iter().map(serde_json::to_string);
    let lines: std::result::Result<Vec<String>, _> = lines.collect();
    let lines = lines.map_err(|e| Error::failed(format!("statistics as JSON: {e}")))?;
    Ok(format!("[\n{}\n]", lines.join(",\n")))
}
