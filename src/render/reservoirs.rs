//! How reservoirs lie in memory. None of it changes a picture beyond the last digits that a format
//! keeps; what it costs depends on the device.

use super::kind::Kind;
use super::settings::Reservoirs;
use crate::layouts::{
    DIRECT_COMPACT_WORDS, DIRECT_FULL_WORDS, FORMAT_COMPACT, FORMAT_FULL, INDIRECT_COMPACT_WORDS,
    INDIRECT_FULL_WORDS, ORDER_COLUMN, ORDER_ROW, ORDER_SWIZZLE, ORIGIN_WORDS,
};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Specialisation constants: format, arrays, order, a tile's side, and whether origins are kept.
const RESERVOIR_FORMAT: u32 = 2;
const RESERVOIR_SOA: u32 = 3;
const PIXEL_ORDER: u32 = 4;
const SWIZZLE: u32 = 5;
const KEEPS_ORIGINS: u32 = 17;

/// What a reservoir stores.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    /// 16 bytes for direct and 32 for indirect light: what is named, and where on it; the rest is looked up.
    #[default]
    Compact,
    /// 40 and 60 bytes: points, their normals and materials, and of direct light what lights emit too.
    Full,
}

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
    /// What neighbours are found fastest in: by the plan `direct-layouts` on a CPU, frames take 2.5 to
    /// 7.5 % less time than in rows.
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
    /// The specialisation constants that tell shaders.
    pub fn constants(&self) -> Vec<(u32, u32)> {
        let settings = &self.settings;
        let format = match settings.format {
            Format::Compact => FORMAT_COMPACT,
            Format::Full => FORMAT_FULL,
        };
        let (order, side) = match settings.order {
            Order::Row => (ORDER_ROW, 1),
            Order::Column => (ORDER_COLUMN, 1),
            Order::Swizzle(side) => (ORDER_SWIZZLE, side),
        };
        vec![
            (RESERVOIR_FORMAT, format),
            (RESERVOIR_SOA, u32::from(settings.arrays == Arrays::Soa)),
            (PIXEL_ORDER, order),
            (SWIZZLE, side),
            (KEEPS_ORIGINS, self.origins.into()),
        ]
    }

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
