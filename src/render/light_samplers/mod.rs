//! Light samplers that have buffers or passes. Each has a folder here with its settings, passes and buffers, and a folder in
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

/// The buffers from which pixels draw light samples of direct light, and the passes that fill them in each frame.
pub trait LightSampler {
    /// The buffers of the sampler, each with the name of its binding in the shaders.
    fn buffers(&self) -> Vec<(&'static str, &Buffer)>;

    /// Writes the constants by which shaders read the buffers. By default, it writes nothing, for samplers that need no
    /// constants.
    fn set_constants(&self, _constants: &mut RestirConstants) {}

    /// Records the passes of a frame that fill the buffers, if there are any. `restir` is the buffer of the constants of
    /// direct light.
    ///
    /// # Errors
    /// The driver rejects a shader, or the names of the bindings differ from those in the shader.
    fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        inputs: &FrameInputs<'a>,
        restir: &'a Buffer,
    ) -> Result<()>;
}

/// The settings of the light samplers from which the pixels draw candidates of direct light.
#[derive(Clone, Copy)]
pub struct SamplerSettings<'a> {
    /// The settings of the light BVH if tiles of pixels draw lists from it; otherwise `None`, and there are no light lists.
    pub light_lists: Option<&'a LightBvhSettings>,
    /// The surfaces that fill the hash grid; [`HashGrid::None`] if there is no hash grid.
    pub filled_by: HashGrid,
    /// The settings of the hash grid; without effect if there is none.
    pub hash_grid: &'a HashGridSettings,
    /// The number of light samples per pixel and frame.
    pub light_samples: u32,
}

/// The inputs from which each light sampler makes its passes and buffers.
pub struct SamplerInputs<'a> {
    /// The device on which passes and buffers are made.
    pub device: &'a Arc<Device>,
    /// The scene on the device, whose surfaces can fill a sampler.
    pub scene: &'a GpuScene,
    /// The settings of all samplers, which decide whether a sampler exists.
    pub settings: SamplerSettings<'a>,
    /// The size of the picture in pixels, from which the sizes of buffers follow, and its camera.
    pub view: &'a ViewConstants,
    /// The size of a reservoir of direct light, in bytes.
    pub reservoir_bytes: u64,
    /// Makes the compute pass with a given name, with the specialisation of direct light.
    pub pass: &'a dyn Fn(&str) -> Result<ComputePass>,
}

/// A light sampler that was made, or `None` if the settings do not use it.
type Made = Option<Box<dyn LightSampler>>;

/// A kind of light sampler: the functions that compute its memory and make it.
struct Kind {
    /// The name and the size in bytes of each buffer, from the settings, the view and the bytes of a reservoir of direct
    /// light. Empty if the settings do not use the sampler.
    bytes: fn(&SamplerSettings<'_>, &ViewConstants, u64) -> Vec<(&'static str, u64)>,
    make: fn(&SamplerInputs<'_>) -> Result<Made>,
}

/// All kinds of light samplers that have buffers or passes. A new kind is registered by an entry here.
const KINDS: [Kind; 2] = [LightLists::KIND, HashGridLight::KIND];

/// The light samplers of a renderer that have buffers or passes: light lists, or the hash grid. Pixels draw candidates of
/// direct light from their buffers. Empty if the settings use none of them.
pub struct LightSamplers(Vec<Box<dyn LightSampler>>);

impl LightSamplers {
    /// Makes the samplers that the settings use, with their passes and buffers.
    ///
    /// # Errors
    /// A buffer exceeds a limit or the free memory of the device, or a pass cannot be made.
    pub fn new(inputs: &SamplerInputs<'_>) -> Result<Self> {
        let made = KINDS
            .iter()
            .filter_map(|kind| (kind.make)(inputs).transpose());
        Ok(Self(made.collect::<Result<_>>()?))
    }

    /// The name and the size in bytes of each buffer that [`Self::new`] would make. `reservoir_bytes` is the size of a
    /// reservoir of direct light.
    pub fn bytes(
        settings: &SamplerSettings<'_>,
        view: &ViewConstants,
        reservoir_bytes: u64,
    ) -> Vec<(&'static str, u64)> {
        let sizes = |kind: &Kind| (kind.bytes)(settings, view, reservoir_bytes);
        KINDS.iter().flat_map(sizes).collect()
    }

    /// The samplers that the settings use, in the order in which their passes run.
    pub fn iter(&self) -> impl Iterator<Item = &dyn LightSampler> {
        self.0.iter().map(|sampler| &**sampler)
    }

    /// The buffers of all samplers that passes of direct light may read, each with the name of its binding.
    pub fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let buffers = self.iter().flat_map(LightSampler::buffers);
        buffers
            .map(|(name, buffer)| (name, Resource::Read(buffer)))
            .collect()
    }
}
