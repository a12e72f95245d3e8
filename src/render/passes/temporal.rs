//! `temporal_direct`, `temporal_indirect`: merges with the previous frame.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct Temporal {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read previous_sample_data,
        read history,
        write reservoirs,
        write counters,
    }
}
