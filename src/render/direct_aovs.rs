//! What a frame left in its reservoirs of direct light, for those who look for faults.

use super::offered::Offered;
use super::settings::Reservoirs;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::layouts::{DirectAov, RestirConstants, TILE};
use std::sync::Arc;

crate::bindings! {
    /// What the pass `direct_aovs` is bound to.
    pub struct Bindings {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        read reservoirs,
        write direct_aovs,
    }
}

/// What a frame of resampling left behind.
pub struct Left<'a> {
    /// What its shaders were told.
    pub constants: &'a RestirConstants,
    /// The buffer that told them.
    pub restir: &'a Buffer,
    /// Its primary surfaces.
    pub sample_data: &'a Buffer,
    /// Its reservoirs, as the last pass found them.
    pub reservoirs: &'a Buffer,
}

/// The pass that looks into reservoirs.
pub struct DirectAovs {
    device: Arc<Device>,
    offered: Arc<Offered>,
    pass: ComputePass,
}

impl DirectAovs {
    /// Makes the pass for reservoirs that lie so.
    ///
    /// # Errors
    /// A shader that the device refuses.
    pub fn new(
        device: &Arc<Device>,
        offered: &Arc<Offered>,
        reservoirs: &Reservoirs,
    ) -> Result<Self> {
        Ok(Self {
            pass: offered.pass("direct_aovs", &reservoirs.constants())?,
            offered: offered.clone(),
            device: device.clone(),
        })
    }

    /// What the frame's reservoirs hold, row by row from the top.
    ///
    /// # Errors
    /// The device fails.
    pub fn look(&self, frame: &Left<'_>) -> Result<Vec<DirectAov>> {
        let RestirConstants { width, height, .. } = *frame.constants;
        let pixels = width as usize * height as usize;
        // Smaller than its primary surfaces, so it can be bound where those could.
        let bytes = (pixels * size_of::<DirectAov>()) as u64;
        let direct_aovs = Buffer::new(&self.device, "direct_aovs", bytes, Usage::default())?;
        let bindings = Bindings {
            scene: self.offered.as_ref(),
            restir: frame.restir,
            sample_data: frame.sample_data,
            reservoirs: frame.reservoirs,
            direct_aovs: &direct_aovs,
        };
        let groups = [width.div_ceil(TILE), height.div_ceil(TILE), 1];
        let mut recording = Recording::new(&self.device)?;
        recording.pass(&self.pass, &bindings, &(), groups)?;
        recording.finish()?;
        direct_aovs.read(pixels)
    }
}
