//! Settings of resampling that direct and indirect light both have: candidates, reuse, MIS weights, visibility, and the
//! similarity of neighbours.

use crate::shader_interface::{Mis, Visibility};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The method that draws the lights of light candidates (points on lights, among which resampling selects one).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Candidates {
    /// The scene decides: `light-bvh` if it has at least 64 lights and they form more than one emitter group, otherwise
    /// `power`. Emissive triangles with common corners form one group, and each other light is a group of its own.
    /// Infinitely distant lights do not count. Rare lights (the dimmest ones) do not count either if they have separate
    /// candidates.
    #[default]
    Auto,
    /// All lights of the scene have the same probability.
    Uniform,
    /// With probability 0.9, a light is drawn in proportion to its power (area × luminance for a triangle). Otherwise, all
    /// lights have the same probability.
    Power,
    /// Candidates are drawn from the light BVH, a tree of lights, with probabilities that depend on the shading point
    /// (`light_bvh.choice` and `light_bvh.far`). A fraction of them, `light_bvh.uniform_share`, is drawn among all lights
    /// instead, with the probabilities of `light_bvh.rest`. For indirect light, the second vertices of paths draw from the
    /// tree in this way, and later vertices draw all candidates among all lights.
    LightBvh,
    /// Lights are drawn by power, and the pixel selects one sample. It then merges this sample with reservoirs of a hash
    /// grid, which stores reservoirs in cells of space. For indirect light, `hash-grid` means `power`.
    HashGrid,
}

/// The reservoirs that a pixel merges with its initial reservoir (the one with the pixel's own candidate of this frame).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReuseMode {
    /// A pixel merges no other reservoirs: each frame uses only its own candidates.
    None,
    /// A pixel merges the reservoir that its surface had in the previous frame, but no reservoirs of neighbours.
    Temporal,
    /// A pixel merges the reservoirs of neighbouring pixels in the same frame, but not the reservoir of the previous frame.
    Spatial,
    /// A pixel merges first the reservoir that its surface had in the previous frame, then the reservoirs of neighbouring
    /// pixels.
    #[default]
    Spatiotemporal,
}

impl ReuseMode {
    /// True if a pixel merges the reservoir that its surface had in the previous frame.
    pub fn is_temporal(self) -> bool {
        matches!(self, Self::Temporal | Self::Spatiotemporal)
    }

    /// True if a pixel merges the reservoirs of neighbouring pixels.
    pub fn is_spatial(self) -> bool {
        matches!(self, Self::Spatial | Self::Spatiotemporal)
    }
}

/// The way in which a pixel searches for neighbours whose surfaces are similar to its own, so that it can merge their
/// reservoirs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Search {
    /// The search tries `neighbours` random pixels near the pixel. It leaves out those whose surfaces are not similar
    /// enough, so fewer may be merged.
    Random,
    /// The search tries random pixels near the pixel until it has found `neighbours` similar ones, but at most `tries` ×
    /// `neighbours` pixels.
    #[default]
    Greedy,
}

/// Settings of temporal reuse, in which a pixel merges the reservoir that its surface had in the previous frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Temporal {
    /// Maximum confidence of the history in a merge. The history is the reservoir that the pixel's surface had in the
    /// previous frame. Unit: the confidence of one initial reservoir. Higher: less noise of direct light, but errors stay
    /// longer and frames are more correlated. 0: no history. Unbiased at any value.
    #[schemars(range(min = 0, max = 500))]
    pub confidence_cap: u32,
}

impl Default for Temporal {
    fn default() -> Self {
        Self { confidence_cap: 16 }
    }
}

/// Settings of spatial reuse, in which a pixel merges the reservoirs of neighbouring pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Spatial {
    /// Number of spatial passes per frame. Each pass merges reservoirs that the pass before it has written. Cost:
    /// proportional to the number. Unbiased at any value.
    #[schemars(range(min = 1, max = 8))]
    pub passes: u32,
    /// Maximum number of neighbours whose reservoirs a pixel merges per pass. Cost: three evaluations of the target function
    /// per neighbour, but no additional rays: a pairwise merge traces two rays for any number of neighbours. With
    /// `mis=balance`, evaluations and rays grow with the square of the number. Unbiased at any value.
    #[schemars(range(min = 0, max = 16))]
    pub neighbours: u32,
    /// Maximum number of neighbours that a pixel merges in the first pass if its surface has no history. This is so in the
    /// first frame, on surfaces that the previous frame did not show, and everywhere with `temporal.confidence_cap=0`. With
    /// `--jitter on`, it is also so in a part of the pixels of every frame, even if nothing moves: the previous frame showed
    /// another surface at their random points. If `neighbours` is larger, the maximum is `neighbours` here too. No effect
    /// unless `reuse=spatiotemporal`, and none with `mis=balance`. Higher: less noise on these surfaces. Cost: as for
    /// `neighbours`, in all pixels of the first frame, and in the pixels without history of later frames. Unbiased at any
    /// value.
    #[schemars(range(min = 0, max = 16))]
    pub neighbours_without_history: u32,
    /// Radius of the disc around a pixel in which its neighbours are drawn; half of them are drawn within a quarter of the
    /// radius. Unit: pixels. Lower: more similar neighbours, so first frames have less noise; higher: neighbours have fewer
    /// samples in common, so later frames have less noise. Unbiased at any value.
    #[schemars(range(min = 0.5, max = 1000.0))]
    pub radius: f32,
    /// The search for neighbours with similar surfaces among random pixels: `greedy` tries another pixel in place of one
    /// that is not similar enough, `random` leaves it out. Unbiased either way.
    pub search: Search,
    /// Maximum number of random pixels that are tried per neighbour with `search=greedy`, until one is similar. Higher: more
    /// neighbours are found at edges and on small surfaces. Unbiased at any value.
    #[schemars(range(min = 1, max = 16))]
    pub tries: u32,
    /// Maximum confidence of a neighbour's reservoir in a merge. Unit: the confidence of one initial reservoir. Lower: less
    /// noise in later frames, because the history of the pixel itself, which fits its surface best, has more weight; higher:
    /// less noise in the first frames. Unbiased at any value.
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

/// Limits within which two surfaces are similar enough that one reuses the samples of the other. Stricter limits: less noise
/// at edges, but fewer neighbours. Unbiased at any value, since similarity does not depend on samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Similar {
    /// Two surfaces are similar, so that one may reuse the samples of the other, only if the angle between their normals is
    /// at most this. Unit: degrees. On materials with a normal map the geometric normals are compared, on others the shading
    /// normals. Lower: less noise at edges, but fewer neighbours.
    #[schemars(range(min = 0.0, max = 180.0))]
    pub normal: f32,
    /// Two surfaces are similar, so that one may reuse the samples of the other, only if their distances from the camera
    /// differ by at most this fraction of the distance of the surface that reuses samples (with an orthographic camera: of
    /// the picture's height). Lower: less noise at edges, but fewer neighbours.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub depth: f32,
    /// True if a surface may reuse the samples of another one only if both have the same material; false if the material
    /// does not matter.
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

/// The settings of resampling that direct light and indirect light both have. Each kind of light has separate values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Resampling {
    /// The method that draws the lights of light candidates, the points on lights among which resampling selects one. No
    /// effect on bias.
    pub candidates: Candidates,
    /// Number of light candidates of each pixel in each frame. For indirect light, it is the number of light samples from
    /// which each vertex of a path selects one, unless `secondary=power`. Cost: one evaluation of the target function per
    /// candidate, no ray. Unbiased at any value.
    #[schemars(range(min = 1, max = 1024))]
    pub light_samples: u32,
    /// Minimum probability that a pixel traces a shadow ray to a rare emitter in a frame; a path vertex traces it with
    /// exactly this probability. Rare emitters are the dimmest ones: together they have less than 1/96 of all power, and
    /// each has less than 1/8 of the mean power. They have separate candidates without reuse, because brighter but hidden
    /// emitters would win against them in resampling. 0: they are resampled like all other emitters. No effect unless
    /// `visibility=weights`. Unbiased at any value.
    #[schemars(range(min = 0.0, max = 0.95))]
    pub rare_lights: f32,
    /// The reservoirs that a pixel merges with its initial reservoir: that of the previous frame, those of neighbours, both,
    /// or none. Unbiased at any value. If anything besides the camera moves, paths of indirect light are reused from the
    /// previous frame only if they reach a light directly from their second vertex.
    pub reuse: ReuseMode,
    /// The MIS weights of samples in a merge of reservoirs. `constant` is cheapest, but biased; the others are unbiased. The
    /// cost of `pairwise` and `defensive` is proportional to the number of neighbours. `balance` has the least noise, but
    /// its cost grows with the square of the number of neighbours.
    pub mis: Mis,
    /// The step of resampling at which shadow rays test whether samples are visible. For direct light, `weights` and `final`
    /// are unbiased; `initial` and `none` are biased. For indirect light, only `weights` is unbiased. There, `final` means
    /// the same as `initial`, because the candidates are traced paths, whose visibility is already tested.
    pub visibility: Visibility,
    /// Settings of temporal reuse, in which a pixel merges the reservoir that its surface had in the previous frame.
    pub temporal: Temporal,
    /// Settings of spatial reuse, in which a pixel merges the reservoirs of neighbouring pixels.
    pub spatial: Spatial,
    /// Limits within which two surfaces are similar enough that one reuses the samples of the other.
    pub similar: Similar,
}

impl Resampling {
    /// True if rare lights (lights of the dimmest emitters) have separate candidates, which are not reused. If false, they
    /// are resampled like all other lights.
    pub fn sets_rare_lights_apart(&self) -> bool {
        self.rare_lights > 0.0 && self.visibility == Visibility::Weights
    }

    /// The maximum number of neighbours that a pixel merges in any spatial pass: the larger of `neighbours` and
    /// `neighbours_without_history` if the latter has an effect, otherwise `neighbours`. It is a specialisation constant of
    /// the shaders, because it decides the size of their arrays.
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
    /// The default values for indirect light. `Direct::default` replaces some of them by values for direct light.
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
