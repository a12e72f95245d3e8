//! Light lists: lights that each tile of pixels draws from the light BVH, for the candidates of direct light.

use super::settings::LightBvhSettings;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::render::frame_inputs::FrameInputs;
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::{LIST_RECEIVER_WORDS, TILE, ViewConstants};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass.
    pub struct DrawLightLists {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        write light_lists,
        write counters,
    }
}

/// The pass, where direct light has lists, and the buffer.
pub struct LightLists {
    pass: Option<ComputePass>,
    /// The lists, tile by tile.
    pub buffer: Buffer,
    tiles: [u32; 2],
}

/// Tiles along each axis of a picture.
fn tiles(settings: &LightBvhSettings, view: &ViewConstants) -> [u32; 2] {
    [view.width, view.height].map(|side| side.div_ceil(settings.tile))
}

impl LightLists {
    /// Bytes of the buffer; `settings` are those of the light BVH where direct light has lists.
    pub fn bytes(settings: Option<&LightBvhSettings>, view: &ViewConstants) -> u64 {
        let Some(settings) = settings else {
            // A pass must find a buffer for each binding, even if it does not read it.
            return 4;
        };
        let [x, y] = tiles(settings, view);
        let words = LIST_RECEIVER_WORDS + 2 * settings.list;
        u64::from(x) * u64::from(y) * u64::from(4 * words)
    }

    /// Makes the buffer, and the pass where there are `settings`; `pass` makes a pass by name.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(
        device: &Arc<Device>,
        settings: Option<&LightBvhSettings>,
        view: &ViewConstants,
        pass: impl Fn(&str) -> Result<ComputePass>,
    ) -> Result<Self> {
        let bytes = Self::bytes(settings, view);
        Ok(Self {
            pass: settings.map(|_| pass("light_lists")).transpose()?,
            buffer: Buffer::new(device, "light_lists", bytes, Usage::default())?,
            tiles: settings.map_or([0; 2], |settings| tiles(settings, view)),
        })
    }

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
            counters: inputs.counters,
        };
        let [x, y] = self.tiles.map(|tiles| tiles.div_ceil(TILE));
        recording.pass(pass, &bindings, &(), [x, y, 1])
    }
}
