//! Direct and indirect light: the two kinds of light, for which resampling has separate passes and reservoirs.

/// The kind of light that a pass or a reservoir belongs to: scattered once (direct) or at least twice (indirect) between
/// emitter and camera. Resampling has separate passes and reservoirs for each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lighting {
    /// Light that is scattered once: an emitter lights the surface that the camera sees.
    Direct,
    /// Light that is scattered at least twice: it reaches the surface that the camera sees by way of another surface.
    Indirect,
}

/// The names of the passes that compute one kind of light, in the order in which the passes run. The integrator makes
/// each pass from the shader file `glsl/restir/passes/NAME.comp`, where NAME is one of these names.
pub struct PassNames {
    /// The name of the pass that draws the candidates of each pixel and selects one of them for the pixel's initial
    /// reservoir.
    pub initial: &'static str,
    /// The name of the pass that merges each pixel's initial reservoir with the reservoir that the pixel's surface had in
    /// the previous frame.
    pub temporal: &'static str,
    /// The name of the pass that merges each pixel's reservoir with reservoirs of neighbouring pixels. The pass can run
    /// several times per frame.
    pub spatial: &'static str,
    /// The name of the pass that adds the light of each pixel's selected sample to the picture. The pass does not run if the
    /// last spatial pass adds this light.
    pub shade: &'static str,
    /// The name of the pass that copies the contents of reservoirs to AOVs (additional channels of the picture) for
    /// debugging. The pass runs only when these AOVs are read.
    pub aovs: &'static str,
}

impl Lighting {
    /// The names of the passes that compute this kind of light. The pass `initial_direct`, for example, draws the candidates
    /// of direct light.
    pub const fn passes(self) -> PassNames {
        match self {
            Self::Direct => PassNames {
                initial: "initial_direct",
                temporal: "temporal_direct",
                spatial: "spatial_direct",
                shade: "shade_direct",
                aovs: "aovs_direct",
            },
            Self::Indirect => PassNames {
                initial: "initial_indirect",
                temporal: "temporal_indirect",
                spatial: "spatial_indirect",
                shade: "shade_indirect",
                aovs: "aovs_indirect",
            },
        }
    }

    /// The name of this kind of light in names of picture channels and in messages: `direct` or `indirect`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Indirect => "indirect",
        }
    }
}
