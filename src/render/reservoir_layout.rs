//! The layout of reservoirs in memory. It changes pictures by no more than the precision of the format; what
//! it costs depends on the device.

use super::kind::Kind;
use super::settings::Reservoirs;
use crate::choices::Format;
use crate::layouts::{
    DIRECT_COMPACT_WORDS, DIRECT_FULL_WORDS, INDIRECT_COMPACT_WORDS, INDIRECT_FULL_WORDS,
    ORIGIN_WORDS,
};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// How the words of reservoirs alternate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Arrays {
    /// An array of structures: a reservoir's words side by side.
    #[default]
    Aos,
    /// A structure of arrays: equal words of all reservoirs side by side.
    Soa,
}

/// In which order pixels lie: `row`, `column`, or `swizzle:N` for square tiles of N pixels a side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Order {
    /// Row by row.
    Row,
    /// Column by column.
    Column,
    /// Tile by tile, 1…64 pixels a side.
    Swizzle(u32),
}

impl Default for Order {
    /// Neighbouring pixels are close in memory. On a CPU the plan `direct-layouts` finds no difference above
    /// 3 %.
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

/// How reservoirs lie, and what they keep beside what their settings say.
#[derive(Clone, Copy, Debug)]
pub struct ReservoirLayout {
    /// As the settings say.
    pub settings: Reservoirs,
    /// Whether they keep where their samples come from.
    pub origins: bool,
}

impl ReservoirLayout {
    /// Bytes of a reservoir.
    pub fn bytes(&self, kind: Kind) -> u64 {
        let origin = if self.origins { ORIGIN_WORDS } else { 0 };
        4 * u64::from(
            match (kind, self.settings.format) {
                (Kind::Direct, Format::Compact) => DIRECT_COMPACT_WORDS,
                (Kind::Direct, Format::Full) => DIRECT_FULL_WORDS,
                (Kind::Indirect, Format::Compact) => INDIRECT_COMPACT_WORDS,
                (Kind::Indirect, Format::Full) => INDIRECT_FULL_WORDS,
            } + origin,
        )
    }

    /// Places that a picture's pixels take; tiles at the borders are whole.
    pub fn slots(&self, width: u32, height: u32) -> u64 {
        let side = match self.settings.order {
            Order::Swizzle(side) => side,
            Order::Row | Order::Column => 1,
        };
        let whole = |pixels: u32| u64::from(pixels.next_multiple_of(side));
        whole(width) * whole(height)
    }
}
