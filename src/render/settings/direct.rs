//! Settings of direct light.

use super::{Resampling, Spatial, Visibility};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The estimator of direct light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DirectMode {
    /// No direct light, for comparisons of indirect light: path tracing also leaves out light that was scattered once.
    Off,
    /// Reservoir resampling with reuse over neighbours and frames; with path tracing, direct light is path traced.
    #[default]
    Restir,
}

/// Resampling of direct light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Direct {
    /// The estimator of direct light; with `--bounces 0` there is none.
    pub mode: DirectMode,
    /// The resampling of direct light.
    #[serde(flatten)]
    pub resampling: Resampling,
    /// Number of BSDF candidates per pixel and frame. Cost: one ray each. Unbiased at any value.
    #[schemars(range(min = 0, max = 64))]
    pub bsdf_samples: u32,
    /// Maximum number of additional BSDF candidates, for narrow lobes and for pixels near which BSDF candidates find bright
    /// light. Cost: one ray each in a few pixels, and a pass. No effect if `bsdf_samples` is 0. Unbiased at any value.
    #[schemars(range(min = 0, max = 256))]
    pub more_bsdf_samples: u32,
}

impl Default for Direct {
    fn default() -> Self {
        Self {
            mode: DirectMode::default(),
            resampling: Resampling {
                light_samples: 10,
                spatial: Spatial {
                    // By the plan `neighbour-confidence`; indirect light has less noise in first frames, and
                    // no more in later ones, without a limit.
                    confidence_cap: 8,
                    ..Spatial::default()
                },
                ..Resampling::default()
            },
            bsdf_samples: 1,
            more_bsdf_samples: 16,
        }
    }
}

impl Direct {
    /// These settings for path tracing, with defaults for those that do not apply to it.
    pub fn of_path_tracing(&self) -> Self {
        Self {
            mode: self.mode,
            ..Self::default()
        }
    }

    /// True if BSDF rays are candidates. They find only visible light, so they would not cover the support of targets without
    /// visibility.
    pub fn draws_bsdf(&self) -> bool {
        self.bsdf_samples > 0 && self.resampling.visibility != Visibility::Final
    }

    /// True if a separate pass traces the first BSDF candidates: because they also begin `paths`, or because they decide where
    /// more are needed.
    pub fn draws_pilots(&self, paths: bool) -> bool {
        self.draws_bsdf() && (paths || self.more_bsdf_samples > 0)
    }
}
