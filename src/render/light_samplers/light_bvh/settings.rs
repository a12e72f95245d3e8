//! Settings of the light BVH (`light_bvh.*`), a tree of lights from which `candidates=light-bvh` draws.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The factor by which the boxes around lights in the light BVH are enlarged: `auto` or a number from 1e-9 to 1e9. Larger
/// boxes find more lights at a point, by longer walks through the tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(into = "Written", try_from = "Written")]
pub enum Scale {
    /// 1 with `far=joined`; with `far=skipped`, a factor that is chosen from the scene.
    #[default]
    Auto,
    /// The given factor, from 1e-9 to 1e9.
    Number(f32),
}

/// A scale in the form in which TOML and JSON write it: a number, or the word `auto`.
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
    /// The given factor; `None` for `auto`.
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

/// The distribution by which a walk through the light BVH draws one of the lights that it finds at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LightChoice {
    /// A cluster of lights is drawn by its expected contribution at the point, then a light of the cluster by power.
    #[default]
    Contribution,
    /// All lights that a walk finds have the same probability, as published.
    Uniform,
}

/// The treatment of lights that are far from a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Far {
    /// Far lights are joined: the farther away lights are, the larger are the groups that a walk treats as one light.
    #[default]
    Joined,
    /// A light is found only at points inside its cluster's box of influence, as published. Elsewhere, only the candidates
    /// that are drawn among all lights find it.
    Skipped,
}

/// The extent of boxes of influence, the boxes around clusters of lights within which their lights are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Boxes {
    /// The radius of a box follows from the power of its lights.
    #[default]
    Simple,
    /// Boxes are also limited to the surfaces that rays from their lights hit at time 0. Boxes of lights that are off at
    /// that time are as with `simple`.
    Visibility,
}

/// The distribution of the candidates that are not drawn from the tree but among all lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Rest {
    /// Lights are drawn in proportion to area × luminance, mixed with a uniform fraction.
    #[default]
    Power,
    /// All lights have the same probability, as published.
    Uniform,
}

/// The light BVH: the options of its construction, and of the candidates that are drawn from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LightBvhSettings {
    /// The treatment of lights that are far from a point: `joined` lets a walk find them in groups, `skipped` leaves them
    /// out. Unbiased either way.
    pub far: Far,
    /// With `far=joined`, lights are joined beyond this many times half the diagonal of their box; with `far=skipped`, a
    /// light is found up to the distance scale · √power, with power in luminance × area. `auto`: 1 with `far=joined`;
    /// otherwise a scale at which points on surfaces lie within about 8 boxes. Higher: longer searches, and candidates
    /// closer to the best ones. Unbiased at any value.
    pub scale: Scale,
    /// Fraction of candidates that are drawn among all lights instead of from the tree: at least one of several candidates;
    /// a single candidate is drawn so with this probability. Higher: less noise where light comes from unexpected
    /// directions, more noise elsewhere. Unbiased at any value.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub uniform_share: f32,
    /// The extent of boxes of influence, with `far=skipped`. `visibility` limits the boxes by rays: 256 for each box, traced
    /// before the first frame. Unbiased either way.
    pub boxes: Boxes,
    /// True if lights that are close to each other form a cluster with one box, which makes the tree smaller; false if each
    /// light has its own box. Unbiased either way.
    pub cluster: bool,
    /// The distribution by which a walk through the tree draws one of the lights that it finds at a point. Unbiased either
    /// way.
    pub choice: LightChoice,
    /// The distribution of the candidates that are not drawn from the tree but among all lights. Unbiased either way.
    pub rest: Rest,
    /// Size of the tiles in which one pixel draws lights for all pixels, for direct light. 1: each pixel walks through the
    /// tree itself. Higher: less time, and candidates that fit fewer of the pixels. Unit: pixels. Unbiased at any value.
    #[schemars(range(min = 1, max = 64))]
    pub tile: u32,
    /// Number of lights that a tile draws; each pixel uses `light_samples` of them at most. Higher: neighbours have fewer
    /// candidates in common. Cost: eight bytes per light and tile. Unbiased at any value.
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
