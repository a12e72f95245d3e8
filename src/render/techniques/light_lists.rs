//! Light lists: lights that each tile of pixels draws from the light BVH, for the candidates of direct light.

use super::reuse::FrameInputs;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Recording};
use crate::layouts::{LIST_RECEIVER_WORDS, TILE};
use crate::render::passes::DrawLightLists;
use crate::render::settings::{Candidates, LightBvhSettings, Settings};

/// The pass, where direct light has lists, and the buffer.
pub struct LightLists {
    /// The pass that draws them.
    pub pass: Option<ComputePass>,
    /// The lists, tile by tile.
    pub buffer: Buffer,
    /// Tiles along each axis.
    pub tiles: [u32; 2],
}

impl Settings {
    /// Whether candidates of direct light come from light lists.
    pub fn has_light_lists(&self) -> bool {
        self.direct.resampling.candidates == Candidates::LightBvh && self.light_bvh.tile > 1
    }
}

impl LightBvhSettings {
    /// Tiles along each axis of a picture.
    pub fn tiles(&self, width: u32, height: u32) -> [u32; 2] {
        [width, height].map(|side| side.div_ceil(self.tile))
    }

    /// Bytes of the lists of so many tiles.
    pub fn list_bytes(&self, [x, y]: [u32; 2]) -> u64 {
        u64::from(x) * u64::from(y) * u64::from(4 * (LIST_RECEIVER_WORDS + 2 * self.list))
    }
}

impl LightLists {
    /// Records the pass, if there is one.
    ///
    /// # Errors
    /// A binding that the pass does not have.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        restir: &'a Buffer,
    ) -> Result<()> {
        let Some(pass) = &self.pass else {
            return Ok(());
        };
        let bindings = DrawLightLists {
            scene: inputs.scene,
            restir,
            sample_data: inputs.sample_data,
            light_lists: &self.buffer,
        };
        let [x, y] = self.tiles.map(|tiles| tiles.div_ceil(TILE));
        recording.pass(pass, &bindings, &(), [x, y, 1])
    }
}
