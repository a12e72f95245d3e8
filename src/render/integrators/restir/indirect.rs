//! Indirect light: paths with next-event estimation, then reuse.

use super::bindings::InitialIndirect;
use super::pilots::Pilots;
use super::reuse::Reuse;
use crate::Result;
use crate::gpu::{ComputePass, Recording};
use crate::render::frame_inputs::FrameInputs;
use crate::render::world_reservoirs::WorldLight;

/// The passes and reservoirs of indirect light.
pub struct IndirectLight {
    /// The pass that traces paths.
    pub initial: ComputePass,
    /// Light samples that vertices of paths reuse.
    pub world: WorldLight,
    /// The reuse of its candidates.
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
        _pilots: Pilots<'a>,
    ) -> Result<()> {
        let world = &self.world;
        world.table.begin(recording);
        let initial = InitialIndirect {
            scene: inputs.scene,
            vertices: &world.vertices,
            restir: &self.reuse.restir,
            sample_data: inputs.sample_data,
            world_cells: &world.table.cells,
            world_list: &world.table.list,
            world_keys: &world.table.keys,
            reservoirs: self.reuse.reservoirs.current(),
            color: inputs.color,
            counters: inputs.counters,
        };
        recording.pass(&self.initial, &initial, &(), inputs.groups)?;
        world
            .table
            .record(recording, &self.reuse.restir, inputs.counters)?;
        self.reuse.record(recording, inputs)
    }
}
