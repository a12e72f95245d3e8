//! Direct light: candidates from lights and from the BSDF, then reuse.

use super::hash_grid::HashGridLight;
use super::light_lists::LightLists;
use super::pilots::Pilots;
use super::reuse::{FrameInputs, Reuse};
use crate::Result;
use crate::gpu::{ComputePass, Recording};
use crate::render::passes::InitialDirect;

/// The passes and reservoirs of direct light.
pub struct DirectLight {
    /// The pass that draws candidates.
    pub initial: ComputePass,
    /// The lists that some of these come from.
    pub lists: LightLists,
    /// The hash grid with whose reservoirs theirs merge, if it is asked for.
    pub grid: Option<HashGridLight>,
    /// What happens to them then.
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
        let initial = InitialDirect {
            scene: inputs.scene,
            restir: &self.reuse.restir,
            sample_data: inputs.sample_data,
            pilots: pilots.buffer,
            light_lists: &self.lists.buffer,
            reservoirs: self.reuse.reservoirs.current(),
            color: inputs.color,
            counters: inputs.counters,
        };
        recording.pass(&self.initial, &initial, &(), inputs.groups)?;
        if let Some(grid) = &self.grid {
            let (restir, current) = (&self.reuse.restir, self.reuse.reservoirs.current());
            grid.record(
                recording,
                inputs,
                restir,
                current,
                self.reuse.constants.frame,
            )?;
        }
        self.reuse.record(recording, inputs)
    }
}
