//! Settings of the light BVH, from which `candidates=light-bvh` draws.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The factor of radii: `auto`, or a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(into = "Written", try_from = "Written")]
pub enum Scale {
    /// From the scene.
    #[default]
    Auto,
    /// This one, above 0.
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
    /// The number, if it is given.
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

/// The choice of a light among those whose boxes hold a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LightChoice {
    /// By what its cluster is expected to contribute, then by power.
    #[default]
    Contribution,
    /// Each alike, as published.
    Uniform,
}

/// The treatment of lights that are far from a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Far {
    /// They are joined: the farther they are, the more are found as one.
    #[default]
    Joined,
    /// They are not found beyond their boxes of influence, as published.
    Skipped,
}

/// The extent of boxes of influence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Boxes {
    /// By the power of their lights.
    #[default]
    Simple,
    /// No further than rays from their lights reach at time 0; of lights that are off then, as `simple`.
    Visibility,
}

/// The distribution of the other candidates among all lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Rest {
    /// By power.
    #[default]
    Power,
    /// Each alike, as published.
    Uniform,
}

/// The light BVH: how it is built, and how candidates are drawn from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LightBvhSettings {
    /// The treatment of lights that are far from a point. Unbiased either way.
    pub far: Far,
    /// With `far=joined`, lights are joined from as many times half their extent on; with `far=skipped`, a light is found up
    /// to the distance scale · √power, with power in luminance × area. `auto`: 1, or such that points on surfaces lie within
    /// some boxes. Higher: longer searches, and candidates closer to the best ones. Unbiased at any value.
    pub scale: Scale,
    /// The share of candidates that is drawn among all lights, at least one. Higher: less noise where light comes from
    /// where none was expected, more elsewhere. Unbiased at any value.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub uniform_share: f32,
    /// With `far=skipped`, how far boxes go. `visibility` traces 256 rays for each box before the first frame. Unbiased either
    /// way.
    pub boxes: Boxes,
    /// True if lights that are close to each other have one box. Unbiased either way.
    pub cluster: bool,
    /// The choice of a light among those that are found. Unbiased either way.
    pub choice: LightChoice,
    /// The distribution of the other candidates among all lights. Unbiased either way.
    pub rest: Rest,
    /// Side of the tiles in which one pixel searches lights for all, for direct light. 1: each pixel searches by itself. Higher:
    /// less time, and candidates that fit fewer of the pixels. Unit: pixels. Unbiased at any value.
    #[schemars(range(min = 1, max = 64))]
    pub tile: u32,
    /// Lights that a tile draws, of which each pixel takes some. Higher: neighbours have fewer candidates in common. Cost: eight
    /// bytes each. Unbiased at any value.
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
