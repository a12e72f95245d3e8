//! A frame of reservoir resampling: its passes, in order.

use super::passes::{Surfaces, TracePilots};
use super::techniques::Restir;
use crate::Result;
use crate::gpu::{Buffer, Recording};

/// The buffer with the pilots of a frame. Where there is indirect light, it is the buffer of its current
/// reservoirs, which `initial_indirect` overwrites. So direct light borrows the pilots, and indirect light
/// takes them: no pass can be recorded that reads them later.
pub struct Pilots<'a> {
    /// The pilots, or the reservoirs that hold them.
    pub buffer: &'a Buffer,
}

/// Records the passes of a frame.
///
/// # Errors
/// A binding that a pass does not have.
pub fn record<'a>(restir: &'a Restir, recording: &mut Recording<'a>) -> Result<()> {
    let inputs = restir.inputs();

    // Primary rays: the surface of each pixel, and emitted light.
    let surfaces = Surfaces {
        scene: inputs.scene,
        restir: &restir.restir,
        sample_data: inputs.sample_data,
        color: inputs.color,
        counters: inputs.counters,
    };
    recording.pass(&restir.surfaces, &surfaces, &(), inputs.groups)?;

    // The first BSDF ray of each pixel, which direct and indirect light share.
    let pilots = restir.pilots();
    if let Some(pass) = &restir.pilot_pass {
        let bindings = TracePilots {
            scene: inputs.scene,
            restir: &restir.restir,
            sample_data: inputs.sample_data,
            pilots: pilots.buffer,
            counters: inputs.counters,
        };
        recording.pass(pass, &bindings, &(), inputs.groups)?;
    }

    // Candidates, temporal reuse, spatial reuse and shading of each kind of light.
    if let Some(direct) = &restir.direct {
        direct.record(recording, &inputs, &pilots)?;
    }
    if let Some(indirect) = &restir.indirect {
        indirect.record(recording, &inputs, pilots)?;
    }
    Ok(())
}
