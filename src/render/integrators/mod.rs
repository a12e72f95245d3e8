//! The integrators, which compute pictures: path tracing, and reservoir resampling (ReSTIR) of direct and indirect light.

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

/// An integrator renders the frames of one view of a scene, by path tracing or by reservoir resampling. A frame has one
/// sample per pixel. [`Renderer`](super::Renderer) moves all objects of the scene to their positions in the frame before it
/// calls a method that renders.
///
/// Methods that return a [`Result`] fail if the device fails or its driver rejects a shader; `# Errors` sections name other
/// errors.
pub trait Integrator {
    /// True if a frame depends on the frames before it. Then no frame can be left out, and a run that was interrupted cannot
    /// be continued from its stored sums of radiance.
    fn has_history(&self) -> bool;

    /// The maximum number of samples per pixel that one call of [`Self::add`] may add. It is 1 for reservoir resampling,
    /// because each sample is a separate frame, and the scene can be moved only between calls. Path tracing has no limit.
    fn samples_per_call(&self) -> u32;

    /// Adds `samples` samples per pixel to `sums`, the sums of radiance of the pixels. The samples have the indices from
    /// `first` on, and all of them show the scene in its current pose. Returns the time of each pass, one entry per pass.
    /// `watch` may be called repeatedly with the fraction of the work that is done, in [0, 1]. If it returns an error, the
    /// work ends, and the sums of different pixels then have different numbers of samples.
    ///
    /// # Errors
    /// `watch` returns an error.
    fn add(
        &mut self,
        first: u32,
        samples: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
        watch: &mut Watch<'_>,
    ) -> Result<Vec<PassTime>>;

    /// Renders the frame with the index `index` without adding it to earlier samples. The result is in the buffer
    /// [`Self::color`]. If that is `None`, the result is in `sums`, which are cleared first; otherwise `sums` stay as they
    /// are. Returns the times of the passes on the device in milliseconds, one entry per run of a pass; path tracing
    /// adds up all runs of its pass in one entry.
    fn render(
        &mut self,
        index: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
    ) -> Result<Vec<PassTime>>;

    /// Renders the frame with the index `index` to the same buffer as [`Self::render`]. If possible, this method does not
    /// wait for the device, so that the device has no gaps between frames. It then returns `None`, and the caller gets
    /// the times of the passes from [`Device::wait_for_running`](crate::gpu::Device::wait_for_running). An implementation
    /// that waits for the device, such as path tracing, returns the times itself.
    fn submit(
        &mut self,
        index: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
    ) -> Result<Option<Vec<PassTime>>> {
        self.render(index, camera, sums).map(Some)
    }

    /// The buffer with the radiance of the last frame: three 32-bit floats (RGB) per pixel, row by row from the top, in the
    /// device's unit of radiance (the scene's unit times a power of two). `None` for path tracing, which writes only sums of
    /// radiance.
    fn color(&self) -> Option<&Buffer>;

    /// The buffer with one 32-bit word per pixel, row by row from the top: 1 if the primary ray of the pixel met a surface in
    /// the last frame, otherwise 0. `None` for path tracing, which counts such samples with its sums, and if
    /// [`Tracking::coverage`](super::Tracking::coverage) is false.
    fn covered(&self) -> Option<&Buffer> {
        None
    }

    /// Sets the seed of the next frames, and forgets all earlier frames: the next frame reuses nothing, and all counters are
    /// 0.
    fn restart(&mut self, seed: u32) -> Result<()>;

    /// The counters of the integrator's passes, which count rays, rejected values and more. The caller reads them to detect
    /// faults and to explain the cost of passes.
    fn counters(&mut self) -> &mut Counters;

    /// The size in bytes of the buffers with data of pixels, path vertices and light samplers, which the integrator keeps
    /// besides the scene and the sums of radiance. Reports show this size, so that users can compare how much memory
    /// different settings need. 0 for path tracing, which has no such buffers.
    fn bytes(&self) -> u64;

    /// The contents of the reservoirs of direct or of indirect light (`lighting`) after the last frame, for debug AOVs:
    /// additional channels of a picture that show, for example, which light each pixel selected. One entry per pixel, row by
    /// row from the top.
    ///
    /// # Errors
    /// The integrator has no reservoirs.
    fn reservoir_aovs(&self, lighting: Lighting) -> Result<Vec<ReservoirAov>>;
}
