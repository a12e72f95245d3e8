//! The two kinds of light that are resampled, each with its own passes.

use super::settings::{DirectMode, IndirectMode, Integrator, Settings};

/// A kind of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From lights to the surfaces that the camera sees.
    Direct,
    /// Over other surfaces.
    Indirect,
}

/// The names of the passes of a kind of light, in their order.
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

impl Kind {
    /// The names of its passes.
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

    /// Whether resampling with these settings and this maximum number of scattering events includes it.
    pub fn is_wanted(self, settings: &Settings, bounces: u32) -> bool {
        match self {
            Self::Direct => bounces > 0 && settings.direct.mode != DirectMode::Off,
            Self::Indirect => bounces > 1 && settings.indirect.mode != IndirectMode::Off,
        }
    }

    /// Whether its candidates go to reservoirs.
    pub fn is_shared(self, settings: &Settings) -> bool {
        self == Self::Direct || settings.indirect.mode == IndirectMode::Restir
    }

    /// Whether frames with these settings and this maximum number of scattering events have reservoirs of it.
    pub fn has_reservoirs(self, settings: &Settings, bounces: u32) -> bool {
        settings.integrator == Integrator::Restir
            && self.is_wanted(settings, bounces)
            && self.is_shared(settings)
    }

    /// The name in channels and settings.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Indirect => "indirect",
        }
    }
}
