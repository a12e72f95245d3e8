//! Debug AOVs (additional channels of a picture): the contents of the reservoirs after a frame.

use super::bindings::ReservoirAovs;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::{ReservoirAov, RestirConstants, TILE};
use std::sync::Arc;

/// The buffers that a frame of resampling has filled, from which the debug AOVs are read.
pub struct FrameOutputs<'a> {
    /// The constants that the shaders of the frame have read.
    pub constants: &'a RestirConstants,
    /// The uniform buffer that holds the constants of the frame.
    pub restir: &'a Buffer,
    /// The sample data of the frame: the primary surface of each pixel.
    pub sample_data: &'a Buffer,
    /// The reservoirs of direct or of indirect light after the last pass of the frame.
    pub reservoirs: &'a Buffer,
    /// The buffer of the counters of all passes.
    pub counters: &'a Buffer,
}

/// Runs `pass` (`aovs_direct` or `aovs_indirect`) after a frame and returns the contents of its reservoirs, one entry per
/// pixel, row by row from the top.
pub fn read_reservoir_aovs(
    device: &Arc<Device>,
    scene: &SceneBindings,
    pass: &ComputePass,
    frame: &FrameOutputs<'_>,
) -> Result<Vec<ReservoirAov>> {
    let (width, height) = (frame.constants.view.width, frame.constants.view.height);
    let pixels = width as usize * height as usize;
    let bytes = (pixels * size_of::<ReservoirAov>()) as u64;
    let reservoir_aovs = Buffer::new(device, "reservoir_aovs", bytes, Usage::default())?;
    let bindings = ReservoirAovs {
        scene,
        restir: frame.restir,
        sample_data: frame.sample_data,
        reservoirs: frame.reservoirs,
        reservoir_aovs: &reservoir_aovs,
        counters: frame.counters,
    };
    let groups = [width.div_ceil(TILE), height.div_ceil(TILE), 1];
    let mut recording = Recording::new(device)?;
    recording.pass(pass, &bindings, &(), groups)?;
    recording.finish()?;
    reservoir_aovs.read(pixels)
}
