//! Indirect light: the pass that traces paths with next-event estimation, and the reuse of their samples.

use super::bindings::InitialIndirect;
use super::pilots::Pilots;
use super::reuse::Reuse;
use crate::Result;
use crate::gpu::{ComputePass, Recording};
use crate::render::frame_inputs::FrameInputs;
use crate::render::world_reservoirs::WorldLight;

/// The passes and reservoirs of indirect light, which is scattered at least twice. A frame records them after those of
/// direct light.
pub struct IndirectLight {
    /// The pass `initial_indirect`, which traces a path per pixel and selects one of the lights that it finds.
    pub initial: ComputePass,
    /// The world reservoirs, whose light samples the vertices of paths reuse; unused unless the settings select them.
    pub world: WorldLight,
    /// The reservoirs of indirect light, and the passes that reuse and shade them.
    pub reuse: Reuse,
}

impl IndirectLight {
    /// Records the passes of indirect light. The pilots are the first segments of paths. They are in the reservoirs that
    /// `initial_indirect` overwrites, so this method takes them and no later pass can use them.
    ///
    /// # Errors
    /// The driver rejects a shader, or the names of the bindings differ from those in the shader.
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
