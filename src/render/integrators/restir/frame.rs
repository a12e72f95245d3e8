//! The passes of one frame of reservoir resampling, in the order in which they run.

use super::Restir;
use super::bindings::{Surfaces, TracePilots};
use crate::Result;
use crate::gpu::Recording;

impl Restir {
    /// Records the upload of the constants and all passes of the current frame, from primary rays to shading, in the order
    /// in which they run. Passes that the settings do not need do not exist, and are left out.
    pub(super) fn record<'a>(&'a self, recording: &mut Recording<'a>) -> Result<()> {
        self.upload_constants(recording)?;
        let inputs = self.inputs();

        // Primary rays: the surface of each pixel, and emitted light.
        let surfaces = Surfaces {
            scene: inputs.scene,
            restir: &self.restir,
            sample_data: inputs.sample_data,
            color: inputs.color,
            covered: self.covered.as_ref(),
            counters: inputs.counters,
        };
        recording.pass(&self.surfaces, &surfaces, &(), inputs.groups)?;

        // The first BSDF ray of each pixel, which direct and indirect light share.
        let pilots = self.pilots();
        if let Some(pass) = &self.pilot_pass {
            let bindings = TracePilots {
                scene: inputs.scene,
                restir: &self.restir,
                sample_data: inputs.sample_data,
                pilots: pilots.buffer,
                counters: inputs.counters,
            };
            recording.pass(pass, &bindings, &(), inputs.groups)?;
        }

        // Candidates, temporal reuse, spatial reuse and shading of each kind of light.
        if let Some(direct) = &self.direct {
            direct.record(recording, &inputs, &pilots)?;
        }
        if let Some(indirect) = &self.indirect {
            indirect.record(recording, &inputs, pilots)?;
        }
        Ok(())
    }
}
