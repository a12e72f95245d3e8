//! The buffer that holds the pilots of a frame. A pilot is the first BSDF ray of a pixel.

use crate::gpu::Buffer;

/// The right to read the pilots of a frame (the first BSDF ray of each pixel). Where there is indirect light, they are in
/// the buffer of its current reservoirs, which `initial_indirect` overwrites. So direct light borrows this value and
/// indirect light takes it: no pass that reads pilots can be recorded later.
pub struct Pilots<'a> {
    /// The buffer of pilots, or the reservoirs that hold them; `None` if neither direct candidates nor paths begin with
    /// pilots.
    pub buffer: Option<&'a Buffer>,
}
