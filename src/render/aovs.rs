//! Arbitrary output variables: what the camera sees through each pixel's centre.

use super::offered::Offered;
use super::strips::cut;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::layouts::{FrameConstants, GpuCamera, PrimarySurface};
use std::sync::Arc;

crate::bindings! {
    /// What the pass `primary` is bound to.
    pub struct Primary {
        [offers scene: Offered]
        uniform frame,
        uniform previous_camera,
        write primary,
    }
}

/// The pass that looks at primary surfaces.
pub struct Aovs {
    device: Arc<Device>,
    offered: Arc<Offered>,
    primary: ComputePass,
}

impl Aovs {
    /// Makes the pass.
    ///
    /// # Errors
    /// A shader that the device refuses.
    pub fn new(device: &Arc<Device>, offered: &Arc<Offered>) -> Result<Self> {
        Ok(Self {
            primary: offered.pass("primary", &[])?,
            offered: offered.clone(),
            device: device.clone(),
        })
    }

    /// What the camera sees, row by row from the top; `previous` is where the camera was in the last
    /// frame.
    ///
    /// # Errors
    /// The device fails.
    pub fn surfaces(
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
        let FrameConstants { width, height, .. } = *constants;
        let mut surfaces = Vec::with_capacity(width as usize * height as usize);
        let strips = cut::<PrimarySurface>(&self.device, "primary", width, height)?;
        // One strip after the other, in the same memory; the first is as large as any.
        let most = strips.first().map_or(0, |strip| strip.pixels(width));
        let bytes = (most * size_of::<PrimarySurface>()) as u64;
        let primary = Buffer::new(&self.device, "primary", bytes, Usage::default())?;
        for strip in strips {
            let bindings = Primary {
                scene: self.offered.as_ref(),
                frame: &frame,
                previous_camera: &previous,
                primary: &primary,
            };
            let mut recording = Recording::new(&self.device)?;
            recording.pass(&self.primary, &bindings, &strip, strip.groups(width))?;
            recording.finish()?;
            surfaces.extend(primary.read::<PrimarySurface>(strip.pixels(width))?);
        }
        Ok(surfaces)
    }
}
