//! Direct light, which is scattered once: the pass that draws candidates from lights and from the BSDF, and the reuse of the
//! samples that it selects.

use super::bindings::InitialDirect;
use super::pilots::Pilots;
use super::reuse::Reuse;
use crate::Result;
use crate::gpu::{ComputePass, Recording};
use crate::render::frame_inputs::FrameInputs;
use crate::render::light_samplers::LightSamplers;

/// The passes and reservoirs of direct light, which is scattered once between emitter and camera. In a frame, these passes
/// run before those of indirect light.
pub struct DirectLight {
    /// The pass `initial_direct`, which draws the candidates of each pixel and selects one of them for the pixel's
    /// reservoir.
    pub initial: ComputePass,
    /// The light samplers that have buffers (light lists, hash grid); empty if the settings use none. Their passes fill
    /// these buffers before `initial` draws candidates from them.
    pub samplers: LightSamplers,
    /// The reservoirs of direct light, and the passes for their temporal reuse, their spatial reuse and the shading.
    pub reuse: Reuse,
}

impl DirectLight {
    /// Records the passes of direct light of one frame. `pilots` are the first BSDF rays of the pixels, which are traced
    /// already. If direct light draws BSDF candidates, the pilot of a pixel is the first of them.
    ///
    /// # Errors
    /// The driver rejects a shader, or the names of the bindings differ from those in the shader.
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
