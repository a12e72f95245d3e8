//! Light samplers with data of their own. Each has a folder here, with its settings, passes and buffers, and one in
//! `glsl/lights/samplers`, whose `pixel_samples.glsl` draws from all of them.

pub mod hash_grid;
pub mod light_bvh;

use super::frame_inputs::FrameInputs;
use crate::Result;
use crate::device_scene::GpuScene;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Resource};
use crate::shader_interface::{HashGrid, RestirConstants, ViewConstants};
use hash_grid::HashGridLight;
use hash_grid::settings::HashGridSettings;
use light_bvh::lists::LightLists;
use light_bvh::settings::LightBvhSettings;
use std::sync::Arc;

/// Data from which the pixels draw light samples of direct light, and the passes that make it in each frame.
pub trait LightSampler {
    /// The buffers, by the names of their bindings.
    fn buffers(&self) -> Vec<(&'static str, &Buffer)>;

    /// Sets what shaders need to know about the buffers.
    fn set_constants(&self, _constants: &mut RestirConstants) {}

    /// Records the passes of a frame, if it has any. `restir` holds the constants of direct light.
    ///
    /// # Errors
    /// A binding that a pass does not have.
    fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        restir: &'a Buffer,
    ) -> Result<()>;
}

/// The settings of the light samplers that the pixels use.
#[derive(Clone, Copy)]
pub struct SamplerSettings<'a> {
    /// The light BVH, if tiles of pixels draw lists from it.
    pub light_lists: Option<&'a LightBvhSettings>,
    /// The surfaces that fill the hash grid.
    pub filled_by: HashGrid,
    /// The hash grid.
    pub hash_grid: &'a HashGridSettings,
    /// Light samples per pixel.
    pub light_samples: u32,
}

/// From what light samplers are made.
pub struct SamplerInputs<'a> {
    /// The device.
    pub device: &'a Arc<Device>,
    /// The scene.
    pub scene: &'a GpuScene,
    /// The settings.
    pub settings: SamplerSettings<'a>,
    /// The picture.
    pub view: &'a ViewConstants,
    /// Bytes of a reservoir of direct light.
    pub reservoir_bytes: u64,
    /// Makes a pass by name.
    pub pass: &'a dyn Fn(&str) -> Result<ComputePass>,
}

/// A light sampler, if the settings use it.
type Made = Option<Box<dyn LightSampler>>;

/// A kind of light sampler.
struct Kind {
    /// The sizes in bytes of its buffers, by name; empty if the settings do not use it.
    bytes: fn(&SamplerSettings<'_>, &ViewConstants, u64) -> Vec<(&'static str, u64)>,
    make: fn(&SamplerInputs<'_>) -> Result<Made>,
}

/// All kinds; a new one is a line here.
const KINDS: [Kind; 2] = [LightLists::KIND, HashGridLight::KIND];

/// The light samplers of the pixels that the settings use.
pub struct LightSamplers(Vec<Box<dyn LightSampler>>);

impl LightSamplers {
    /// Makes the samplers.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(inputs: &SamplerInputs<'_>) -> Result<Self> {
        let made = KINDS
            .iter()
            .filter_map(|kind| (kind.make)(inputs).transpose());
        Ok(Self(made.collect::<Result<_>>()?))
    }

    /// The sizes in bytes of the buffers that [`Self::new`] would make, by name.
    pub fn bytes(
        settings: &SamplerSettings<'_>,
        view: &ViewConstants,
        reservoir_bytes: u64,
    ) -> Vec<(&'static str, u64)> {
        let sizes = |kind: &Kind| (kind.bytes)(settings, view, reservoir_bytes);
        KINDS.iter().flat_map(sizes).collect()
    }

    /// All samplers.
    pub fn iter(&self) -> impl Iterator<Item = &dyn LightSampler> {
        self.0.iter().map(|sampler| &**sampler)
    }

    /// What passes of direct light may bind.
    pub fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let buffers = self.iter().flat_map(LightSampler::buffers);
        buffers
            .map(|(name, buffer)| (name, Resource::Read(buffer)))
            .collect()
    }
}
