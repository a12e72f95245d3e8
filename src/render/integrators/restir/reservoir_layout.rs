//! The layout of reservoirs in memory. It changes pictures by no more than the precision of the format; its cost depends on
//! the device.

use crate::render::lighting::Lighting;
use crate::render::settings::{Order, Reservoirs};
use crate::shader_interface::Format;
use crate::shader_interface::{
    DEBUG_WORDS, DIRECT_COMPACT_WORDS, DIRECT_FULL_WORDS, INDIRECT_COMPACT_WORDS,
    INDIRECT_FULL_WORDS,
};

/// The layout of reservoirs in memory: the settings, and the words that are added for debug AOVs.
#[derive(Clone, Copy, Debug)]
pub struct ReservoirLayout {
    /// The settings of the layout: format, order of pixels, and adjacent words.
    pub settings: Reservoirs,
    /// True if reservoirs also store the values of debug AOVs: the origins of their samples, and the numbers of merged
    /// neighbours.
    pub origins: bool,
}

impl ReservoirLayout {
    /// The size of one reservoir of this kind of light, in bytes.
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

    /// The number of slots for the pixels of a picture. With square tiles, both sides are rounded up to whole tiles.
    pub fn slots(&self, width: u32, height: u32) -> u64 {
        let side = match self.settings.order {
            Order::Swizzle(side) => side,
            Order::Row | Order::Column => 1,
        };
        let whole = |pixels: u32| u64::from(pixels.next_multiple_of(side));
        whole(width) * whole(height)
    }
}
