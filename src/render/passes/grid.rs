//! `grid_claim` and `grid_fill`: the hash grid of reservoirs.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass that decides whose the places are.
    pub struct ClaimGrid {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read grid_points,
        write grid_places,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass that makes reservoirs.
    pub struct FillGrid {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read grid_points,
        write grid_places,
        write grid_reservoirs,
        write counters,
    }
}
