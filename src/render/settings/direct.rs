//! Settings of direct light.

use super::{Candidates, Mis, Resampling, Reuse, Similar, Spatial, Temporal, Visibility};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Resampling of direct light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Direct {
    /// How lights are picked for candidates. No effect on bias.
    pub candidates: Candidates,
    /// Light candidates a pixel and frame. Cost: one target each, no ray. Unbiased at any value.
    #[schemars(range(min = 1, max = 1024))]
    pub light_samples: u32,
    /// BSDF candidates a pixel and frame. Cost: one ray each. Unbiased at any value.
    #[schemars(range(min = 0, max = 64))]
    pub bsdf_samples: u32,
    /// BSDF candidates more, at most, where lobes are narrow or pixels around find bright light. Cost:
    /// one ray each in a few pixels, and a pass. Not drawn where `bsdf_samples` are not. Unbiased at any
    /// value.
    #[schemars(range(min = 0, max = 256))]
    pub more_bsdf_samples: u32,
    /// Whose reservoirs a pixel merges with its own. Unbiased at any value.
    pub reuse: Reuse,
    /// How a merge weighs its techniques. `constant` is biased.
    pub mis: Mis,
    /// Where visibility enters. `initial` and `none` are biased.
    pub visibility: Visibility,
    /// Temporal reuse.
    pub temporal: Temporal,
    /// Spatial reuse.
    pub spatial: Spatial,
    /// Which surfaces are alike enough to share samples.
    pub similar: Similar,
}

impl Default for Direct {
    fn default() -> Self {
        Self {
            candidates: Candidates::Auto,
            light_samples: 10,
            bsdf_samples: 1,
            more_bsdf_samples: 16,
            reuse: Reuse::default(),
            mis: Mis::default(),
            visibility: Visibility::default(),
            temporal: Temporal::default(),
            spatial: Spatial {
                // By the plan `neighbour-confidence`; indirect light has less noise in first frames, and no
                // more in later ones, without a limit.
                confidence_cap: 8,
                ..Spatial::default()
            },
            similar: Similar::default(),
        }
    }
}

impl Direct {
    /// How it is resampled.
    pub fn resampling(&self) -> Resampling {
        Resampling {
            candidates: self.candidates,
            light_samples: self.light_samples,
            reuse: self.reuse,
            mis: self.mis,
            visibility: self.visibility,
            temporal: self.temporal,
            spatial: self.spatial,
            similar: self.similar,
        }
    }

    /// Whether BSDF rays make candidates. They have visibility in them, which targets without it have
    /// not: then they would be another's samples.
    pub fn draws_bsdf(&self) -> bool {
        self.bsdf_samples > 0 && self.visibility != Visibility::Final
    }

    /// Whether the first of them are drawn beforehand: to tell where more are needed, or because they begin
    /// `paths` too.
    pub fn draws_pilots(&self, paths: bool) -> bool {
        self.draws_bsdf() && (paths || self.more_bsdf_samples > 0)
    }
}
