//! Debug AOVs: the contents of the reservoirs after a frame.

use super::bindings::ReservoirAovs;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::{ReservoirAov, RestirConstants, TILE};
use std::sync::Arc;

/// The buffers that a frame of resampling has filled.
pub struct FrameOutputs<'a> {
    /// The constants of its shaders.
    pub constants: &'a RestirConstants,
    /// The buffer of these constants.
    pub restir: &'a Buffer,
    /// The sample data of the frame's primary surfaces.
    pub sample_data: &'a Buffer,
    /// The reservoirs after the last pass of the frame.
    pub reservoirs: &'a Buffer,
    /// The counters of all passes.
    pub counters: &'a Buffer,
}

/// Reads a frame's reservoirs by `pass`, row by row from the top.
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
