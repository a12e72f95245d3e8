//! `primary`: the surface through each pixel's centre, for AOVs.

use crate::render::scene_bindings::SceneBindings;

crate::bindings! {
    /// Bindings of the pass.
    pub struct Primary {
        [offers scene: SceneBindings]
        uniform frame,
        uniform previous_camera,
        write primary,
        write counters,
    }
}
