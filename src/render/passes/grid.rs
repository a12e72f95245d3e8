//! `grid_mark`, `grid_fill` and `grid_direct`: the hash grid's reservoirs, and their merge with those of pixels.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass that marks cells.
    pub struct MarkGrid {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read grid_cells,
        write grid_wanted,
    }
}

crate::bindings! {
    /// Bindings of the pass that makes reservoirs.
    pub struct FillGrid {
        [offers scene: SceneBindings]
        uniform restir,
        read grid_cells,
        read grid_points,
        read grid_wanted,
        write grid_reservoirs,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass that merges them.
    pub struct MergeGrid {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read grid_cells,
        read grid_points,
        read grid_reservoirs,
        write reservoirs,
        write counters,
    }
}
