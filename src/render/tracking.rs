//! The data that a renderer collects besides the picture, on request, for reports and debugging. Collecting them costs time
//! or memory.

/// Selects the data that a renderer collects besides the picture, for reports and debugging. Collecting them costs time or
/// memory, so by default nothing is selected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tracking {
    /// True if passes count their rays, the lanes of subgroups in use, merged neighbours, and bytes read and written.
    /// [`Renderer::counts`](super::Renderer::counts) returns these counts. Counting costs time.
    pub counts: bool,
    /// True if each reservoir also stores the pixel that drew its sample, and the number of neighbours that were merged into
    /// it. [`Renderer::reservoir_aovs`](super::Renderer::reservoir_aovs) returns both. Storing them costs memory.
    pub origins: bool,
    /// True if the renderer counts the samples of each pixel whose primary ray meets a surface, for the alpha channel of a
    /// picture. The camera then does not see the environment. Counting costs memory.
    pub coverage: bool,
}
