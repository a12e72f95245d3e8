//! Direct light: candidates from lights and from the BSDF, then reuse.

use super::bindings::InitialDirect;
use super::pilots::Pilots;
use super::reuse::Reuse;
use crate::Result;
use crate::gpu::{ComputePass, Recording};
use crate::render::frame_inputs::FrameInputs;
use crate::render::light_samplers::LightSamplers;

/// The passes and reservoirs of direct light.
pub struct DirectLight {
    /// The pass that draws candidates.
    pub initial: ComputePass,
    /// The light samplers from which some candidates are drawn.
    pub samplers: LightSamplers,
    /// The reuse of the candidates.
    pub reuse: Reuse,
}

impl DirectLight {
    /// Records the passes. The pilots are the first BSDF candidates.
    ///
    /// # Errors
    /// A binding that a pass does not have.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        pilots: &Pilots<'a>,
    ) -> Result<()> {
        for sampler in self.samplers.iter() {
            sampler.record(recording, inputs, &self.reuse.restir)?;
        }
        let initial = InitialDirect {
            scene: inputs.scene,
            restir: &self.reuse.restir,
            sample_data: inputs.sample_data,
            samplers: &self.samplers,
            pilots: pilots.buffer,
            reservoirs: self.reuse.reservoirs.current(),
            color: inputs.color,
            counters: inputs.counters,
        };
        recording.pass(&self.initial, &initial, &(), inputs.groups)?;
        self.reuse.record(recording, inputs)
    }
}
