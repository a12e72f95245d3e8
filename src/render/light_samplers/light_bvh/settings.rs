//! Settings of the light BVH, from which `candidates=light-bvh` draws.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The factor of radii: `auto` or a positive number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(into = "Written", try_from = "Written")]
pub enum Scale {
    /// A factor that follows from the scene.
    #[default]
    Auto,
    /// The given factor, above 0.
    Number(f32),
}

/// A scale as it is written.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Written {
    Number(f32),
    Word(String),
}

impl From<Scale> for Written {
    fn from(scale: Scale) -> Self {
        match scale {
            Scale::Auto => Self::Word("auto".into()),
            Scale::Number(number) => Self::Number(number),
        }
    }
}

impl TryFrom<Written> for Scale {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        match written {
            Written::Word(word) if word == "auto" => Ok(Self::Auto),
            Written::Word(word) => Err(format!("'{word}' is no scale")),
            Written::Number(number) if (1e-9..=1e9).contains(&number) => Ok(Self::Number(number)),
            Written::Number(number) => Err(format!("{number} is no scale")),
        }
    }
}

impl Scale {
    /// The given factor, if there is one.
    pub fn number(self) -> Option<f32> {
        match self {
            Self::Auto => None,
            Self::Number(number) => Some(number),
        }
    }
}

impl JsonSchema for Scale {
    fn schema_name() -> Cow<'static, str> {
        "Scale".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "oneOf": [
            { "const": "auto" },
            { "const": "number 1e-9 to 1e9" },
        ] })
    }
}

/// The distribution of the choice among the lights whose boxes hold a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LightChoice {
    /// By the expected contribution of the light's cluster, then by power.
    #[default]
    Contribution,
    /// Uniform, as published.
    Uniform,
}

/// The treatment of lights that are far from a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Far {
    /// Far lights are joined: the farther away they are, the larger are the groups that a walk finds as one.
    #[default]
    Joined,
    /// Far lights are not found outside of their boxes of influence, as published.
    Skipped,
}

/// The extent of boxes of influence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Boxes {
    /// By the power of their lights.
    #[default]
    Simple,
    /// Limited to the distances that rays from their lights reach at time 0; for lights that are off at that time, as `simple`.
    Visibility,
}

/// The distribution of the other candidates among all lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Rest {
    /// By power.
    #[default]
    Power,
    /// Uniform, as published.
    Uniform,
}

/// The light BVH: the options of its construction and of the candidates that are drawn from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LightBvhSettings {
    /// The treatment of lights that are far from a point. Unbiased either way.
    pub far: Far,
    /// With `far=joined`, lights are joined beyond this many times half the diagonal of their box; with `far=skipped`, a light
    /// is found up to the distance scale · √power, with power in luminance × area. `auto`: 1 with `far=joined`; otherwise a
    /// scale at which points on surfaces lie within some boxes. Higher: longer searches, and candidates closer to the best
    /// ones. Unbiased at any value.
    pub scale: Scale,
    /// The fraction of candidates that is drawn among all lights; at least one candidate. Higher: less noise where light comes
    /// from unexpected directions, more noise elsewhere. Unbiased at any value.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub uniform_share: f32,
    /// With `far=skipped`, the extent of boxes of influence. `visibility` traces 256 rays for each box before the first frame.
    /// Unbiased either way.
    pub boxes: Boxes,
    /// True if lights that are close to each other form a cluster with one box. Unbiased either way.
    pub cluster: bool,
    /// The choice of a light among those that are found. Unbiased either way.
    pub choice: LightChoice,
    /// The distribution of the other candidates among all lights. Unbiased either way.
    pub rest: Rest,
    /// Size of the tiles in which one pixel searches lights for all pixels, for direct light. 1: each pixel searches
    /// separately. Higher: less time, and candidates that fit fewer of the pixels. Unit: pixels. Unbiased at any value.
    #[schemars(range(min = 1, max = 64))]
    pub tile: u32,
    /// Number of lights that a tile draws; each pixel uses some of them. Higher: neighbours have fewer candidates in common.
    /// Cost: eight bytes each. Unbiased at any value.
    #[schemars(range(min = 1, max = 1024))]
    pub list: u32,
}

impl Default for LightBvhSettings {
    fn default() -> Self {
        Self {
            far: Far::default(),
            scale: Scale::default(),
            uniform_share: 0.2,
            boxes: Boxes::default(),
            cluster: true,
            choice: LightChoice::default(),
            rest: Rest::default(),
            tile: 4,
            list: 32,
        }
    }
}
