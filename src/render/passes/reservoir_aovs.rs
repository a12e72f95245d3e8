//! `aovs_direct`, `aovs_indirect`: the contents of reservoirs, for debugging.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct ReservoirAovs {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read reservoirs,
        write reservoir_aovs,
        write counters,
    }
}
