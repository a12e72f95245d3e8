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

/// An integrator renders the frames of one view of a scene. [`Renderer`](super::Renderer) moves the scene to the pose of a
/// frame before it calls the integrator. A frame has one sample per pixel.
///
/// Methods that return a [`Result`] fail if the device fails or its driver rejects a shader; `# Errors` sections name other
/// errors.
pub trait Integrator {
    /// True if a frame depends on the frames before it. Then no frame can be left out, and a run cannot be resumed from its
    /// sums.
    fn has_history(&self) -> bool;

    /// The maximum number of samples per call of [`Self::add`]. It is 1 if each sample is a frame for which the scene is
    /// posed.
    fn samples_per_call(&self) -> u32;

    /// Adds `samples` samples, with indices from `first` on, to the sums of every pixel; all of them show the scene in its
    /// current pose. Returns the time of each pass. `watch` is called repeatedly with the fraction of the work that is done,
    /// in [0, 1]. If it returns an error, the work ends, and pixels then differ in their number of samples.
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

    /// Renders the frame with the index `index` alone: into [`Self::color`], or where that is `None` into `sums`, which are
    /// cleared first. Returns the time of each run of a pass.
    fn render(
        &mut self,
        index: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
    ) -> Result<Vec<PassTime>>;

    /// As [`Self::render`], but without waiting for the device if the integrator can. It then returns `None`, and
    /// [`Device::wait_for_running`](crate::gpu::Device::wait_for_running) returns the times.
    fn submit(
        &mut self,
        index: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
    ) -> Result<Option<Vec<PassTime>>> {
        self.render(index, camera, sums).map(Some)
    }

    /// The radiance of the last frame: three words (RGB, in the device's unit of radiance) per pixel, row by row from the
    /// top. `None` for an integrator that writes sums only.
    fn color(&self) -> Option<&Buffer>;

    /// Sets the seed of the next frames, and forgets the frames before them: history is empty and counters are 0.
    fn restart(&mut self, seed: u32) -> Result<()>;

    /// The counters of the integrator's passes, such as rays and rejected values.
    fn counters(&mut self) -> &mut Counters;

    /// The size in bytes of the buffers that are kept from frame to frame or from pass to pass, without the scene and the
    /// sums.
    fn bytes(&self) -> u64;

    /// The contents of the last frame's reservoirs of direct or of indirect light, one entry per pixel, row by row from the
    /// top.
    ///
    /// # Errors
    /// The integrator has no reservoirs.
    fn reservoir_aovs(&self, lighting: Lighting) -> Result<Vec<ReservoirAov>>;
}
