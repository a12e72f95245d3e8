//! `pilots`: the first BSDF ray of each pixel.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct TracePilots {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        write pilots,
        write counters,
    }
}
