//! The layout of reservoirs in memory, which decides how much memory they need and how fast passes read and write them. It
//! can change pictures only by the rounding of the stored values, which depends on the format. How much time a layout costs
//! depends on the device.

use crate::render::lighting::Lighting;
use crate::render::settings::{Order, Reservoirs};
use crate::shader_interface::Format;
use crate::shader_interface::{
    DEBUG_WORDS, DIRECT_COMPACT_WORDS, DIRECT_FULL_WORDS, INDIRECT_COMPACT_WORDS,
    INDIRECT_FULL_WORDS,
};

/// The layout of reservoirs in memory: the settings, and whether a reservoir has additional words for debug AOVs (channels
/// of a picture that show the contents of reservoirs). The sizes of buffers and the code of shaders follow from it.
#[derive(Clone, Copy, Debug)]
pub struct ReservoirLayout {
    /// The settings of the layout: the format of a reservoir, the order of pixels, and which words of reservoirs are
    /// adjacent.
    pub settings: Reservoirs,
    /// True if reservoirs have additional words for debug AOVs: the pixel that drew the sample, and the number of neighbours
    /// that were merged. This costs memory.
    pub origins: bool,
}

impl ReservoirLayout {
    /// The size in bytes of one reservoir of direct or of indirect light (`lighting`), from which the sizes of buffers are
    /// computed.
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

    /// The number of slots (places for the data of one pixel) that a buffer needs for a picture of `width` × `height`
    /// pixels. If the pixels are ordered in square tiles, `width` and `height` are first rounded up to whole tiles.
    /// Otherwise there is one slot per pixel.
    pub fn slots(&self, width: u32, height: u32) -> u64 {
        let side = match self.settings.order {
            Order::Swizzle(side) => side,
            Order::Row | Order::Column => 1,
        };
        let whole = |pixels: u32| u64::from(pixels.next_multiple_of(side));
        whole(width) * whole(height)
    }
}
