//! Direct light: candidates from lights and from the BSDF, then reuse.

use super::bindings::InitialDirect;
use super::pilots::Pilots;
use super::reuse::Reuse;
use crate::Result;
use crate::gpu::{ComputePass, Recording};
use crate::render::frame_inputs::FrameInputs;
use crate::render::light_samplers::hash_grid::HashGridLight;
use crate::render::light_samplers::light_bvh::lists::LightLists;

/// The passes and reservoirs of direct light.
pub struct DirectLight {
    /// The pass that draws candidates.
    pub initial: ComputePass,
    /// The lists that some of these come from.
    pub lists: LightLists,
    /// The hash grid whose reservoirs are merged with them.
    pub grid: HashGridLight,
    /// The reuse of the candidates.
    pub reuse: Reuse,
}

impl DirectLight {
    /// Records the passes. The pilots are its first BSDF candidates.
    ///
    /// # Errors
    /// A binding that a pass does not have.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        pilots: &Pilots<'a>,
    ) -> Result<()> {
        self.lists.record(recording, inputs, &self.reuse.restir)?;
        let frame = self.reuse.constants.frame;
        self.grid
            .record(recording, inputs, &self.reuse.restir, frame)?;
        let initial = InitialDirect {
            scene: inputs.scene,
            restir: &self.reuse.restir,
            sample_data: inputs.sample_data,
            pilots: pilots.buffer,
            light_lists: &self.lists.buffer,
            grid_points: &self.grid.points,
            grid_places: &self.grid.places,
            grid_reservoirs: &self.grid.reservoirs,
            reservoirs: self.reuse.reservoirs.current(),
            color: inputs.color,
            counters: inputs.counters,
        };
        recording.pass(&self.initial, &initial, &(), inputs.groups)?;
        self.reuse.record(recording, inputs)
    }
}
