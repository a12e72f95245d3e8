//! `initial_direct`: candidates of direct light.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct InitialDirect {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read pilots,
        read light_lists,
        read grid_points,
        read grid_places,
        read grid_reservoirs,
        write reservoirs,
        write color,
        write counters,
    }
}
