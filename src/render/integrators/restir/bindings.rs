//! Bindings of the passes of resampling. The fields of a structure are the bindings of the shader
//! `glsl/restir/passes/NAME.comp`, matched by name; every pass also binds the scene.

use crate::render::history::History;
use crate::render::light_samplers::LightSamplers;
use crate::render::scene_bindings::SceneBindings;
use crate::render::world_reservoirs::WorldVertices;

crate::bindings! {
    /// `surfaces`: the primary surface of each pixel, and the light that it emits.
    pub struct Surfaces {
        [offers scene: SceneBindings]
        uniform restir,
        write sample_data,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// `pilots`: the first BSDF ray of each pixel.
    pub struct TracePilots {
        [offers scene: SceneBindings]
        [optional write pilots]
        uniform restir,
        read sample_data,
        write counters,
    }
}

crate::bindings! {
    /// `initial_direct`: candidates of direct light.
    pub struct InitialDirect {
        [offers scene: SceneBindings]
        [offers samplers: LightSamplers]
        [optional read pilots]
        uniform restir,
        read sample_data,
        write reservoirs,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// `initial_indirect`: candidates of indirect light. Its reservoirs hold the pilots until it writes them.
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

crate::bindings! {
    /// `temporal_direct`, `temporal_indirect`: merges with the previous frame.
    pub struct Temporal {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read previous_sample_data,
        read history,
        write reservoirs,
        write counters,
    }
}

crate::bindings! {
    /// `spatial_direct`, `spatial_indirect`: merges with neighbours.
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

crate::bindings! {
    /// `shade_direct`, `shade_indirect`: the light of the selected samples.
    pub struct Shade {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read reservoirs,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// `aovs_direct`, `aovs_indirect`: the contents of reservoirs, for debugging.
    pub struct ReservoirAovs {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read reservoirs,
        write reservoir_aovs,
        write counters,
    }
}
