//! Direct and indirect light: the two kinds of light that resampling computes with separate passes and reservoirs.

/// The kind of light that a pass or a reservoir belongs to: scattered once (direct) or at least twice (indirect) between
/// emitter and camera. Resampling has separate passes and reservoirs for each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lighting {
    /// Light that is scattered once: an emitter lights the surface that the camera sees.
    Direct,
    /// Light that is scattered at least twice: it reaches the surface that the camera sees by way of another surface.
    Indirect,
}

/// The names of the passes of direct or of indirect light, in the order in which they run. The shader of a pass is
/// `glsl/restir/passes/NAME.comp`.
pub struct PassNames {
    /// The pass that draws the candidates of each pixel and selects one of them for the initial reservoir.
    pub initial: &'static str,
    /// The pass that merges each pixel's reservoir with the reservoir of the previous frame.
    pub temporal: &'static str,
    /// The pass that merges each pixel's reservoir with reservoirs of neighbouring pixels; it can run several times per
    /// frame.
    pub spatial: &'static str,
    /// The pass that adds the light of each pixel's selected sample to the picture, where no spatial pass adds it.
    pub shade: &'static str,
    /// The pass that copies the contents of reservoirs to debug AOVs (additional channels of the picture), on request.
    pub aovs: &'static str,
}

impl Lighting {
    /// The names of the passes that compute this kind of light.
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

    /// The name of this kind of light in channels of pictures and in messages: `direct` or `indirect`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Indirect => "indirect",
        }
    }
}
