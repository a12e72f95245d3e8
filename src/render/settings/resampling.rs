//! Settings of resampling for direct and for indirect light: candidates, reuse, MIS, visibility, and the similarity of
//! neighbours.

use crate::shader_interface::{Mis, Visibility};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The distribution from which the lights of light candidates are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Candidates {
    /// `light-bvh` if the scene has 64 lights or more that are neither rare (the dimmest ones) nor infinitely far away, and
    /// if these lights form more than one emitter group (triangles with common corners form one group); otherwise `power`.
    #[default]
    Auto,
    /// All lights have the same probability.
    Uniform,
    /// Lights are drawn in proportion to area × luminance, mixed with a uniform fraction.
    Power,
    /// Lights are drawn by their expected contribution at the shading point, from a tree of lights, and a fraction by power.
    /// For indirect light, the second vertices of paths draw from the tree, and later vertices by power.
    LightBvh,
    /// Lights are drawn by power; pixels then merge their selected sample with reservoirs of a hash grid on the scene's
    /// surfaces. For indirect light, `hash-grid` means `power`.
    HashGrid,
}

/// The reservoirs with which a pixel merges its initial reservoir.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReuseMode {
    /// No reservoirs: each frame uses only its own candidates.
    None,
    /// The reservoir that the surface of the pixel had in the previous frame.
    Temporal,
    /// The reservoirs of neighbouring pixels.
    Spatial,
    /// The reservoir of the previous frame, and then the reservoirs of neighbouring pixels.
    #[default]
    Spatiotemporal,
}

impl ReuseMode {
    /// True if pixels merge the reservoir of the previous frame.
    pub fn is_temporal(self) -> bool {
        matches!(self, Self::Temporal | Self::Spatiotemporal)
    }

    /// True if pixels merge the reservoirs of neighbours.
    pub fn is_spatial(self) -> bool {
        matches!(self, Self::Spatial | Self::Spatiotemporal)
    }
}

/// The way in which a pixel searches for neighbours with similar surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Search {
    /// `neighbours` random pixels are tried, and those that are not similar enough are left out.
    Random,
    /// Random pixels are tried until `neighbours` similar ones are found, at most `tries` × `neighbours` pixels.
    #[default]
    Greedy,
}

/// Temporal reuse: a pixel merges the reservoir that its surface had in the previous frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Temporal {
    /// Maximum confidence of the history, which is the reservoir of the previous frame. Unit: initial reservoirs. Higher:
    /// less noise, but errors stay longer and frames are more correlated. Unbiased at any value.
    #[schemars(range(min = 0, max = 500))]
    pub confidence_cap: u32,
}

impl Default for Temporal {
    fn default() -> Self {
        Self { confidence_cap: 16 }
    }
}

/// Spatial reuse: a pixel merges reservoirs of neighbouring pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Spatial {
    /// Number of spatial passes per frame; each pass merges the results of the previous one. Cost: proportional to the
    /// number. Unbiased at any value.
    #[schemars(range(min = 1, max = 8))]
    pub passes: u32,
    /// Maximum number of neighbours that a pixel merges per pass. Cost: three evaluations of the target function each, but
    /// no additional rays: a pairwise merge traces two rays for any number of neighbours. With `mis=balance`, evaluations
    /// and rays grow with the square of the number. Unbiased at any value.
    #[schemars(range(min = 0, max = 16))]
    pub neighbours: u32,
    /// Maximum number of neighbours in the first pass for a surface without history: in the first frame, where something has
    /// come into view, and everywhere with `temporal.confidence_cap=0`. If `neighbours` is larger, `neighbours` is used
    /// instead. No effect unless `reuse=spatiotemporal`, and none with `mis=balance`, whose cost grows with the square.
    /// Higher: less noise there. Cost: as for `neighbours`, in all pixels of the first frame and few pixels of later frames.
    /// Unbiased at any value.
    #[schemars(range(min = 0, max = 16))]
    pub neighbours_without_history: u32,
    /// Radius of the disc from which neighbours are drawn; half of them are drawn within a quarter of the radius. Unit:
    /// pixels. Lower: more similar neighbours, so first frames have less noise; higher: neighbours have fewer samples in
    /// common, so later frames have less noise.
    #[schemars(range(min = 0.5, max = 1000.0))]
    pub radius: f32,
    /// The search for neighbours among random pixels: `greedy` replaces pixels that are not similar enough, `random` leaves
    /// them out.
    pub search: Search,
    /// Maximum number of random pixels that are tried per neighbour with `search=greedy`. Higher: more neighbours are found.
    #[schemars(range(min = 1, max = 16))]
    pub tries: u32,
    /// Maximum confidence of a neighbour's reservoir. Unit: initial reservoirs. Lower: less noise in later frames, because
    /// the history of the pixel, which fits its surface best, weighs more; higher: less noise in the first frames. Unbiased
    /// at any value.
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

/// Limits within which two surfaces are similar enough to reuse each other's samples. Stricter: less noise at edges, fewer
/// neighbours. Unbiased at any value, since similarity does not depend on samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Similar {
    /// Largest angle between the normals of similar surfaces: shading normals, or geometric normals under a normal map.
    /// Lower: less noise at edges, fewer neighbours. Unit: degrees.
    #[schemars(range(min = 0.0, max = 180.0))]
    pub normal: f32,
    /// Largest difference between the distances of similar surfaces from the camera, as a fraction of the pixel's distance.
    /// Lower: less noise at edges, fewer neighbours.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub depth: f32,
    /// True if similar surfaces must have the same material.
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

/// The settings of resampling that direct light and indirect light both have, with separate values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Resampling {
    /// The distribution from which the lights of light candidates are drawn. No effect on bias.
    pub candidates: Candidates,
    /// Number of light candidates per pixel and frame; for indirect light, the number of light samples from which each
    /// vertex of a path selects one, unless `secondary=power`. Cost: one evaluation of the target function each, no ray.
    /// Unbiased at any value.
    #[schemars(range(min = 1, max = 1024))]
    pub light_samples: u32,
    /// Minimum probability of a ray to a rare emitter for a pixel; the probability itself for a vertex of a path. The
    /// dimmest emitters are rare if they have less than 1/96 of all power together and less than 1/8 of the mean power each:
    /// in resampling, brighter but hidden emitters would win against them. Rare emitters have separate candidates, without
    /// reuse. 0: they are resampled like all other emitters. No effect unless `visibility=weights`. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 0.95))]
    pub rare_lights: f32,
    /// The reservoirs with which a pixel merges its initial reservoir. Unbiased at any value; for indirect light in motion,
    /// only paths that reach a light from their second vertex are reused over time.
    pub reuse: ReuseMode,
    /// The MIS weights of the samples in a merge of reservoirs. `constant` is biased.
    pub mis: Mis,
    /// The step at which a shadow ray tests the visibility of samples. `initial` and `none` are biased. Candidates of
    /// indirect light are traced paths, which never reach hidden surfaces: for them only `weights` is unbiased.
    pub visibility: Visibility,
    /// Temporal reuse: the merge with the reservoir of the previous frame.
    pub temporal: Temporal,
    /// Spatial reuse: the merge with the reservoirs of neighbouring pixels.
    pub spatial: Spatial,
    /// Limits within which two surfaces are similar enough to reuse each other's samples.
    pub similar: Similar,
}

impl Resampling {
    /// True if rare lights (lights of the dimmest emitters) have separate candidates, which are not reused.
    pub fn sets_rare_lights_apart(&self) -> bool {
        self.rare_lights > 0.0 && self.visibility == Visibility::Weights
    }

    /// The maximum number of neighbours that any pixel merges in a spatial pass, whether its surface has a history or not.
    /// Shaders are specialised for this number.
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
    /// The defaults of indirect light; `Direct::default` changes them for direct light.
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
