//! The integrators, which make pictures: path tracing, and reservoir resampling of direct and indirect light.

pub mod path_tracing;
pub mod restir;

pub use path_tracing::PathTracer;
pub use restir::Restir;

use super::counters::Counters;
use super::lighting::Lighting;
use super::outputs::Accumulator;
use crate::Result;
use crate::base::progress::Watch;
use crate::gpu::{Buffer, PassTime};
use crate::shader_interface::{GpuCamera, ReservoirAov};

/// An integrator makes the pictures of one view of a scene, which [`Renderer`](super::Renderer) has posed. A frame has one
/// sample per pixel.
///
/// Its methods fail if the device does; other errors are named where they can occur.
pub trait Integrator {
    /// True if a frame depends on those before it. Then none can be left out, and sums alone cannot be resumed.
    fn has_history(&self) -> bool;

    /// The maximum number of samples per call of [`Self::add`]: 1 if each sample is a frame for which the scene is posed.
    fn samples_per_call(&self) -> u32;

    /// Adds samples of one moment, whose indices begin with `first`, to the sums of every pixel. `watch` is called repeatedly
    /// with the fraction of the work that is done, in [0, 1]. If it returns an error, the work ends, and pixels then differ in
    /// their number of samples.
    ///
    /// # Errors
    /// The errors of `watch`.
    fn add(
        &mut self,
        first: u32,
        samples: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
        watch: &mut Watch<'_>,
    ) -> Result<Vec<PassTime>>;

    /// Renders one frame alone, to [`Self::color`], or to `sums` where that is `None`. Returns the time of each run of a pass.
    fn render(
        &mut self,
        index: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
    ) -> Result<Vec<PassTime>>;

    /// [`Self::render`] without waiting, if the integrator can;
    /// [`Device::wait_for_running`](crate::gpu::Device::wait_for_running) then returns the times.
    fn submit(
        &mut self,
        index: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
    ) -> Result<Option<Vec<PassTime>>> {
        self.render(index, camera, sums).map(Some)
    }

    /// Radiance of the last frame: three words per pixel, row by row from the top. `None` for an integrator that writes sums
    /// only.
    fn color(&self) -> Option<&Buffer>;

    /// Restarts with another seed, without history.
    fn restart(&mut self, seed: u32) -> Result<()>;

    /// Counters of the passes.
    fn counters(&mut self) -> &mut Counters;

    /// Bytes on the device that are kept from frame to frame or from pass to pass.
    fn bytes(&self) -> u64;

    /// The contents of the last frame's reservoirs, row by row from the top.
    ///
    /// # Errors
    /// The integrator has none.
    fn reservoir_aovs(&self, lighting: Lighting) -> Result<Vec<ReservoirAov>>;
}
