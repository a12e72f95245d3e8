//! Settings of the light BVH (`light_bvh.*`), a tree of lights. Light candidates are drawn from it, with probabilities that
//! depend on the shading point, if `direct.candidates` or `indirect.candidates` is `light-bvh`, or if `auto` selects it.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The factor by which the boxes around lights in the light BVH (a tree of lights) are enlarged: `auto`, or a number from
/// 1e-9 to 1e9. Higher with `far=skipped`: a point is inside the boxes of more lights, among which its candidates are drawn.
/// Higher with `far=joined`: far lights form smaller groups. In both cases, walks through the tree take longer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(into = "Written", try_from = "Written")]
pub enum Scale {
    /// The program chooses the factor when it builds the tree. With `far=joined`, the factor is 1. With `far=skipped`, it is
    /// such that a point on the surfaces of the scene is within about 8 boxes on average.
    #[default]
    Auto,
    /// The user gives the factor, from 1e-9 to 1e9.
    Number(f32),
}

/// A [`Scale`] in the form in which TOML and JSON files contain it: a number, or the word `auto`. When a file is read,
/// this form is converted to a [`Scale`]; other words, and numbers out of range, are errors.
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
    /// The factor that the user gave, from 1e-9 to 1e9; `None` for `auto`, because the program then chooses the factor when
    /// it builds the tree.
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

/// The probabilities with which a light is drawn from the light BVH (a tree of lights) at a shading point. With
/// `far=joined`, all lights in the tree can be drawn; with `far=skipped`, only the lights whose boxes of influence contain
/// the point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LightChoice {
    /// First a group of lights (a node of the tree) is drawn, in proportion to an estimate of the light that the group adds
    /// at the shading point; the estimate ignores occlusion. Then a light of the group is drawn in proportion to its power.
    #[default]
    Contribution,
    /// All lights that can be drawn from the tree at the shading point have the same probability, as published (Gardishyan
    /// 2025).
    Uniform,
}

/// The treatment of lights that are far from the shading point, when a light is drawn from the light BVH (a tree of lights):
/// far lights are drawn in groups, or not at all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Far {
    /// Lights that are far from the shading point are drawn in groups: first a group is drawn from the tree, then a light of
    /// the group. A group consists of the lights of a tree node whose box, enlarged by `light_bvh.scale`, does not contain
    /// the shading point. The farther away lights are, the larger are the groups.
    #[default]
    Joined,
    /// Lights that are far from the shading point cannot be drawn from the tree, as published (Gardishyan 2025). Each
    /// cluster (lights that are close to each other) has a box of influence around it, and its lights can be drawn from the
    /// tree only at points inside this box. At other points, only candidates that are drawn among all lights can select
    /// these lights.
    Skipped,
}

/// The extent of boxes of influence. Such a box surrounds a cluster (lights that are close to each other). With
/// `far=skipped`, the lights of the cluster can be drawn from the light BVH only at points inside the box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Boxes {
    /// The box extends beyond the lights of its cluster by the distance scale × √power, in all directions. The scale is
    /// `light_bvh.scale`, and the power is the sum of luminance × area over the lights. Distance and power are in the
    /// device's units.
    #[default]
    Simple,
    /// The box is as with `simple`, but it ends at the surfaces that rays from the lights of its cluster hit at time 0. So
    /// fewer of the points from which these lights are hidden are inside the box. If all lights of a cluster are off at time
    /// 0, the box is the same as with `simple`.
    Visibility,
}

/// The probabilities of lights for those candidates that are drawn among all lights instead of from the light BVH.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Rest {
    /// With probability 0.9, a light is drawn in proportion to its power (area × luminance for a triangle). Otherwise, all
    /// lights have the same probability.
    #[default]
    Power,
    /// All lights have the same probability, as published (Gardishyan 2025).
    Uniform,
}

/// Settings of the light BVH, a tree of lights: how the tree is built, and how light candidates are drawn from it. Lights
/// that are likely to add much light at the shading point can be drawn with higher probability.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LightBvhSettings {
    /// The treatment of lights that are far from the shading point. `joined`: first a group of them is drawn from the tree,
    /// then a light of the group. `skipped`: they are not drawn from the tree, but only among all lights (`uniform_share`).
    /// Unbiased either way.
    pub far: Far,
    /// Factor by which the boxes around lights are enlarged. With `far=joined`, a group of lights is drawn as one light
    /// at points outside its enlarged box, which extends on each side by scale × half the diagonal of its original box.
    /// With `far=skipped`, the box of influence extends by scale × √power beyond its lights, with power as luminance ×
    /// area, all in the device's units. `auto`: 1 with `far=joined`; with `far=skipped`, a scale at which a point on a
    /// surface is within about 8 boxes on average. Higher: longer walks through the tree, and candidates that fit the
    /// point better. Unbiased at any value.
    pub scale: Scale,
    /// Fraction of candidates, in [0.01, 1], that are drawn among all lights (with the probabilities of `rest`) instead
    /// of from the tree. If there are several candidates, at least one is drawn in this way. If there is only one, this
    /// value is the probability that it is drawn in this way. Higher: less noise where light comes from unexpected
    /// directions, more noise elsewhere. Unbiased at any value.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub uniform_share: f32,
    /// The extent of the boxes of influence. With `far=skipped`, a light can be drawn from the tree only at points inside
    /// the box around the cluster of the light. `simple`: the box grows with the power of the lights in its cluster.
    /// `visibility`: the box also ends at the surfaces that 256 rays from these lights hit; they are traced before the first
    /// frame. No effect with `far=joined`. Unbiased either way.
    pub boxes: Boxes,
    /// True if lights that are close to each other form a cluster with one box, so that the tree has fewer nodes; false if
    /// each light has a separate box. Unbiased either way.
    pub cluster: bool,
    /// The probabilities with which a light is drawn from the tree at a shading point. `contribution`: in proportion to an
    /// estimate of the light that it adds there; `uniform`: the same for all lights that can be drawn there. Unbiased either
    /// way.
    pub choice: LightChoice,
    /// The probabilities of lights for the candidates that are drawn among all lights instead of from the tree: by `power`
    /// or `uniform`. Unbiased either way.
    pub rest: Rest,
    /// Side of the square tiles of pixels for direct light. Unit: pixels. One pixel of each tile draws a list of lights from
    /// the tree, from which the pixels around it take their candidates. 1: there are no lists, and each pixel walks through
    /// the tree itself. Higher: less time, but more noise, because a list fits pixels less well the farther they are from
    /// the pixel that drew it. Unbiased at any value.
    #[schemars(range(min = 1, max = 64))]
    pub tile: u32,
    /// Number of lights in the list of a tile; each pixel uses at most `direct.light_samples` of them. Higher: neighbouring
    /// pixels have fewer candidates in common. Cost: eight bytes per light and tile. Unbiased at any value. No effect with
    /// `tile=1`.
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
