//! `surfaces`: the primary surface of each pixel, and the light that it emits.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct Surfaces {
        [offers scene: SceneBindings]
        uniform restir,
        write sample_data,
        write color,
        write counters,
    }
}
