//! The part of reservoir resampling that direct and indirect light have in common: temporal reuse, spatial reuse and
//! shading.

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

/// The reservoirs of one kind of light (direct or indirect), and the passes that reuse and shade them. Passes that the
/// settings do not need are not made, since a driver takes seconds to compile one.
pub struct Reuse {
    /// The settings of resampling for this kind of light (direct or indirect), by which the host decides which passes to run
    /// and which code of the shaders to compile.
    pub resampling: Resampling,
    /// The settings of resampling in the form that shaders read. They are the same in all frames, and are copied into the
    /// constants of each frame.
    reuse: ReuseConstants,
    temporal: Option<ComputePass>,
    spatial: Option<ComputePass>,
    /// The pass that adds the light of the selected samples to the picture. `None` if the last spatial pass adds this light,
    /// or if candidates are not stored in reservoirs.
    shade: Option<ComputePass>,
    /// The constants of the current frame for all passes of this kind of light (direct or indirect).
    pub constants: RestirConstants,
    /// The uniform buffer on the device to which `constants` are uploaded in each frame. All passes of this kind of light
    /// bind it.
    pub restir: Buffer,
    /// The reservoirs of this frame, and in a second copy those of the previous frame. A reservoir stores the selected
    /// sample of one pixel. After temporal reuse, spatial passes write their results to the second copy, because its data is
    /// no longer needed. If the settings turn off both temporal and spatial reuse, there is only one copy.
    pub reservoirs: History<Buffer>,
}

impl Reuse {
    /// Makes the passes and buffers of one kind of light. If `uses_reservoirs` is false, the pass `initial_direct` or
    /// `initial_indirect` adds the light of the candidates to the picture, and there is no pass for shading.
    /// `reservoir_bytes` is the size of one copy of the reservoirs. `pass` makes the compute pass with a given name.
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

    /// Begins a frame: sets the constants of its passes to `constants`, together with the settings of resampling, and
    /// makes the reservoirs of the frame that was rendered last those of the previous frame, which temporal reuse merges.
    pub fn begin_frame(&mut self, constants: &RestirConstants) {
        self.reservoirs.advance();
        self.constants = RestirConstants {
            reuse: self.reuse,
            ..*constants
        };
    }

    /// Records the passes of temporal reuse, spatial reuse and shading of a frame, and leaves out those that do not exist.
    /// When this method is called, the initial pass (`initial_direct` or `initial_indirect`) is recorded already; its
    /// candidates are in the current reservoirs. If there is no previous frame, temporal reuse is left out.
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
