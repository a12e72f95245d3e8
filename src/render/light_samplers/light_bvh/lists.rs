//! Light lists: in each frame, one pixel of each tile of pixels draws a list of lights from the light BVH, a tree of lights.
//! Pixels near the tile draw their candidates of direct light from this list, so that they need not walk through the tree.

use super::settings::LightBvhSettings;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Recording, Usage};
use crate::render::frame_inputs::FrameInputs;
use crate::render::light_samplers::{Kind, LightSampler, Made, SamplerInputs};
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::{LIST_CONTEXT_WORDS, TILE, ViewConstants};

crate::bindings! {
    /// Bindings of the pass `light_lists`, in which one pixel of each tile draws the lights of the tile's list. Pixels near
    /// the tile draw their candidates of direct light from this list.
    pub struct DrawLightLists {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        write light_lists,
        write counters,
    }
}

/// The light lists of a renderer, one list of lights for each tile of pixels: the pass that draws them from the light BVH in
/// each frame, and the buffer that stores them. Pixels draw their candidates of direct light from the lists, so that they
/// need not walk through the tree.
pub struct LightLists {
    pass: ComputePass,
    /// The lists, one per tile, in rows of tiles from the top. Each list begins with the shading point for which its lights
    /// were drawn; pixels need it to compute the probability densities of their candidates. Then it has a fixed number of
    /// entries: the index of a light, and the probability with which it was drawn.
    lists: Buffer,
    tiles: [u32; 2],
}

/// The number of tiles along the width and along the height of the picture; each tile has one light list. Tiles at the right
/// and lower edges may be cut off.
fn tiles(settings: &LightBvhSettings, view: &ViewConstants) -> [u32; 2] {
    [view.width, view.height].map(|side| side.div_ceil(settings.tile))
}

/// The size, in bytes, of the buffer that stores the light lists of all tiles: for each tile, the shading point that drew
/// the list, then two words per light.
fn bytes(settings: &LightBvhSettings, view: &ViewConstants) -> u64 {
    let [x, y] = tiles(settings, view);
    let words = LIST_CONTEXT_WORDS + 2 * settings.list;
    u64::from(x) * u64::from(y) * u64::from(4 * words)
}

impl LightLists {
    /// The functions with which `LightSamplers` computes the size of the buffer of light lists, and makes this buffer and
    /// its pass.
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
