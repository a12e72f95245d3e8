//! The buffer that holds a frame's pilots, the first BSDF ray of each pixel.

use crate::gpu::Buffer;

/// The buffer with the pilots of a frame. Where there is indirect light, it is the buffer of its current
/// reservoirs, which `initial_indirect` overwrites. So direct light borrows the pilots, and indirect light
/// takes them: no pass can be recorded that reads them later.
pub struct Pilots<'a> {
    /// The pilots, or the reservoirs that hold them; `None` if neither direct candidates nor paths begin with pilots.
    pub buffer: Option<&'a Buffer>,
}
