//! Settings of resampling for direct and for indirect light: candidates, reuse, MIS, visibility, and the similarity of
//! neighbours.

use crate::shader_interface::{Mis, Visibility};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The distribution from which light candidates are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Candidates {
    /// `light-bvh` if the scene has 64 lights or more that are neither rare nor infinitely far away, and they form more than
    /// one emitter group; otherwise `power`.
    #[default]
    Auto,
    /// All lights with the same probability.
    Uniform,
    /// By area × luminance, mixed with a uniform fraction.
    Power,
    /// Lights that matter at the shading point, by a light BVH, and a fraction by power. For indirect light, the second
    /// vertices of paths draw from the light BVH, and later ones by power.
    LightBvh,
    /// By power; the reservoirs of pixels are then merged with those of a hash grid on the scene's surfaces. For indirect
    /// light, `hash-grid` means `power`.
    HashGrid,
}

/// The reservoirs that a pixel merges with its candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReuseMode {
    /// No reservoirs: no reuse.
    None,
    /// The reservoir of the previous frame.
    Temporal,
    /// The reservoirs of neighbours.
    Spatial,
    /// The reservoir of the previous frame, then those of neighbours.
    #[default]
    Spatiotemporal,
}

impl ReuseMode {
    /// True if the previous frame is used.
    pub fn is_temporal(self) -> bool {
        matches!(self, Self::Temporal | Self::Spatiotemporal)
    }

    /// True if neighbours are used.
    pub fn is_spatial(self) -> bool {
        matches!(self, Self::Spatial | Self::Spatiotemporal)
    }
}

/// The search for neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Search {
    /// `neighbours` random pixels; pixels that are not similar enough are left out.
    Random,
    /// Up to `tries` × `neighbours` random pixels, until `neighbours` similar ones are found.
    #[default]
    Greedy,
}

/// Temporal reuse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Temporal {
    /// Maximum confidence of history. Unit: initial reservoirs. Higher: less noise, but errors stay
    /// longer and frames are more correlated. Unbiased at any value.
    #[schemars(range(min = 0, max = 500))]
    pub confidence_cap: u32,
}

impl Default for Temporal {
    fn default() -> Self {
        Self { confidence_cap: 16 }
    }
}

/// Spatial reuse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Spatial {
    /// Number of passes; each reuses the results of the previous one. Cost: proportional. Unbiased at any value.
    #[schemars(range(min = 1, max = 8))]
    pub passes: u32,
    /// Maximum number of neighbours per pass. Cost: three targets each and no rays, since a pairwise merge traces two rays for
    /// any number of neighbours; with `mis=balance`, targets and rays grow with the square. Unbiased at any value.
    #[schemars(range(min = 0, max = 16))]
    pub neighbours: u32,
    /// Maximum number of neighbours in the first pass where a surface has no history: in the first frame, where something has
    /// come into view, and everywhere with `temporal.confidence_cap=0`. If `neighbours` is larger, `neighbours` is used
    /// instead. No effect unless `reuse=spatiotemporal`, and none with `mis=balance`, whose cost grows with the square. Higher:
    /// less noise there. Cost: as for `neighbours`, in all pixels of the first frame and few pixels of later frames. Unbiased
    /// at any value.
    #[schemars(range(min = 0, max = 16))]
    pub neighbours_without_history: u32,
    /// Radius of the disc in which neighbours are drawn; half of them are drawn within a quarter of the radius. Unit: pixels.
    /// Lower: more similar neighbours, so first frames have less noise; higher: neighbours have fewer samples in common, so
    /// later frames have less noise.
    #[schemars(range(min = 0.5, max = 1000.0))]
    pub radius: f32,
    /// The search for neighbours.
    pub search: Search,
    /// Number of random pixels per neighbour that are tried, with `search=greedy`.
    #[schemars(range(min = 1, max = 16))]
    pub tries: u32,
    /// Maximum confidence of a neighbour. Unit: initial reservoirs. Lower: less noise in later frames, because the history of
    /// the pixel, which fits its surface best, weighs more; higher: less noise in the first few frames. Unbiased at any value.
    #[schemars(range(min = 1, max = 500))]
    pub confidence_cap: u32,
}

impl Default for Spatial {
    fn default() -> Self {
        Self {
            passes: 1,
            neighbours: 3,
            neighbours_without_history: 12,
            radius: 10.0,
            search: Search::Greedy,
            tries: 3,
            confidence_cap: 128,
        }
    }
}

/// Limits within which surfaces are similar enough for reuse. Stricter: less noise at edges, fewer neighbours. Unbiased at any
/// value, since similarity does not depend on samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Similar {
    /// Largest angle between shading normals. Unit: degrees.
    #[schemars(range(min = 0.0, max = 180.0))]
    pub normal: f32,
    /// Largest difference of depths, as a fraction of the pixel's depth.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub depth: f32,
    /// True if materials must be the same.
    pub material: bool,
}

impl Default for Similar {
    fn default() -> Self {
        Self {
            normal: 25.0,
            depth: 0.1,
            material: true,
        }
    }
}

/// The settings of resampling, for direct or for indirect light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Resampling {
    /// The distribution from which light candidates are drawn. No effect on bias.
    pub candidates: Candidates,
    /// Number of light candidates per pixel and frame; for indirect light, the number of light samples from which each vertex
    /// of a path selects one, unless `secondary=power`. Cost: one target each, no ray. Unbiased at any value.
    #[schemars(range(min = 1, max = 1024))]
    pub light_samples: u32,
    /// Minimum probability of a ray to a rare emitter for a pixel; the probability itself for a vertex of a path. The dimmest
    /// emitters are rare if they have less than 1/96 of all power together and less than 1/8 of the mean power each: in
    /// resampling, brighter but hidden emitters would win against them. Rare emitters have separate candidates, without reuse.
    /// 0: they are resampled as all other emitters. No effect unless `visibility=weights`. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 0.95))]
    pub rare_lights: f32,
    /// The reservoirs that a pixel merges with its candidates. Unbiased at any value; for indirect light in motion, only paths
    /// that reach a light from their second vertex are reused over time.
    pub reuse: ReuseMode,
    /// The MIS weights of a merge. `constant` is biased.
    pub mis: Mis,
    /// The step at which visibility is tested. `initial` and `none` are biased. Candidates of indirect light are traced paths,
    /// which never reach hidden surfaces: for them only `weights` is unbiased.
    pub visibility: Visibility,
    /// Temporal reuse.
    pub temporal: Temporal,
    /// Spatial reuse.
    pub spatial: Spatial,
    /// Limits within which surfaces are similar enough for reuse.
    pub similar: Similar,
}

impl Resampling {
    /// True if rare lights have separate candidates.
    pub fn sets_rare_lights_apart(&self) -> bool {
        self.rare_lights > 0.0 && self.visibility == Visibility::Weights
    }

    /// The maximum number of neighbours where a surface has no history.
    pub fn most_neighbours(&self) -> u32 {
        let Spatial {
            neighbours,
            neighbours_without_history,
            ..
        } = self.spatial;
        if self.reuse == ReuseMode::Spatiotemporal && self.mis != Mis::Balance {
            neighbours.max(neighbours_without_history)
        } else {
            neighbours
        }
    }
}

impl Default for Resampling {
    /// The defaults of indirect light; those of direct light differ.
    fn default() -> Self {
        Self {
            candidates: Candidates::Auto,
            light_samples: 8,
            rare_lights: 0.1,
            reuse: ReuseMode::default(),
            mis: Mis::default(),
            visibility: Visibility::default(),
            temporal: Temporal::default(),
            spatial: Spatial::default(),
            similar: Similar::default(),
        }
    }
}
