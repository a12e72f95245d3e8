//! AOVs (additional channels of a picture) of primary surfaces, such as depth and normals. A primary surface is the surface
//! that the ray through a pixel's centre hits.

use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::render::counters::Counters;
use crate::render::scene_bindings::SceneBindings;
use crate::render::strips::cut;
use crate::shader_interface::{FrameConstants, GpuCamera, PrimarySurface};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass `primary`, which finds the primary surface of each pixel (the surface that the ray through its
    /// centre hits), for channels such as depth and normals.
    pub struct Primary {
        [offers scene: SceneBindings]
        uniform frame,
        uniform previous_camera,
        write primary,
        write counters,
    }
}

/// The pass `primary`, which traces one ray through the centre of each pixel, and finds the depth, normal, albedo, instance
/// and motion of the surface there. The option `--aov` writes these values to files, for example for denoisers. The pass
/// runs only when a caller reads the values, and has no effect on the picture.
pub struct PrimarySurfaces {
    device: Arc<Device>,
    bindings: Arc<SceneBindings>,
    primary: ComputePass,
    counters: Counters,
}

impl PrimarySurfaces {
    /// Makes the pass `primary`, which finds the primary surfaces of pixels in the scene of `bindings`, and the counters
    /// to which this pass adds its faults.
    ///
    /// # Errors
    /// The shader's interface cannot be bound by name, or the device fails.
    pub fn new(device: &Arc<Device>, bindings: &Arc<SceneBindings>) -> Result<Self> {
        Ok(Self {
            primary: bindings.pass("primary", &bindings.specialisation)?,
            counters: Counters::new(device, false)?,
            bindings: bindings.clone(),
            device: device.clone(),
        })
    }

    /// Finds the surfaces that the camera of `constants` sees in the current pose of the scene (its state at one time), one
    /// per pixel, row by row from the top. Depths are in the device's unit of length; a depth of 0 means that the pixel
    /// shows no surface. `previous` is the camera of the previous frame, from which motion vectors are computed.
    pub fn read(
        &self,
        constants: &FrameConstants,
        previous: GpuCamera,
    ) -> Result<Vec<PrimarySurface>> {
        let uniform = Usage {
            uniform: true,
            ..Usage::default()
        };
        let frame = Buffer::from_slice(&self.device, "frame", &[*constants], uniform)?;
        let previous = Buffer::from_slice(&self.device, "previous_camera", &[previous], uniform)?;
        let (width, height) = (constants.view.width, constants.view.height);
        let mut surfaces = Vec::with_capacity(width as usize * height as usize);
        let strips = cut::<PrimarySurface>(&self.device, "primary", width, height)?;
        // All strips use this buffer, one after the other. The first strip has the most pixels.
        let most = strips.first().map_or(0, |strip| strip.pixels(width));
        let bytes = (most * size_of::<PrimarySurface>()) as u64;
        let primary = Buffer::new(&self.device, "primary", bytes, Usage::default())?;
        for strip in strips {
            let bindings = Primary {
                scene: &self.bindings,
                frame: &frame,
                previous_camera: &previous,
                primary: &primary,
                counters: &self.counters.buffer,
            };
            let mut recording = Recording::new(&self.device)?;
            recording.pass(&self.primary, &bindings, &strip, strip.groups(width))?;
            recording.finish()?;
            surfaces.extend(primary.read::<PrimarySurface>(strip.pixels(width))?);
        }
        Ok(surfaces)
    }
}
