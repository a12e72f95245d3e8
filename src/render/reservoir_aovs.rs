//! What a frame left in its reservoirs, for those who look for faults.

use super::offered::Offered;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::layouts::{ReservoirAov, RestirConstants, TILE};
use std::sync::Arc;

crate::bindings! {
    /// What the passes `aovs_…` are bound to.
    pub struct Bindings {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        read reservoirs,
        write reservoir_aovs,
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

/// What a frame's reservoirs hold, row by row from the top, as `pass` sees it.
///
/// # Errors
/// The device fails.
pub fn look(
    device: &Arc<Device>,
    offered: &Offered,
    pass: &ComputePass,
    frame: &Left<'_>,
) -> Result<Vec<ReservoirAov>> {
    let RestirConstants { width, height, .. } = *frame.constants;
    let pixels = width as usize * height as usize;
    let bytes = (pixels * size_of::<ReservoirAov>()) as u64;
    let reservoir_aovs = Buffer::new(device, "reservoir_aovs", bytes, Usage::default())?;
    let bindings = Bindings {
        scene: offered,
        restir: frame.restir,
        sample_data: frame.sample_data,
        reservoirs: frame.reservoirs,
        reservoir_aovs: &reservoir_aovs,
    };
    let groups = [width.div_ceil(TILE), height.div_ceil(TILE), 1];
    let mut recording = Recording::new(device)?;
    recording.pass(pass, &bindings, &(), groups)?;
    recording.finish()?;
    reservoir_aovs.read(pixels)
}
