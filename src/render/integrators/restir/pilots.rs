//! The buffer with the pilots of a frame. A pilot is the first BSDF ray of a pixel, which direct and indirect light share.

use crate::gpu::Buffer;

/// The right to read the pilots of a frame (the first BSDF ray of each pixel). If there is indirect light, the pilots are in
/// the buffer of its current reservoirs until the pass `initial_indirect` overwrites them. So direct light borrows this
/// value, and indirect light takes it by value: after that, no pass that reads pilots can be recorded.
pub struct Pilots<'a> {
    /// The buffer of the pilots, which can be the buffer of the reservoirs of indirect light. `None` if no pilots are
    /// traced, because neither candidates of direct light nor paths begin with them.
    pub buffer: Option<&'a Buffer>,
}
