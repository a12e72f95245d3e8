//! The one tree of settings. Each field's doc is what `presets` prints; each range is what checks.

mod keys;

pub use keys::Description;

use super::reservoirs::{Arrays, Format, Order};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which technique makes the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// MIS path tracing: unbiased, the reference.
    #[default]
    PathTracing,
    /// Reservoir resampling: light samples and paths shared by neighbours and frames.
    Restir,
}

/// How lights are picked for initial candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Candidates {
    /// What fits the scene: `power`.
    #[default]
    Auto,
    /// Every light alike.
    Uniform,
    /// By area × luminance, with a uniform share.
    Power,
}

/// Whose reservoirs a pixel merges with its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reuse {
    /// Nobody's.
    None,
    /// That of the last frame.
    Temporal,
    /// Those of neighbours.
    Spatial,
    /// That of the last frame, then those of neighbours.
    #[default]
    Spatiotemporal,
}

impl Reuse {
    /// Whether the last frame is used.
    pub fn is_temporal(self) -> bool {
        matches!(self, Self::Temporal | Self::Spatiotemporal)
    }

    /// Whether neighbours are used.
    pub fn is_spatial(self) -> bool {
        matches!(self, Self::Spatial | Self::Spatiotemporal)
    }
}

/// How a merge weighs its techniques against each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mis {
    /// By confidence alone: cheapest; biased where neighbours cannot make what the pixel needs.
    Constant,
    /// The balance heuristic over all: unbiased, least noise, cost grows with the square.
    Balance,
    /// The balance heuristic between the pixel and one neighbour at a time: unbiased, cheaper.
    Pairwise,
    /// Pairwise with a share kept by the pixel's own sample: unbiased, guards against bad neighbours.
    #[default]
    Defensive,
}

/// Where visibility enters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Visibility {
    /// Nowhere: shadows are missing. Biased, for comparisons only.
    None,
    /// Where the chosen sample is shaded: one ray. For direct light unbiased, noisy in shadows, and without
    /// BSDF samples. Paths of indirect light are traced, so for them the same as `initial`.
    Final,
    /// Of the initial survivor, and where the chosen sample is shaded. Biased, dark.
    Initial,
    /// In every target function: one ray each with `mis=balance`, two a merge by pairs. Unbiased.
    #[default]
    Weights,
}

/// How neighbours are looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Search {
    /// As many tries as neighbours wanted; those refused are missing.
    Random,
    /// More tries, until enough are found.
    #[default]
    Greedy,
}

/// Temporal reuse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Temporal {
    /// Confidence of history at most. Unit: initial reservoirs. Higher: less noise, but errors stay
    /// longer and frames resemble each other. Unbiased at any value.
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
    /// Passes, each over the results of the one before. Cost: proportional. Unbiased at any value.
    #[schemars(range(min = 1, max = 8))]
    pub passes: u32,
    /// Neighbours wanted a pass. Cost: three targets each and no rays, since a merge by pairs traces two
    /// however many there are; with `mis=balance` targets and rays grow with the square. Unbiased at any
    /// value.
    #[schemars(range(min = 0, max = 16))]
    pub neighbours: u32,
    /// Radius of the disc they are drawn from, half of them within a quarter of it. Unit: pixels. Lower:
    /// neighbours more alike, so first frames have less noise; higher: they share fewer samples, so that
    /// later frames lose more of it.
    #[schemars(range(min = 0.5, max = 1000.0))]
    pub radius: f32,
    /// How they are looked for.
    pub search: Search,
    /// Tries for each neighbour wanted, with `search=greedy`.
    #[schemars(range(min = 1, max = 16))]
    pub tries: u32,
    /// Confidence of a neighbour at most. Unit: initial reservoirs. Lower: later frames have less noise,
    /// since a merge trusts the pixel's own history, which is about its own surface, more than theirs;
    /// higher: the first few frames have. Unbiased at any value.
    #[schemars(range(min = 1, max = 500))]
    pub confidence_cap: u32,
}

impl Default for Spatial {
    fn default() -> Self {
        Self {
            passes: 1,
            neighbours: 3,
            radius: 10.0,
            search: Search::Greedy,
            tries: 3,
            confidence_cap: 128,
        }
    }
}

/// Which surfaces are alike enough to share samples. Stricter: less noise at edges, fewer
/// neighbours. Unbiased at any value, since no sample is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Similar {
    /// Largest angle between shading normals. Unit: degrees.
    #[schemars(range(min = 0.0, max = 180.0))]
    pub normal: f32,
    /// Largest difference of depths, as a share of the pixel's own.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub depth: f32,
    /// Whether materials must be the same.
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

/// Resampling of direct light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Direct {
    /// How lights are picked for candidates. No effect on bias.
    pub candidates: Candidates,
    /// Light candidates a pixel and frame. Cost: one target each, no ray. Unbiased at any value.
    #[schemars(range(min = 1, max = 1024))]
    pub light_samples: u32,
    /// BSDF candidates a pixel and frame. Cost: one ray each. Unbiased at any value.
    #[schemars(range(min = 0, max = 64))]
    pub bsdf_samples: u32,
    /// BSDF candidates more, at most, where lobes are narrow or pixels around find bright light. Cost:
    /// one ray each in a few pixels, and a pass. Not drawn where `bsdf_samples` are not. Unbiased at any
    /// value.
    #[schemars(range(min = 0, max = 256))]
    pub more_bsdf_samples: u32,
    /// Whose reservoirs a pixel merges with its own. Unbiased at any value.
    pub reuse: Reuse,
    /// How a merge weighs its techniques. `constant` is biased.
    pub mis: Mis,
    /// Where visibility enters. `initial` and `none` are biased.
    pub visibility: Visibility,
    /// Temporal reuse.
    pub temporal: Temporal,
    /// Spatial reuse.
    pub spatial: Spatial,
    /// Which surfaces are alike enough to share samples.
    pub similar: Similar,
}

impl Default for Direct {
    fn default() -> Self {
        Self {
            candidates: Candidates::Auto,
            light_samples: 10,
            bsdf_samples: 1,
            more_bsdf_samples: 16,
            reuse: Reuse::default(),
            mis: Mis::default(),
            visibility: Visibility::default(),
            temporal: Temporal::default(),
            spatial: Spatial {
                // By the plan `neighbour-confidence`; indirect light has less noise in first frames, and no
                // more in later ones, without a limit.
                confidence_cap: 8,
                ..Spatial::default()
            },
            similar: Similar::default(),
        }
    }
}

/// How one kind of light is resampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resampling {
    /// How lights are picked.
    pub candidates: Candidates,
    /// Points on lights that a pixel, or a vertex of a path, chooses from.
    pub light_samples: u32,
    /// Whose reservoirs a pixel merges with its own.
    pub reuse: Reuse,
    /// How a merge weighs its techniques.
    pub mis: Mis,
    /// Where visibility enters.
    pub visibility: Visibility,
    /// Temporal reuse.
    pub temporal: Temporal,
    /// Spatial reuse.
    pub spatial: Spatial,
    /// Which surfaces are alike enough to share samples.
    pub similar: Similar,
}

impl Direct {
    /// How it is resampled.
    pub fn resampling(&self) -> Resampling {
        Resampling {
            candidates: self.candidates,
            light_samples: self.light_samples,
            reuse: self.reuse,
            mis: self.mis,
            visibility: self.visibility,
            temporal: self.temporal,
            spatial: self.spatial,
            similar: self.similar,
        }
    }

    /// Whether BSDF rays make candidates. They have visibility in them, which targets without it have
    /// not: then they would be another's samples.
    pub fn draws_bsdf(&self) -> bool {
        self.bsdf_samples > 0 && self.visibility != Visibility::Final
    }

    /// Whether the first of them are drawn beforehand: to tell where more are needed, or because they begin
    /// `paths` too.
    pub fn draws_pilots(&self, paths: bool) -> bool {
        self.draws_bsdf() && (paths || self.more_bsdf_samples > 0)
    }
}

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

/// How reservoirs lie in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Reservoirs {
    /// What a reservoir stores. `full` costs memory, `compact` look-ups.
    pub format: Format,
    /// In which order pixels lie. No effect on the picture.
    pub order: Order,
    /// How the words of reservoirs alternate. No effect on the picture.
    pub arrays: Arrays,
}

/// How next-event estimation and BSDF sampling share the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Heuristic {
    /// In proportion to the densities: never far from the best.
    #[default]
    Balance,
    /// In proportion to the squared densities: less noise where one technique is much the better.
    Power,
}

/// What becomes of light that single scattering loses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Energy {
    /// glTF's plain model: compares with other renderers; dark on rough metals, too bright on
    /// light dielectrics at grazing angles.
    #[default]
    Gltf,
    /// The specular lobe scaled to keep all light, the diffuse one under what it leaves: passes the
    /// white furnace.
    Compensated,
}

/// Russian roulette.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Roulette {
    /// Scattering events before roulette begins; with `integrator=restir` it leaves out the first one, whose
    /// ray serves direct light too. Unit: events. Cost: higher traces longer paths; lower adds noise. Unbiased
    /// at any value.
    #[schemars(range(min = 0, max = 1000))]
    pub start: u32,
    /// Least probability that a path goes on. Higher wastes rays on dark paths, lower lets rare
    /// survivors stand out as fireflies. Unbiased at any value.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub floor: f32,
}

impl Default for Roulette {
    fn default() -> Self {
        Self {
            start: 3,
            floor: 0.05,
        }
    }
}

/// Every setting of a picture that is not its size, camera or seed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Which technique makes the image.
    pub integrator: Integrator,
    /// How light sampling and BSDF sampling share the light in path tracing; candidates of resampling always
    /// share it by the balance heuristic. No effect on bias.
    pub heuristic: Heuristic,
    /// What becomes of light that single scattering loses. `compensated` costs one table look-up a
    /// vertex.
    pub energy: Energy,
    /// Russian roulette.
    pub roulette: Roulette,
    /// Resampling of direct light.
    pub direct: Direct,
    /// Resampling of indirect light.
    pub indirect: Indirect,
    /// How reservoirs lie in memory.
    pub reservoirs: Reservoirs,
}

impl Settings {
    /// What of these concerns path tracing, for path tracing: what references are made with.
    pub fn of_path_tracing(&self) -> Self {
        Self {
            integrator: Integrator::PathTracing,
            heuristic: self.heuristic,
            energy: self.energy,
            roulette: self.roulette,
            ..Self::default()
        }
    }
}
