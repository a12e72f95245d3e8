//! `path_trace`: samples of MIS path tracing.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct PathTrace {
        [offers scene: SceneBindings]
        uniform frame,
        write sums,
        write counters,
    }
}
