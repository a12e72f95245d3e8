//! Indirect light, which is scattered at least twice: the pass that traces paths with next-event estimation, and the reuse
//! of the samples that it selects.

use super::bindings::InitialIndirect;
use super::pilots::Pilots;
use super::reuse::Reuse;
use crate::Result;
use crate::gpu::{ComputePass, Recording};
use crate::render::frame_inputs::FrameInputs;
use crate::render::world_reservoirs::WorldLight;

/// The passes and reservoirs of indirect light, which is scattered at least twice between emitter and camera. In a frame,
/// these passes run after those of direct light.
pub struct IndirectLight {
    /// The pass `initial_indirect`. For each pixel, it traces paths from the camera. Each hit of an emitter, and each
    /// connection of a path vertex with a light, gives a candidate (a path from the camera to a light). The pass stores
    /// one of the candidates in the pixel's reservoir.
    pub initial: ComputePass,
    /// The world reservoirs, which are the reservoirs of path vertices and are found by their position in the scene. The
    /// path vertices of the next frame reuse the light samples in them. `None` unless the setting is
    /// `indirect.secondary=world-reservoirs`.
    pub world: Option<WorldLight>,
    /// The reservoirs of indirect light, and the passes for their temporal reuse, their spatial reuse and the shading.
    pub reuse: Reuse,
}

impl IndirectLight {
    /// Records the passes of indirect light of one frame. The paths of this light begin with the pilots (the first BSDF ray
    /// of each pixel). The pass `initial_indirect` replaces the pilots in their buffer with reservoirs. So this method takes
    /// `_pilots` by value, and no pass that reads pilots can be recorded after it.
    ///
    /// # Errors
    /// The driver rejects a shader, or the names of the bindings differ from those in the shader.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        _pilots: Pilots<'a>,
    ) -> Result<()> {
        let table = self.world.as_ref().map(|world| &world.table);
        if let Some(table) = table {
            table.begin(recording);
        }
        let initial = InitialIndirect {
            scene: inputs.scene,
            world: &self.world,
            restir: &self.reuse.restir,
            sample_data: inputs.sample_data,
            reservoirs: self.reuse.reservoirs.current(),
            color: inputs.color,
            counters: inputs.counters,
        };
        recording.pass(&self.initial, &initial, &(), inputs.groups)?;
        if let Some(table) = table {
            table.record(recording, &self.reuse.restir, inputs.counters)?;
        }
        self.reuse.record(recording, inputs)
    }
}
