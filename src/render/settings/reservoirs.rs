//! Settings of the layout of reservoirs in memory (`reservoirs.*`): their contents, the order of pixels, and the arrangement
//! of words.

use crate::shader_interface::Format;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Settings of the layout of reservoirs in memory. They change time and memory, not the light of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Reservoirs {
    /// The contents of a reservoir in memory: `full` stores all values of a sample and costs memory; `compact` stores fewer,
    /// and shaders read the others from the scene, which costs time. No effect on bias.
    pub format: Format,
    /// The order in which pixels are stored in buffers with one entry per pixel: by row, by column, or in square tiles. It
    /// changes the time of memory access only, not the picture.
    pub order: Order,
    /// The arrangement of the 32-bit words of reservoirs. With `aos`, all words of one reservoir are adjacent in memory;
    /// with `soa`, the first words of all reservoirs are adjacent, then all second words, and so on. It changes the time of
    /// memory access only, not the picture.
    pub arrays: Arrays,
}

/// The arrangement of the 32-bit words of reservoirs in memory. It changes the time of memory access only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Arrays {
    /// An array of structures: all 32-bit words of one reservoir are adjacent in memory.
    #[default]
    Aos,
    /// A structure of arrays: the first 32-bit words of all reservoirs are adjacent in memory, then all second words, and so
    /// on.
    Soa,
}

/// The order in which pixels are stored in buffers with one entry per pixel. Pixels read the data of their neighbours, so
/// the order changes the time of memory access, but not the picture. As text: `row`, `column`, or `swizzle:N` for square
/// tiles of N × N pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Order {
    /// Pixels are stored row by row, from the top of the picture.
    Row,
    /// Pixels are stored column by column, from the left of the picture.
    Column,
    /// Pixels are stored tile by tile. The number is the side of the square tiles in pixels, from 1 to 64.
    Swizzle(u32),
}

impl Default for Order {
    /// The default order: tiles of 4 × 4 pixels, so that pixels that are close in the picture are also close in memory.
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
