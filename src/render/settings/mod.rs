//! All settings, as one tree of structures. The command `headwater presets` prints the doc comment of each field. The range
//! of a field is checked when a user sets its value.

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
    /// Paths are traced from the camera, with multiple importance sampling. This is unbiased, and the reference for all
    /// other estimators.
    #[default]
    PathTracing,
    /// Reservoir resampling: pixels reuse light samples and paths of their neighbours and of earlier frames.
    Restir,
}

/// The treatment of the energy that the specular lobe loses at rough surfaces, because it models only light that is
/// scattered once between microfacets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Energy {
    /// The specular lobe loses energy at rough surfaces, as in the plain model of glTF, so that pictures can be compared
    /// with those of other renderers. Rough metals are too dark, and light-coloured dielectrics are too bright at grazing
    /// angles.
    #[default]
    Gltf,
    /// The specular lobe is scaled so that it loses no energy, and the diffuse lobe gets the energy that remains: a surface
    /// that absorbs nothing passes the white furnace test.
    Compensated,
}

/// Settings of Russian roulette, which ends dim paths at random to save time. The light of the paths that continue is
/// multiplied by a factor, so that the mean stays the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Roulette {
    /// Roulette may end a path after its scattering event with this number, and after each later one; events count from 1.
    /// With `integrator=restir`, no path ends after the first event, because the ray that follows it also serves direct
    /// light. Higher: longer paths, which cost time; lower: more noise. Unbiased at any value.
    #[schemars(range(min = 0, max = 1000))]
    pub start: u32,
    /// Minimum probability with which roulette lets a path continue. Higher: more rays for dark paths; lower: the few dark
    /// paths that survive stand out as fireflies. Unbiased at any value.
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

/// The parts of the shader code that are compiled for a scene. Code for features that the scene lacks costs time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// The shaders contain only the code for the features that the scene has. The command `headwater scene inspect` lists
    /// these features.
    #[default]
    Auto,
    /// The shaders also contain the code for features that the scene lacks, so that the cost of this code can be measured
    /// against `auto`. Three parts are still compiled only if the scene requires them, because they would change the rays or
    /// the picture: code for motion, for large triangles, and for blended surfaces.
    Full,
}

/// All settings of a picture: everything that decides its pixels except scene, time, camera, size, bounces, jitter and seed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// The algorithm that computes the light of a picture: `path-tracing` traces independent paths and is the unbiased
    /// reference, `restir` reuses samples of neighbours and of earlier frames.
    pub integrator: Integrator,
    /// The MIS heuristic that weights light samples against hits of BSDF rays in path tracing. Candidates of resampling
    /// always have weights by the balance heuristic. No effect on bias.
    pub heuristic: Heuristic,
    /// The treatment of the energy that the specular lobe loses because it models single scattering only: `gltf` does not
    /// compensate the loss, `compensated` adds the lost energy again, at the cost of one table look-up per vertex.
    pub energy: Energy,
    /// Russian roulette, which ends dim paths at random to save time, and gives more weight to those that continue, so that
    /// the mean stays the same.
    pub roulette: Roulette,
    /// The rotation and the brightness of the environment that `--environment` gives. They have no effect without
    /// `--environment`.
    pub environment: EnvironmentSettings,
    /// Settings of direct light, which is scattered once between emitter and camera: its estimator, its candidates, and
    /// the reuse of its samples.
    pub direct: Direct,
    /// Settings of indirect light, which is scattered at least twice between emitter and camera: its estimator, the light
    /// samples at path vertices, and the reuse of paths.
    pub indirect: Indirect,
    /// Settings of the light BVH, a tree of lights. Candidates are drawn from it if `direct.candidates` or
    /// `indirect.candidates` is `light-bvh`, or if `auto` selects it.
    pub light_bvh: LightBvhSettings,
    /// Settings of the hash grid, which stores reservoirs of direct light in cells of space. Pixels merge these reservoirs
    /// if `direct.candidates` is `hash-grid`.
    pub hash_grid: HashGridSettings,
    /// Settings of world reservoirs, in which path vertices store light samples for vertices of the next frame. Paths use
    /// them if `indirect.secondary` is `world-reservoirs`.
    pub world_reservoirs: WorldReservoirsSettings,
    /// Settings of the layout of reservoirs in memory. They change time and memory, not the light of the picture.
    pub reservoirs: Reservoirs,
    /// The parts of the shader code that are compiled: `auto` is the code that the scene needs, `full` is nearly all code,
    /// which costs time. The picture is the same.
    pub variant: Variant,
}
