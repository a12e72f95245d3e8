//! The buffer with the pilots of a frame. A pilot is the first BSDF ray of a pixel. Direct and indirect light share this
//! ray, so that it is traced only once.

use crate::gpu::Buffer;

/// The buffer with the pilots of a frame (the first BSDF ray of each pixel), which passes read. If there is indirect light,
/// this is the buffer of its current reservoirs, and the pass `initial_indirect` replaces the pilots with reservoirs. Passes
/// of direct light borrow this value, and indirect light consumes it. So the compiler rejects code that uses the pilots
/// after they were replaced.
pub struct Pilots<'a> {
    /// The buffer of the pilots, which can be the buffer of the reservoirs of indirect light. `None` if no pilots are
    /// traced, because neither candidates of direct light nor paths begin with them.
    pub buffer: Option<&'a Buffer>,
}
