//! Light lists: the lights that each tile of pixels draws from the light BVH, for the candidates of direct light.

use super::settings::LightBvhSettings;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Recording, Usage};
use crate::render::frame_inputs::FrameInputs;
use crate::render::light_samplers::{Kind, LightSampler, Made, SamplerInputs};
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::{LIST_CONTEXT_WORDS, TILE, ViewConstants};

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

/// The pass and its buffer.
pub struct LightLists {
    pass: ComputePass,
    /// The lists, tile by tile.
    lists: Buffer,
    tiles: [u32; 2],
}

/// Tiles along each axis of a picture.
fn tiles(settings: &LightBvhSettings, view: &ViewConstants) -> [u32; 2] {
    [view.width, view.height].map(|side| side.div_ceil(settings.tile))
}

/// The size of the buffer, in bytes.
fn bytes(settings: &LightBvhSettings, view: &ViewConstants) -> u64 {
    let [x, y] = tiles(settings, view);
    let words = LIST_CONTEXT_WORDS + 2 * settings.list;
    u64::from(x) * u64::from(y) * u64::from(4 * words)
}

impl LightLists {
    /// The registration of light lists.
    pub(in crate::render::light_samplers) const KIND: Kind = Kind {
        bytes: |settings, view, _| {
            let lists = settings.light_lists.into_iter();
            lists
                .map(|lists| ("light_lists", bytes(lists, view)))
                .collect()
        },
        make: Self::make,
    };

    fn make(inputs: &SamplerInputs<'_>) -> Result<Made> {
        let Some(settings) = inputs.settings.light_lists else {
            return Ok(None);
        };
        let bytes = bytes(settings, inputs.view);
        Ok(Some(Box::new(Self {
            pass: (inputs.pass)("light_lists")?,
            lists: Buffer::new(inputs.device, "light_lists", bytes, Usage::default())?,
            tiles: tiles(settings, inputs.view),
        })))
    }
}

impl LightSampler for LightLists {
    fn buffers(&self) -> Vec<(&'static str, &Buffer)> {
        vec![("light_lists", &self.lists)]
    }

    fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        restir: &'a Buffer,
    ) -> Result<()> {
        let bindings = DrawLightLists {
            scene: inputs.scene,
            restir,
            sample_data: inputs.sample_data,
            light_lists: &self.lists,
            counters: inputs.counters,
        };
        let [x, y] = self.tiles.map(|tiles| tiles.div_ceil(TILE));
        recording.pass(&self.pass, &bindings, &(), [x, y, 1])
    }
}
