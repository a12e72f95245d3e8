//! Light samplers (methods that draw lights for candidates) that have buffers or passes: light lists and the hash grid. The
//! settings, passes and buffers of each sampler are in a folder here, and its shaders in a folder of `glsl/lights/samplers`.
//! With every sampler, pixels draw their candidates of direct light by the functions of
//! `glsl/lights/samplers/pixel_samples.glsl`.

pub mod hash_grid;
pub mod light_bvh;

use super::frame_inputs::FrameInputs;
use crate::Result;
use crate::device_scene::GpuScene;
use crate::gpu::{Buffer, ComputePass, Device, Offers, Recording, Resource};
use crate::shader_interface::{HashGrid, RestirConstants, ViewConstants};
use hash_grid::HashGridLight;
use hash_grid::settings::HashGridSettings;
use light_bvh::lists::LightLists;
use light_bvh::settings::LightBvhSettings;
use std::sync::Arc;

/// A light sampler that has buffers: pixels draw their light candidates of direct light with the help of these buffers. The
/// sampler also has the passes that fill the buffers, and the numbers that shaders need to read them.
pub trait LightSampler {
    /// The buffers that pixels read to draw candidates of direct light (the light lists, or the points, slots and reservoirs
    /// of the hash grid), each with the name of its binding in the shaders.
    fn buffers(&self) -> Vec<(&'static str, &Buffer)>;

    /// Writes to `constants` the numbers that shaders need to read the buffers, such as the size of a cell. By default, it
    /// writes nothing, for samplers that need no such numbers.
    fn set_constants(&self, _constants: &mut RestirConstants) {}

    /// Records the passes that fill the buffers of the sampler. It records nothing in a frame that does not use the buffers,
    /// or that uses their contents from an earlier frame. `restir` is the buffer with the constants of direct light, which
    /// these passes bind.
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

/// The settings that decide which light samplers have buffers, how large the buffers are, and how they are filled. All
/// concern candidates of direct light.
#[derive(Clone, Copy)]
pub struct SamplerSettings<'a> {
    /// The settings of the light BVH if one pixel of each tile draws a list of lights from it; `None` if there are no light
    /// lists.
    pub light_lists: Option<&'a LightBvhSettings>,
    /// The points for which the hash grid makes reservoirs: surfaces of pixels, or points on all surfaces of the scene.
    /// [`HashGrid::None`] if there is no hash grid.
    pub filled_by: HashGrid,
    /// The settings of the hash grid; they have no effect if there is no hash grid.
    pub hash_grid: &'a HashGridSettings,
    /// The number of light candidates of direct light per pixel and frame. With `hash_grid.mode=published`, the confidence
    /// of the grid's reservoirs is computed from it.
    pub light_samples: u32,
}

/// The inputs from which each light sampler makes its passes and buffers when the renderer is made.
pub struct SamplerInputs<'a> {
    /// The Vulkan device on which the sampler makes its passes and buffers.
    pub device: &'a Arc<Device>,
    /// The scene on the device. With `hash_grid.mode=published`, the hash grid makes reservoirs for points on the surfaces
    /// of this scene.
    pub scene: &'a GpuScene,
    /// The settings of all samplers. From them, each sampler decides whether it makes anything.
    pub settings: SamplerSettings<'a>,
    /// The view: the size of the picture, from which the number of light lists or of reservoirs follows.
    pub view: &'a ViewConstants,
    /// The size of one reservoir of direct light, in bytes. The hash grid stores reservoirs of this size, so the size of its
    /// buffer follows from it.
    pub reservoir_bytes: u64,
    /// Makes the compute pass with the given name. Its specialisation constants are those of the passes of direct light.
    pub pass: &'a dyn Fn(&str) -> Result<ComputePass>,
}

/// The result of making a light sampler: the sampler with its passes and buffers, or `None` if the settings do not use the
/// sampler.
type Made = Option<Box<dyn LightSampler>>;

/// A kind of light sampler: a function that computes the sizes of its buffers, so that they can be checked before anything
/// is made, and a function that makes the sampler.
struct Kind {
    /// Returns the name and the size in bytes of each buffer. The arguments are the settings, the view, and the bytes of one
    /// reservoir of direct light. The result is empty if the settings do not use the sampler.
    bytes: fn(&SamplerSettings<'_>, &ViewConstants, u64) -> Vec<(&'static str, u64)>,
    make: fn(&SamplerInputs<'_>) -> Result<Made>,
}

/// All kinds of light samplers that have buffers or passes. [`LightSamplers`] makes those that the settings use. A new kind
/// is registered by an entry here.
const KINDS: [Kind; 2] = [LightLists::KIND, HashGridLight::KIND];

/// The light samplers of a renderer that have buffers or passes: light lists, or the hash grid. Pixels draw candidates of
/// direct light from their buffers. The list is empty if the settings use neither.
pub struct LightSamplers(Vec<Box<dyn LightSampler>>);

impl Offers for LightSamplers {
    /// The buffers of all samplers, each with the name of its binding in the shaders. Passes of direct light can bind them
    /// for reading.
    fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let buffers = self.iter().flat_map(LightSampler::buffers);
        buffers
            .map(|(name, buffer)| (name, Resource::Read(buffer)))
            .collect()
    }
}

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

    /// The name and the size in bytes of each buffer that [`Self::new`] would make. The caller checks these sizes against
    /// the memory and the limits of the device before it makes the buffers. `reservoir_bytes` is the size of one reservoir
    /// of direct light, in bytes.
    pub fn bytes(
        settings: &SamplerSettings<'_>,
        view: &ViewConstants,
        reservoir_bytes: u64,
    ) -> Vec<(&'static str, u64)> {
        let sizes = |kind: &Kind| (kind.bytes)(settings, view, reservoir_bytes);
        KINDS.iter().flat_map(sizes).collect()
    }

    /// The samplers that the settings use, in the order in which their passes run; empty if the settings use none.
    pub fn iter(&self) -> impl Iterator<Item = &dyn LightSampler> {
        self.0.iter().map(|sampler| &**sampler)
    }
}
