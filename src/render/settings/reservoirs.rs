//! Settings of the layout of reservoirs in memory (`reservoirs.*`).

use crate::shader_interface::Format;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The layout of reservoirs in memory. It changes time and memory, not the light of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Reservoirs {
    /// The contents of a reservoir: `full` stores all values of a sample and costs memory, `compact` costs look-ups in the
    /// scene.
    pub format: Format,
    /// The order of pixels in memory: by row, by column, or in square tiles. No effect on the picture.
    pub order: Order,
    /// The words that are adjacent in memory: with `aos`, all words of one reservoir; with `soa`, the first words of all
    /// reservoirs, then all second words, and so on. No effect on the picture.
    pub arrays: Arrays,
}

/// The words of reservoirs that are adjacent in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Arrays {
    /// An array of structures: the words of one reservoir are adjacent.
    #[default]
    Aos,
    /// A structure of arrays: the first words of all reservoirs are adjacent, then all second words, and so on.
    Soa,
}

/// The order of pixels in memory: `row`, `column`, or `swizzle:N` for square tiles of N × N pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Order {
    /// Pixels are stored row by row.
    Row,
    /// Pixels are stored column by column.
    Column,
    /// Pixels are stored tile by tile. The value is the side of the square tiles in pixels, 1 to 64.
    Swizzle(u32),
}

impl Default for Order {
    /// Tiles of 4 × 4 pixels, so that pixels that are neighbours in the picture are close in memory.
    fn default() -> Self {
        Self::Swizzle(4)
    }
}

impl From<Order> for String {
    fn from(order: Order) -> Self {
        match order {
            Order::Row => "row".into(),
            Order::Column => "column".into(),
            Order::Swizzle(side) => format!("swizzle:{side}"),
        }
    }
}

impl TryFrom<String> for Order {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        match text.as_str() {
            "row" => Ok(Self::Row),
            "column" => Ok(Self::Column),
            _ => text
                .strip_prefix("swizzle:")
                .and_then(|side| side.parse().ok())
                .filter(|side| (1..=64).contains(side))
                .map(Self::Swizzle)
                .ok_or_else(|| format!("'{text}' is no order")),
        }
    }
}

impl JsonSchema for Order {
    fn schema_name() -> Cow<'static, str> {
        "Order".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "oneOf": [
            { "const": "row" },
            { "const": "column" },
            { "const": "swizzle:N, N 1 to 64" },
        ] })
    }
}
