//! Settings of direct light (`direct.*`), which is light that is scattered once between its emitter and the camera.

use super::{Resampling, Spatial, Visibility};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The estimator of direct light: light that surfaces scatter exactly once between its emitter and the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DirectMode {
    /// The picture shows no direct light, so that indirect light can be compared alone. This also holds with
    /// `integrator=path-tracing`: light that was scattered exactly once is then missing.
    Off,
    /// Reservoir resampling computes direct light, and reuses samples of neighbours and of earlier frames. With
    /// `integrator=path-tracing`, direct light is path traced instead.
    #[default]
    Restir,
}

/// Settings of direct light: its estimator, its candidates, and the reuse of samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Direct {
    /// The estimator of direct light, which is light that is scattered once: `restir`, or `off` for no direct light. With
    /// `--bounces 0` there is no direct light either.
    pub mode: DirectMode,
    /// The settings of resampling that direct and indirect light both have, here with the values for direct light.
    #[serde(flatten)]
    pub resampling: Resampling,
    /// Number of BSDF candidates per pixel and frame. For such a candidate, a ray is traced in a direction drawn from the
    /// BSDF; if it hits a light, the point that it hits is the candidate. Cost: one ray each. No effect with
    /// `visibility=final`. Unbiased at any value.
    #[schemars(range(min = 0, max = 64))]
    pub bsdf_samples: u32,
    /// Maximum number of BSDF candidates that a pixel draws in addition to `bsdf_samples`. Pixels whose surfaces have a
    /// narrow lobe, such as smooth metal, draw more of them. So do pixels near other pixels whose BSDF candidates found
    /// bright light. Cost: one ray each in these pixels, and a pass. No effect if `bsdf_samples` is 0. Unbiased at any
    /// value.
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
                    // Chosen by the plan `neighbour-confidence`. Without this limit, indirect light has less noise in the
                    // first frames, and not more in later ones.
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
    /// A copy of these settings for path tracing, for which only `mode` has an effect. All other settings are set to their
    /// defaults, so that settings with the same reference picture become equal.
    pub fn of_path_tracing(&self) -> Self {
        Self {
            mode: self.mode,
            ..Self::default()
        }
    }

    /// True if hits of BSDF rays are candidates of direct light: `bsdf_samples` is above 0, and `visibility` is not `final`.
    /// With `final`, such candidates would cause bias: target functions then ignore visibility, but BSDF rays only hit
    /// lights that are visible.
    pub fn draws_bsdf(&self) -> bool {
        self.bsdf_samples > 0 && self.resampling.visibility != Visibility::Final
    }

    /// True if a separate pass traces the pilot of each pixel: its first BSDF ray, whose hit is a candidate of direct light.
    /// The pass is needed if `paths` is true (the paths of indirect light also begin with pilots), or if pilots decide which
    /// pixels draw more BSDF candidates. Always false if direct light has no BSDF candidates.
    pub fn draws_pilots(&self, paths: bool) -> bool {
        self.draws_bsdf() && (paths || self.more_bsdf_samples > 0)
    }
}
