//! Indirect light: paths with next-event estimation, then reuse.

use super::pilots::Pilots;
use super::reuse::{FrameInputs, Reuse};
use crate::Result;
use crate::gpu::{ComputePass, Recording};
use crate::render::passes::InitialIndirect;

/// The passes and reservoirs of indirect light.
pub struct IndirectLight {
    /// The pass that traces paths.
    pub initial: ComputePass,
    /// What happens to its candidates then.
    pub reuse: Reuse,
}

impl IndirectLight {
    /// Records the passes. The pilots are the first segments of paths; they are in the reservoirs that
    /// `initial_indirect` overwrites, so they cannot be used after this.
    ///
    /// # Errors
    /// A binding that a pass does not have.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        pilots: Pilots<'a>,
    ) -> Result<()> {
        let initial = InitialIndirect {
            scene: inputs.scene,
            restir: &self.reuse.restir,
            sample_data: inputs.sample_data,
            reservoirs: pilots.buffer,
            color: inputs.color,
            counters: inputs.counters,
        };
        recording.pass(&self.initial, &initial, &(), inputs.groups)?;
        self.reuse.record(recording, inputs)
    }
}
