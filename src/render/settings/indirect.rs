//! Settings of indirect light.

use super::{Candidates, Mis, Resampling, Reuse, Similar, Spatial, Temporal, Visibility};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How indirect light is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IndirectMode {
    /// Not at all: direct light only, whatever `--bounces` says.
    Off,
    /// By a path a pixel, shared with nobody: unbiased, noisy.
    Path,
    /// By paths that neighbours and frames share.
    #[default]
    Restir,
}

/// How another pixel takes over a path of indirect light, at its second vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shift {
    /// What leaves the second vertex is taken to be the same for all, and not to change: cheapest; biased
    /// where that vertex is not matt, and in motion.
    Biased,
    /// The second vertex' BSDF is evaluated again: unbiased.
    #[default]
    Unbiased,
}

/// How the vertices of indirect paths look for lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Secondary {
    /// One point on a light.
    Power,
    /// One of `indirect.light_samples` points, by what the vertex would reflect of each.
    #[default]
    Ris,
}

/// Resampling of indirect light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Indirect {
    /// How indirect light is found; with `--bounces 1` or less there is none.
    pub mode: IndirectMode,
    /// How lights are picked at the vertices of paths. No effect on bias.
    pub candidates: Candidates,
    /// How these vertices look for lights. Unbiased either way.
    pub secondary: Secondary,
    /// Points on lights that each vertex chooses from, with `secondary=ris`. Cost: one target each, no
    /// ray. Unbiased at any value.
    #[schemars(range(min = 1, max = 1024))]
    pub light_samples: u32,
    /// Whose reservoirs a pixel merges with its own. Unbiased at any value, in motion too: there only
    /// paths that reach a light from their second vertex are carried on.
    pub reuse: Reuse,
    /// How a merge weighs its techniques. `constant` is biased.
    pub mis: Mis,
    /// Where visibility enters. Paths are traced, so that without it in the weights light is missing:
    /// only `weights` is unbiased.
    pub visibility: Visibility,
    /// How another pixel takes over a path. `biased` is biased.
    pub shift: Shift,
    /// Largest ratio between two pixels' views of a second vertex, by the solid angle that it has in
    /// each, with which they share it; below 1: any. Lower: fewer outliers, less reuse. Unbiased at any
    /// value.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub jacobian_limit: f32,
    /// Least distance to a second vertex that is shared, as a share of the pixel's distance from the
    /// camera. Higher: fewer outliers in corners, less reuse. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub min_distance: f32,
    /// Temporal reuse.
    pub temporal: Temporal,
    /// Spatial reuse.
    pub spatial: Spatial,
    /// Which surfaces are alike enough to share samples.
    pub similar: Similar,
}

impl Default for Indirect {
    fn default() -> Self {
        Self {
            mode: IndirectMode::default(),
            candidates: Candidates::Auto,
            secondary: Secondary::default(),
            light_samples: 8,
            reuse: Reuse::default(),
            mis: Mis::default(),
            visibility: Visibility::default(),
            shift: Shift::default(),
            jacobian_limit: 10.0,
            min_distance: 0.0,
            temporal: Temporal::default(),
            spatial: Spatial::default(),
            similar: Similar::default(),
        }
    }
}

impl Indirect {
    /// How it is resampled.
    pub fn resampling(&self) -> Resampling {
        Resampling {
            candidates: self.candidates,
            light_samples: match self.secondary {
                Secondary::Power => 1,
                Secondary::Ris => self.light_samples,
            },
            reuse: match self.mode {
                IndirectMode::Restir => self.reuse,
                IndirectMode::Off | IndirectMode::Path => Reuse::None,
            },
            mis: self.mis,
            visibility: self.visibility,
            temporal: self.temporal,
            spatial: self.spatial,
            similar: self.similar,
        }
    }
}
