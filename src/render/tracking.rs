//! The data besides the picture that a renderer collects, at a cost in time or memory.

/// The data besides the picture that a renderer collects, at a cost in time or memory. By default, it collects none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tracking {
    /// True if passes count rays, lanes, neighbours and bytes, which [`Renderer::counts`](super::Renderer::counts) returns.
    /// This costs time.
    pub counts: bool,
    /// True if reservoirs store the origins of their samples and the numbers of merged neighbours, which
    /// [`Renderer::reservoir_aovs`](super::Renderer::reservoir_aovs) returns. This costs memory.
    pub origins: bool,
}
