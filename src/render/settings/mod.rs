//! All settings, as one tree of structures. The command `presets` prints the doc comment of each field, and the range of a
//! field is checked when its value is set.

mod direct;
mod environment;
mod indirect;
mod keys;
mod queries;
mod resampling;
mod reservoirs;

pub use direct::{Direct, DirectMode};
pub use environment::EnvironmentSettings;
pub use indirect::{Indirect, IndirectMode, Secondary, Shift};
pub use keys::Description;
pub(crate) use keys::flatten;
pub use resampling::{Candidates, Resampling, ReuseMode, Search, Similar, Spatial, Temporal};
pub use reservoirs::{Arrays, Order, Reservoirs};

pub use super::light_samplers::hash_grid::settings::{GridMode, HashGridSettings};
pub use super::light_samplers::light_bvh::settings::{
    Boxes, Far, LightBvhSettings, LightChoice, Rest, Scale,
};
pub use super::world_reservoirs::settings::{WorldMode, WorldReservoirsSettings, WorldStores};
pub use crate::shader_interface::{Format, Heuristic, Mis, Visibility};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The algorithm that computes the light of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// MIS path tracing: unbiased, the reference for all other estimators.
    #[default]
    PathTracing,
    /// Reservoir resampling: neighbours and frames reuse light samples and paths.
    Restir,
}

/// The treatment of the energy that the specular lobe loses because it models single scattering only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Energy {
    /// The plain model of glTF, with which pictures can be compared with those of other renderers. Rough metals are too
    /// dark, and light-coloured dielectrics are too bright at grazing angles.
    #[default]
    Gltf,
    /// The specular lobe is scaled so that it loses no energy, and the diffuse lobe gets the energy that remains: a surface
    /// that absorbs nothing passes the white furnace test.
    Compensated,
}

/// Russian roulette, which ends dim paths at random and weights up those that continue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Roulette {
    /// Number of the first scattering event after which roulette can end a path; with `integrator=restir`, no path ends
    /// after the first event, because its ray also serves direct light. Cost: higher traces longer paths; lower adds noise.
    /// Unbiased at any value.
    #[schemars(range(min = 0, max = 1000))]
    pub start: u32,
    /// Minimum probability that a path continues. Higher: more rays for dark paths; lower: rare survivors stand out as
    /// fireflies. Unbiased at any value.
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

/// The parts of the shader code that are compiled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// Only the code that the scene requires, as `scene inspect` shows it.
    #[default]
    Auto,
    /// All code, for comparison with `auto`. Three parts stay out unless the scene requires them: code for motion, which
    /// reuses fewer samples, code for large triangles, which rounds points differently, and code for blended surfaces, which
    /// traces more rays.
    Full,
}

/// All settings of a picture: everything besides its scene, time, camera, size, bounces, jitter and seed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// The algorithm that computes the light of a picture: `path-tracing` is the unbiased reference, `restir` reuses samples
    /// of neighbours and frames.
    pub integrator: Integrator,
    /// The MIS heuristic between light sampling and BSDF sampling in path tracing; candidates of resampling always use the
    /// balance heuristic. No effect on bias.
    pub heuristic: Heuristic,
    /// The treatment of the energy that the specular lobe loses because it models single scattering only. `compensated`
    /// costs one table look-up per vertex.
    pub energy: Energy,
    /// Russian roulette, which ends dim paths at random.
    pub roulette: Roulette,
    /// The rotation and the brightness of the environment, if `--environment` gives one.
    pub environment: EnvironmentSettings,
    /// Settings of direct light, which is scattered once.
    pub direct: Direct,
    /// Settings of indirect light, which is scattered at least twice.
    pub indirect: Indirect,
    /// Settings of the light BVH, a tree of lights from which `candidates=light-bvh` draws.
    pub light_bvh: LightBvhSettings,
    /// Settings of the hash grid, which holds reservoirs of direct light in cells of space. Pixels use them if
    /// `direct.candidates` is `hash-grid`.
    pub hash_grid: HashGridSettings,
    /// Settings of world reservoirs, the reservoirs of path vertices. Paths use them if `indirect.secondary` is
    /// `world-reservoirs`.
    pub world_reservoirs: WorldReservoirsSettings,
    /// The layout of reservoirs in memory.
    pub reservoirs: Reservoirs,
    /// The parts of the shader code that are compiled. `full` costs time; the picture is the same.
    pub variant: Variant,
}
