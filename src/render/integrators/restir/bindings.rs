//! Bindings of the passes of reservoir resampling. The fields of each structure are the bindings of the shader
//! `glsl/restir/passes/NAME.comp`, where NAME is the name of the pass; they are matched by name. Every pass also binds the
//! scene.

use crate::render::light_samplers::LightSamplers;
use crate::render::scene_bindings::SceneBindings;
use crate::render::world_reservoirs::WorldLight;

crate::bindings! {
    /// Bindings of the pass `surfaces`. It finds the primary surface of each pixel (the surface that the camera sees there),
    /// at which later passes compute direct and indirect light. It also writes the light that this surface emits to the
    /// picture.
    pub struct Surfaces {
        [offers scene: SceneBindings]
        [optional write covered]
        uniform restir,
        write sample_data,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass `pilots`, which traces the pilot of each pixel: its first BSDF ray. Direct and indirect light
    /// share this ray, so that it is traced only once. Later passes read the hit of the ray.
    pub struct TracePilots {
        [offers scene: SceneBindings]
        [optional write pilots]
        uniform restir,
        read sample_data,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass `initial_direct`, which draws the candidates of direct light for each pixel and selects one of
    /// them for the pixel's reservoir.
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
    /// Bindings of the pass `initial_indirect`, which traces paths as candidates of indirect light and selects one of them
    /// for the pixel's reservoir. The paths begin with pilots (the first BSDF ray of each pixel). The pass reads the pilots
    /// from the buffer `reservoirs`, and replaces them there with reservoirs.
    pub struct InitialIndirect {
        [offers scene: SceneBindings]
        [offers world: Option<WorldLight>]
        uniform restir,
        read sample_data,
        write reservoirs,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the passes `temporal_direct` and `temporal_indirect`, which merge the reservoir of each pixel with one of
    /// the previous frame (temporal reuse), so that samples of earlier frames reduce noise. The buffer `history` contains
    /// the reservoirs of the previous frame.
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
    /// Bindings of the passes `spatial_direct` and `spatial_indirect`, which merge the reservoir of each pixel with those of
    /// neighbouring pixels (spatial reuse). They read the reservoirs of all pixels in the buffer `neighbours`, and write the
    /// merged ones to `reservoirs`. A pass may run several times in a frame. Its last run adds the light to `color` if there
    /// is no pass for shading.
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
    /// Bindings of the passes `shade_direct` and `shade_indirect`. For each pixel, they compute the light of the sample in
    /// its reservoir, and add this light to the picture.
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
    /// Bindings of the passes `aovs_direct` and `aovs_indirect`, which copy the contents of reservoirs to the buffer
    /// `reservoir_aovs`. From it, the host makes debug AOVs (additional channels of a picture).
    pub struct ReservoirAovs {
        [offers scene: SceneBindings]
        uniform restir,
        read sample_data,
        read reservoirs,
        write reservoir_aovs,
        write counters,
    }
}
