//! The buffer with the pilots of a frame. A pilot is the first BSDF ray of a pixel, which direct and indirect light share,
//! so that it is traced only once.

use crate::gpu::Buffer;

/// Access to the pilots of a frame (the first BSDF ray of each pixel). If there is indirect light, the pilots are in the
/// buffer of its current reservoirs, until the pass `initial_indirect` replaces them with reservoirs. Passes of direct light
/// borrow this value. Indirect light consumes it, so that the compiler rejects code that records a pass that reads pilots
/// afterwards.
pub struct Pilots<'a> {
    /// The buffer of the pilots, which can be the buffer of the reservoirs of indirect light. `None` if no pilots are
    /// traced, because neither candidates of direct light nor paths begin with them.
    pub buffer: Option<&'a Buffer>,
}
