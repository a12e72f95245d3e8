//! `shade_direct`, `shade_indirect`: the light of the selected samples.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct Shade {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read reservoirs,
        write color,
        write counters,
    }
}
