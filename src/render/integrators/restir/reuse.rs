//! The part of resampling that direct and indirect light have in common: temporal reuse, spatial reuse and shading.

use super::bindings::{Shade, Spatial, Temporal};
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::render::frame_inputs::FrameInputs;
use crate::render::history::History;
use crate::render::lighting::Lighting;
use crate::render::settings::{Resampling, ReuseMode};
use crate::shader_interface::Visibility;
use crate::shader_interface::{RestirConstants, ReuseConstants, SpatialStep};
use std::sync::Arc;

/// The reservoirs of direct or of indirect light, and the passes that reuse and shade them. Only passes that the settings
/// need exist, since a driver takes seconds to compile one.
pub struct Reuse {
    /// The settings of resampling for direct or for indirect light, whichever these reservoirs hold.
    pub resampling: Resampling,
    /// The settings of resampling as constants, which are the same in all frames.
    reuse: ReuseConstants,
    temporal: Option<ComputePass>,
    spatial: Option<ComputePass>,
    /// The pass that adds the light of the selected samples to the picture; `None` if the last spatial pass adds it, or if
    /// there are no reservoirs.
    shade: Option<ComputePass>,
    /// The constants of the current frame for the passes that reuse and shade these reservoirs.
    pub constants: RestirConstants,
    /// The uniform buffer that holds the constants of the current frame for the passes that reuse and shade these
    /// reservoirs.
    pub restir: Buffer,
    /// The reservoirs of this frame and, until a spatial pass overwrites them, those of the previous frame. Without reuse,
    /// there is one copy.
    pub reservoirs: History<Buffer>,
}

impl Reuse {
    /// Makes the passes and buffers. Without `uses_reservoirs`, candidates are not stored in reservoirs, and no pass shades.
    /// `reservoir_bytes` is the size of one copy of the reservoirs, and `pass` makes the compute pass with a given name.
    ///
    /// # Errors
    /// A buffer exceeds a limit or the free memory of the device, or `pass` fails.
    pub fn new(
        device: &Arc<Device>,
        lighting: Lighting,
        resampling: Resampling,
        reuse: ReuseConstants,
        uses_reservoirs: bool,
        reservoir_bytes: u64,
        pass: impl Fn(&str) -> Result<ComputePass>,
    ) -> Result<Self> {
        let names = lighting.passes();
        let mode = resampling.reuse;
        // The last merge can add the light of all its samples, unless their visibility is still to be traced.
        let needs_no_ray = matches!(
            resampling.visibility,
            Visibility::None | Visibility::Weights
        );
        let merge_shades = mode.is_spatial() && needs_no_ray;
        let if_needed = |needed: bool, name: &str| needed.then(|| pass(name)).transpose();
        let uniform = Usage {
            uniform: true,
            ..Usage::default()
        };
        let bytes = size_of::<RestirConstants>() as u64;
        let copies = if mode == ReuseMode::None { 1 } else { 2 };
        let reservoirs = (0..copies)
            .map(|_| Buffer::new(device, "reservoirs", reservoir_bytes, Usage::default()))
            .collect::<Result<_>>()?;
        Ok(Self {
            temporal: if_needed(mode.is_temporal(), names.temporal)?,
            spatial: if_needed(mode.is_spatial(), names.spatial)?,
            shade: if_needed(uses_reservoirs && !merge_shades, names.shade)?,
            constants: RestirConstants::default(),
            restir: Buffer::new(device, "restir", bytes, uniform)?,
            reservoirs: History::new(reservoirs),
            resampling,
            reuse,
        })
    }

    /// Advances the reservoirs to the next frame, and sets the constants of its passes: `constants`, with the settings of
    /// resampling added.
    pub fn begin_frame(&mut self, constants: &RestirConstants) {
        self.reservoirs.advance();
        self.constants = RestirConstants {
            reuse: self.reuse,
            ..*constants
        };
    }

    /// Records temporal reuse, spatial reuse and shading, each if its pass exists. The current reservoirs hold the
    /// candidates.
    ///
    /// # Errors
    /// The driver rejects a shader, or the names of the bindings differ from those in the shader.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
    ) -> Result<()> {
        let FrameInputs {
            scene,
            sample_data,
            previous_sample_data,
            color,
            counters,
            groups,
            frame: _,
            is_first: _,
        } = *inputs;
        let (restir, reservoirs) = (&self.restir, &self.reservoirs);

        if let (Some(pass), Some(previous_sample_data), Some(history)) =
            (&self.temporal, previous_sample_data, reservoirs.previous())
        {
            let temporal = Temporal {
                scene,
                restir,
                sample_data,
                previous_sample_data,
                history,
                reservoirs: reservoirs.current(),
                counters,
            };
            recording.pass(pass, &temporal, &(), groups)?;
        }

        if let Some(pass) = &self.spatial {
            let passes = self.resampling.spatial.passes;
            for index in 0..passes {
                let spatial = Spatial {
                    scene,
                    restir,
                    sample_data,
                    neighbours: reservoirs.current(),
                    reservoirs: reservoirs.spare(),
                    color,
                    counters,
                };
                let is_last = index + 1 == passes;
                let step = SpatialStep {
                    index,
                    shades: (is_last && self.shade.is_none()).into(),
                };
                recording.pass(pass, &spatial, &step, groups)?;
                reservoirs.advance();
            }
        }

        if let Some(pass) = &self.shade {
            let shade = Shade {
                scene,
                restir,
                sample_data,
                reservoirs: reservoirs.current(),
                color,
                counters,
            };
            recording.pass(pass, &shade, &(), groups)?;
        }
        Ok(())
    }
}
