//! Settings of indirect light.

use super::{Resampling, ReuseMode};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The estimator of indirect light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IndirectMode {
    /// No indirect light: direct light only, for any value of `--bounces`.
    Off,
    /// One path per pixel, without reuse: unbiased, noisy.
    Path,
    /// Reservoir resampling of paths, with reuse over neighbours and frames.
    #[default]
    Restir,
}

/// The reconnection shift: the way in which another pixel takes over a path of indirect light, at its second vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shift {
    /// The radiance that leaves the second vertex is assumed to be the same for all viewers and constant over time: cheapest;
    /// biased where that vertex is not diffuse, and in motion.
    Biased,
    /// The BSDF of the second vertex is evaluated again: unbiased.
    #[default]
    Unbiased,
}

/// Next-event estimation at the vertices of indirect paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Secondary {
    /// One light sample, drawn by power.
    Power,
    /// One of `indirect.light_samples` light samples, resampled by the target function at the vertex.
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
    /// Next-event estimation at the vertices of paths. Unbiased, except for `world-reservoirs` with
    /// `world_reservoirs.mode=published`.
    pub secondary: Secondary,
    /// The resampling of indirect light.
    #[serde(flatten)]
    pub resampling: Resampling,
    /// The shift by which another pixel takes over a path. `biased` is biased.
    pub shift: Shift,
    /// Largest ratio between the solid angles of a reused second vertex, as seen from two pixels; below 1: no limit. Lower:
    /// fewer outliers, less reuse. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub jacobian_limit: f32,
    /// Smallest distance to a reused second vertex, as a fraction of the pixel's distance from the camera. Higher: fewer
    /// outliers in corners, less reuse. Unbiased at any value.
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
    /// The resampling of indirect light, with the parts that `mode` and `secondary` do not use switched off.
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
