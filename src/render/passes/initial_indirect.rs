//! `initial_indirect`: candidates of indirect light. Its reservoirs hold the pilots until it writes them.

use crate::render::history::History;
use crate::render::scene_bindings::SceneBindings;
use crate::render::world_vertices::WorldVertices;

crate::bindings! {
    /// Bindings of the pass.
    pub struct InitialIndirect {
        [offers scene: SceneBindings]
        [offers vertices: History<WorldVertices>]
        uniform restir,
        read sample_data,
        read world_cells,
        read world_list,
        write world_keys,
        write reservoirs,
        write color,
        write counters,
    }
}
