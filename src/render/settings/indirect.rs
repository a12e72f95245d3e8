//! Settings of indirect light (`indirect.*`), which is light that is scattered at least twice between its emitter and the
//! camera.

use super::{Resampling, ReuseMode};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The estimator of indirect light: light that surfaces scatter at least twice between its emitter and the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IndirectMode {
    /// Resampling renders no indirect light, for any value of `--bounces`. Path tracing ignores this setting.
    Off,
    /// Each pixel traces one path per frame and does not reuse paths of neighbours or of earlier frames. This is unbiased,
    /// with more noise than `restir`.
    Path,
    /// Reservoir resampling of paths: pixels reuse the paths of their neighbours and of earlier frames.
    #[default]
    Restir,
}

/// The reconnection shift, by which a pixel reuses the path of another pixel from its second vertex on (the first surface
/// that the path hits after the one that the camera sees). The variants differ in how they compute the radiance that leaves
/// this vertex towards the reusing pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shift {
    /// The radiance that leaves the second vertex is assumed to be the same in all directions and at all times. This variant
    /// is cheapest. It is biased where the surface at the second vertex is not diffuse, and where something moves.
    Biased,
    /// The BSDF at the second vertex is evaluated again, for the direction towards each pixel that reuses the path. This is
    /// unbiased.
    #[default]
    Unbiased,
}

/// The way in which each vertex of an indirect path, after the first surface, draws a light sample (next-event estimation).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Secondary {
    /// Each vertex draws only one light sample, by the method of `indirect.candidates`. This is fastest, with more noise
    /// than `ris`.
    Power,
    /// A vertex draws `indirect.light_samples` light samples, and selects one of them by the target function at the vertex
    /// (resampled importance sampling).
    #[default]
    Ris,
    /// A vertex draws and selects a light sample as with `ris`. It then merges this sample with light samples that nearby
    /// vertices selected in the previous frame.
    WorldReservoirs,
}

/// Settings of indirect light: its estimator, the light samples at path vertices, and the reuse of paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Indirect {
    /// The estimator of indirect light, which is light that is scattered at least twice: `restir`, `path` for paths without
    /// reuse, or `off`. With `--bounces 1` or less there is no indirect light.
    pub mode: IndirectMode,
    /// The light samples that each vertex of an indirect path, after the first surface, draws (next-event estimation).
    /// `power`: the vertex draws one sample. `ris`: it draws several and selects one of them. `world-reservoirs`: it also
    /// merges samples of the previous frame. Unbiased, except for `world-reservoirs` with `world_reservoirs.mode=published`.
    pub secondary: Secondary,
    /// The settings of resampling that direct and indirect light both have, here with the values for indirect light.
    #[serde(flatten)]
    pub resampling: Resampling,
    /// The reconnection shift, by which a pixel reuses the path of another pixel from that path's second vertex on.
    /// `unbiased` evaluates the BSDF at this vertex again, for the direction towards the reusing pixel. `biased` does not:
    /// it costs less time, but is biased.
    pub shift: Shift,
    /// Limit of reuse of a path between two pixels or frames. Seen from the surface of each of the two, a small area around
    /// the path's second vertex covers a solid angle. The path is not reused if one of these solid angles is more than this
    /// many times the other. Below 1: no limit. Lower: fewer outliers, less reuse. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub jacobian_limit: f32,
    /// Limit of reuse of a path between two pixels or frames. The path is not reused if its second vertex is too close to
    /// the surface of one of the two: closer than this fraction of that surface's distance from the camera, or of the height of an orthographic picture.
    /// 0: no limit.
    /// Higher: fewer outliers in corners, less reuse. Unbiased at any value.
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
    /// A copy of the settings of resampling with the values that indirect light really uses: one light sample with
    /// `secondary=power`, and no reuse unless `mode=restir`. The passes of indirect light are made from this copy.
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
