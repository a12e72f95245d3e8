//! Settings of indirect light.

use super::{Resampling, ReuseMode};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The estimator of indirect light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IndirectMode {
    /// Not at all: direct light only, whatever `--bounces` says.
    Off,
    /// By one path a pixel, without reuse: unbiased, noisy.
    Path,
    /// By paths that neighbours and frames share.
    #[default]
    Restir,
}

/// The reconnection shift: the way in which another pixel takes over a path of indirect light, at its second vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shift {
    /// The radiance that leaves the second vertex is taken to be the same for all viewers, and not to change: cheapest; biased
    /// where that vertex is not matt, and in motion.
    Biased,
    /// The second vertex' BSDF is evaluated again: unbiased.
    #[default]
    Unbiased,
}

/// Next-event estimation at the vertices of indirect paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Secondary {
    /// One point on a light.
    Power,
    /// One of `indirect.light_samples` points, by what the vertex would reflect of each.
    #[default]
    Ris,
    /// As `ris`, merged with the samples that nearby vertices selected in the previous frame.
    WorldReservoirs,
}

/// Resampling of indirect light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Indirect {
    /// The estimator of indirect light; with `--bounces 1` or less there is none.
    pub mode: IndirectMode,
    /// Next-event estimation at the vertices of paths. Unbiased, except for `world-reservoirs` with their mode `published`.
    pub secondary: Secondary,
    /// Its resampling.
    #[serde(flatten)]
    pub resampling: Resampling,
    /// The shift by which another pixel takes over a path. `biased` is biased.
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
}

impl Default for Indirect {
    fn default() -> Self {
        Self {
            mode: IndirectMode::default(),
            secondary: Secondary::default(),
            resampling: Resampling::default(),
            shift: Shift::default(),
            jacobian_limit: 10.0,
            min_distance: 0.0,
        }
    }
}

impl Indirect {
    /// Its resampling, as far as `mode` and `secondary` leave it.
    pub fn effective_resampling(&self) -> Resampling {
        let mut resampling = self.resampling;
        if self.secondary == Secondary::Power {
            resampling.light_samples = 1;
        }
        if self.mode != IndirectMode::Restir {
            resampling.reuse = ReuseMode::None;
        }
        resampling
    }
}
