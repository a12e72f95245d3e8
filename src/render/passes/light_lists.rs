//! `light_lists`: lights that tiles of pixels draw from the light BVH.

use crate::render::scene_bindings::SceneBindings;

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
