//! What every pass may bind besides its own buffers: the scene, and the tables that materials look up.

use super::energy;
use super::settings::{Energy, Settings};
use super::specialisation::Specialisation;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Resource, Usage};
use crate::tracing::{GpuScene, shaders};
use std::sync::Arc;

/// The scene and the tables, and how shaders are specialised by them.
pub struct SceneBindings {
    /// The scene.
    pub scene: Arc<GpuScene>,
    /// The specialisation by scene and settings; techniques and passes add theirs.
    pub specialisation: Specialisation,
    specular_albedo: Buffer,
    device: Arc<Device>,
}

impl SceneBindings {
    /// Makes the tables that `settings` need.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(device: &Arc<Device>, scene: Arc<GpuScene>, settings: &Settings) -> Result<Self> {
        let table = match settings.energy {
            Energy::Compensated => energy::albedo_table(),
            Energy::Gltf => Vec::new(),
        };
        let usage = Usage::default();
        Ok(Self {
            specialisation: Specialisation::of_scene(&scene, settings),
            specular_albedo: Buffer::from_slice(device, "specular_albedo", &table, usage)?,
            scene,
            device: device.clone(),
        })
    }

    /// Makes the pass `glsl/passes/NAME.comp` for this scene.
    ///
    /// # Errors
    /// A shader whose interface cannot be bound by name.
    pub fn pass(&self, name: &str, specialisation: &Specialisation) -> Result<ComputePass> {
        let spirv = shaders::spirv(name, self.scene.variant)?;
        ComputePass::with_images(
            &self.device,
            name,
            &spirv,
            &specialisation.words(),
            self.scene.image_count(),
        )
    }

    /// What shaders may bind.
    pub fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let mut resources = self.scene.resources();
        resources.push(("specular_albedo", Resource::Read(&self.specular_albedo)));
        resources
    }
}
