//! Debug AOVs of reservoir resampling: additional channels of a picture with the contents of the reservoirs after a frame,
//! which show, for example, which light each pixel selected.

use super::bindings::ReservoirAovs;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::render::scene_bindings::SceneBindings;
use crate::shader_interface::{ReservoirAov, RestirConstants, TILE};
use std::sync::Arc;

/// The buffers and constants of a finished frame of reservoir resampling, from which the debug AOVs are made.
pub struct FrameOutputs<'a> {
    /// The constants that the passes of direct or of indirect light have read in the frame; the width and the height of the
    /// picture are taken from them.
    pub constants: &'a RestirConstants,
    /// The uniform buffer on the device with the constants of the frame. The passes of direct or of indirect light have read
    /// them, and the pass `aovs_direct` or `aovs_indirect`, which reads the reservoirs, reads the same constants.
    pub restir: &'a Buffer,
    /// The sample data of the frame: the primary surface of each pixel, which is the surface that the camera sees there. The
    /// pass `aovs_direct` or `aovs_indirect` reads it, to compute the Jacobian of a sample that another pixel drew.
    pub sample_data: &'a Buffer,
    /// The reservoirs after the last pass of the frame, whose contents the debug AOVs show: those of direct or of indirect
    /// light.
    pub reservoirs: &'a Buffer,
    /// The buffer with the counters of all passes of the integrator. The pass `aovs_direct` or `aovs_indirect`, which reads
    /// the reservoirs, adds its counts to it.
    pub counters: &'a Buffer,
}

/// Returns the contents of the reservoirs after a frame, for debug AOVs: one entry per pixel, row by row from the top. To
/// this end, it runs `pass`, which is `aovs_direct` or `aovs_indirect`, and waits for the device.
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
