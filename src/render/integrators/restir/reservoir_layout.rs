//! The layout of reservoirs in memory. It changes pictures by no more than the precision of the format; its cost depends on the
//! device.

use crate::render::lighting::Lighting;
use crate::render::settings::{Order, Reservoirs};
use crate::shader_interface::Format;
use crate::shader_interface::{
    DEBUG_WORDS, DIRECT_COMPACT_WORDS, DIRECT_FULL_WORDS, INDIRECT_COMPACT_WORDS,
    INDIRECT_FULL_WORDS,
};

/// The layout of reservoirs, and the data that they store in addition to the settings.
#[derive(Clone, Copy, Debug)]
pub struct ReservoirLayout {
    /// The settings of the layout.
    pub settings: Reservoirs,
    /// True if reservoirs store the values of debug AOVs: the origins of their samples, and numbers of neighbours.
    pub origins: bool,
}

impl ReservoirLayout {
    /// Bytes of a reservoir.
    pub fn bytes(&self, lighting: Lighting) -> u64 {
        let debug = if self.origins { DEBUG_WORDS } else { 0 };
        4 * u64::from(
            match (lighting, self.settings.format) {
                (Lighting::Direct, Format::Compact) => DIRECT_COMPACT_WORDS,
                (Lighting::Direct, Format::Full) => DIRECT_FULL_WORDS,
                (Lighting::Indirect, Format::Compact) => INDIRECT_COMPACT_WORDS,
                (Lighting::Indirect, Format::Full) => INDIRECT_FULL_WORDS,
            } + debug,
        )
    }

    /// The number of slots for a picture's pixels; tiles at the borders are whole.
    pub fn slots(&self, width: u32, height: u32) -> u64 {
        let side = match self.settings.order {
            Order::Swizzle(side) => side,
            Order::Row | Order::Column => 1,
        };
        let whole = |pixels: u32| u64::from(pixels.next_multiple_of(side));
        whole(width) * whole(height)
    }
}
