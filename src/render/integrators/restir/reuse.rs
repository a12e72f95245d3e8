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

/// Temporal reuse, spatial reuse and shading of direct or indirect light: the reservoirs, and only the passes that the settings
/// need, since a driver takes seconds to compile one.
pub struct Reuse {
    /// The resampling of this light.
    pub resampling: Resampling,
    /// The constants of the resampling, for shaders.
    reuse: ReuseConstants,
    temporal: Option<ComputePass>,
    spatial: Option<ComputePass>,
    /// The pass that shades; `None` if the last merge adds the light.
    shade: Option<ComputePass>,
    /// The constants of these passes.
    pub constants: RestirConstants,
    /// The buffer that holds them.
    pub restir: Buffer,
    /// The reservoirs of this frame, and of the previous one until a spatial pass overwrites them.
    pub reservoirs: History<Buffer>,
}

impl Reuse {
    /// Makes the passes and buffers; `pass` makes a pass by name. Without `shares`, candidates are not stored in reservoirs,
    /// and there is no pass that shades.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(
        device: &Arc<Device>,
        lighting: Lighting,
        resampling: Resampling,
        reuse: ReuseConstants,
        shares: bool,
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
            shade: if_needed(shares && !merge_shades, names.shade)?,
            constants: RestirConstants::default(),
            restir: Buffer::new(device, "restir", bytes, uniform)?,
            reservoirs: History::new(reservoirs),
            resampling,
            reuse,
        })
    }

    /// Begins a frame with these constants, to which the constants of this light are added.
    pub fn begin_frame(&mut self, constants: &RestirConstants) {
        self.reservoirs.advance();
        self.constants = RestirConstants {
            reuse: self.reuse,
            ..*constants
        };
    }

    /// Records the passes; the current reservoirs hold the candidates.
    ///
    /// # Errors
    /// A binding that a pass does not have.
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
