//! `initial_indirect`: candidates of indirect light. Its reservoirs hold the pilots until it writes them.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct InitialIndirect {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read world_cells,
        read world_list,
        read previous_world_points,
        read previous_world_samples,
        write world_points,
        write world_samples,
        write world_keys,
        write reservoirs,
        write color,
        write counters,
    }
}
