//! All settings, as one tree. The command `presets` prints the doc of each field, and the range of a field is checked when its
//! value is set.

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

/// The integrator that makes the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// MIS path tracing: unbiased, the reference.
    #[default]
    PathTracing,
    /// Reservoir resampling: neighbours and frames reuse light samples and paths.
    Restir,
}

/// The treatment of light that single scattering loses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Energy {
    /// glTF's plain model: compares with other renderers; dark on rough metals, too bright on
    /// light dielectrics at grazing angles.
    #[default]
    Gltf,
    /// The specular lobe is scaled to keep all light, and the diffuse lobe to the remaining light: passes the white furnace.
    Compensated,
}

/// Russian roulette.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Roulette {
    /// Number of scattering events before roulette begins; with `integrator=restir`, the first event does not count, because
    /// its ray also serves direct light. Unit: events. Cost: higher traces longer paths; lower adds noise. Unbiased at any
    /// value.
    #[schemars(range(min = 0, max = 1000))]
    pub start: u32,
    /// Minimum probability that a path continues. Higher wastes rays on dark paths, lower lets rare survivors stand out as
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

/// The code that shaders contain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// The code that the scene requires, as `scene inspect` shows it.
    #[default]
    Auto,
    /// All code, for comparison; except code for motion, which reuses fewer samples, and code for large triangles, which rounds
    /// points differently.
    Full,
}

/// Every setting of a picture that is not its size, camera or seed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// The integrator that makes the picture.
    pub integrator: Integrator,
    /// The MIS heuristic between light sampling and BSDF sampling in path tracing; candidates of resampling always use the
    /// balance heuristic. No effect on bias.
    pub heuristic: Heuristic,
    /// The treatment of light that single scattering loses. `compensated` costs one table look-up per
    /// vertex.
    pub energy: Energy,
    /// Russian roulette.
    pub roulette: Roulette,
    /// The environment, if `--environment` gives one.
    pub environment: EnvironmentSettings,
    /// Resampling of direct light.
    pub direct: Direct,
    /// Resampling of indirect light.
    pub indirect: Indirect,
    /// The light BVH, from which `candidates=light-bvh` draws.
    pub light_bvh: LightBvhSettings,
    /// The hash grid, with `direct.candidates=hash-grid`.
    pub hash_grid: HashGridSettings,
    /// World reservoirs, with `indirect.secondary=world-reservoirs`.
    pub world_reservoirs: WorldReservoirsSettings,
    /// The layout of reservoirs in memory.
    pub reservoirs: Reservoirs,
    /// The code that shaders contain. `full` costs time; the picture is the same.
    pub variant: Variant,
}
