//! Settings of indirect light (`indirect.*`).

use super::{Resampling, ReuseMode};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The estimator of indirect light, which is light that is scattered at least twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IndirectMode {
    /// No indirect light: resampling renders direct light only, for any value of `--bounces`.
    Off,
    /// One path per pixel and frame, without reuse: unbiased, with more noise than `restir`.
    Path,
    /// Reservoir resampling of paths, with reuse over neighbours and frames.
    #[default]
    Restir,
}

/// The reconnection shift, by which another pixel reuses a path from its second vertex on. The variants differ in how they
/// compute the radiance that leaves this vertex towards the other pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shift {
    /// The radiance that leaves the second vertex is assumed to be the same for all viewers and constant over time:
    /// cheapest, but biased where that vertex is not diffuse, and in motion.
    Biased,
    /// The BSDF of the second vertex is evaluated again for each viewer: unbiased.
    #[default]
    Unbiased,
}

/// The way in which the vertices of indirect paths draw light samples (next-event estimation).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Secondary {
    /// One light sample per vertex, from a light that is drawn by power: fastest, with more noise than `ris`.
    Power,
    /// One of `indirect.light_samples` light samples, selected by the target function at the vertex (resampled importance
    /// sampling).
    #[default]
    Ris,
    /// The light sample of `ris`, merged with light samples that nearby vertices selected in the previous frame.
    WorldReservoirs,
}

/// Settings of indirect light: its estimator, its paths and its reuse.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Indirect {
    /// The estimator of indirect light, which is light that is scattered at least twice. With `--bounces 1` or less there is
    /// no indirect light.
    pub mode: IndirectMode,
    /// The way in which the vertices of paths draw light samples (next-event estimation). Unbiased, except for
    /// `world-reservoirs` with `world_reservoirs.mode=published`.
    pub secondary: Secondary,
    /// The settings of resampling, with the values for indirect light.
    #[serde(flatten)]
    pub resampling: Resampling,
    /// The reconnection shift, by which another pixel reuses a path from its second vertex on. `biased` is cheaper, but
    /// biased.
    pub shift: Shift,
    /// Largest ratio between the solid angles of a reused second vertex, as seen from two pixels; beyond it, the path is not
    /// reused. Below 1: no limit. Lower: fewer outliers, less reuse. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub jacobian_limit: f32,
    /// Smallest distance between a pixel's surface and a reused second vertex, as a fraction of the surface's distance from
    /// the camera. Higher: fewer outliers in corners, less reuse. Unbiased at any value.
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
    /// The settings of resampling that take effect for indirect light: one light sample with `secondary=power`, and no reuse
    /// unless `mode=restir`.
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
