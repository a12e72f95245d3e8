//! `trace_rays`: rays from a buffer.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct TraceRays {
        [offers scene: SceneBindings]
        read rays,
        write answers,
        write counters,
    }
}
