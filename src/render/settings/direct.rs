//! Settings of direct light (`direct.*`).

use super::{Resampling, Spatial, Visibility};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The estimator of direct light, which is light that is scattered once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DirectMode {
    /// No direct light, so that indirect light can be compared alone. Path tracing also leaves out light that was scattered
    /// once.
    Off,
    /// Reservoir resampling, with reuse over neighbours and frames. With `integrator=path-tracing`, direct light is path
    /// traced.
    #[default]
    Restir,
}

/// Settings of direct light: its estimator, its candidates and its reuse.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Direct {
    /// The estimator of direct light, which is light that is scattered once. With `--bounces 0` there is no direct light.
    pub mode: DirectMode,
    /// The settings of resampling, with the values for direct light.
    #[serde(flatten)]
    pub resampling: Resampling,
    /// Number of BSDF candidates per pixel and frame, which are hits of rays that the BSDF draws. Cost: one ray each. No
    /// effect with `visibility=final`. Unbiased at any value.
    #[schemars(range(min = 0, max = 64))]
    pub bsdf_samples: u32,
    /// Maximum number of additional BSDF candidates per pixel. Pixels with narrow lobes draw more of them, and so do pixels
    /// near which BSDF candidates find bright light. Cost: one ray each in these pixels, and a pass. No effect if
    /// `bsdf_samples` is 0. Unbiased at any value.
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
    /// A copy of these settings for path tracing, in which all settings without an effect on path tracing have their
    /// defaults.
    pub fn of_path_tracing(&self) -> Self {
        Self {
            mode: self.mode,
            ..Self::default()
        }
    }

    /// True if hits of BSDF rays are candidates of direct light. With `visibility=final` they are not, because they would
    /// cause bias: target functions then ignore visibility, but BSDF rays find only visible light.
    pub fn draws_bsdf(&self) -> bool {
        self.bsdf_samples > 0 && self.resampling.visibility != Visibility::Final
    }

    /// True if a separate pass traces the first BSDF candidate of each pixel (the pilot). It does if pilots also begin the
    /// paths of indirect light (`paths` is true), or if they decide which pixels draw more BSDF candidates. Always false if
    /// direct light has no BSDF candidates.
    pub fn draws_pilots(&self, paths: bool) -> bool {
        self.draws_bsdf() && (paths || self.more_bsdf_samples > 0)
    }
}
