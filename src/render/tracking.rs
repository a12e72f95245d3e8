//! The further data that a renderer collects, at a cost in time or memory.

/// Data that is kept besides the picture, which costs time or memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tracking {
    /// Rays, lanes and neighbours, for [`Renderer::counts`](super::Renderer::counts).
    pub counts: bool,
    /// The origins of reservoirs' samples and the numbers of neighbours, for
    /// [`Renderer::reservoir_aovs`](super::Renderer::reservoir_aovs).
    pub origins: bool,
}
