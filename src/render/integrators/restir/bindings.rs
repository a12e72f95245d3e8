//! Bindings of the passes of resampling. The fields of a structure are the bindings of the shader
//! `glsl/restir/passes/NAME.comp`, matched by name; every pass also binds the scene.

use crate::render::history::History;
use crate::render::light_samplers::LightSamplers;
use crate::render::scene_bindings::SceneBindings;
use crate::render::world_reservoirs::WorldVertices;

crate::bindings! {
    /// Bindings of the pass `surfaces`, which finds the primary surface of each pixel and the light that it emits.
    pub struct Surfaces {
        [offers scene: SceneBindings]
        uniform restir,
        write sample_data,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass `pilots`, which traces the first BSDF ray of each pixel.
    pub struct TracePilots {
        [offers scene: SceneBindings]
        [optional write pilots]
        uniform restir,
        read sample_data,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass `initial_direct`, which draws the candidates of direct light.
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
    /// Bindings of the pass `initial_indirect`, which traces paths as candidates of indirect light. The buffer `reservoirs`
    /// holds the pilots (the first BSDF ray of each pixel) until the pass overwrites them.
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
    /// Bindings of the passes `temporal_direct` and `temporal_indirect`, which merge reservoirs with those of the previous
    /// frame.
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
    /// Bindings of the passes `spatial_direct` and `spatial_indirect`, which merge reservoirs with those of neighbouring
    /// pixels.
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
    /// Bindings of the passes `shade_direct` and `shade_indirect`, which add the light of the selected samples to the
    /// picture.
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
    /// Bindings of the passes `aovs_direct` and `aovs_indirect`, which copy the contents of reservoirs to debug AOVs.
    pub struct ReservoirAovs {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read reservoirs,
        write reservoir_aovs,
        write counters,
    }
}
