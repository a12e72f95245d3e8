//! `spatial_direct`, `spatial_indirect`: merges with neighbours.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct Spatial {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read neighbours,
        write reservoirs,
        write color,
        write counters,
    }
}
