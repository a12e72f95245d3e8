//! Direct and indirect light, each with separate passes.

/// The number of surfaces that scattered the light: one, or more. Resampling has separate passes for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lighting {
    /// Light that reaches the visible surface directly from a light.
    Direct,
    /// Light that reaches the visible surface by way of at least one other surface.
    Indirect,
}

/// The names of the passes of direct or indirect light, in their order.
pub struct PassNames {
    /// Candidates.
    pub initial: &'static str,
    /// Reuse over time.
    pub temporal: &'static str,
    /// Reuse by neighbours.
    pub spatial: &'static str,
    /// Shading.
    pub shade: &'static str,
    /// Debug AOVs.
    pub aovs: &'static str,
}

impl Lighting {
    /// The names of the passes.
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

    /// The name in channels and settings.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Indirect => "indirect",
        }
    }
}
