//! What every pass may bind besides its own buffers: the scene, and the tables that materials look up.

use super::energy;
use super::light_bvh::LightBvhBuffer;
use super::settings::{Energy, Settings};
use super::specialisation;
use crate::Result;
use crate::device_scene::GpuScene;
use crate::gpu::{Buffer, ComputePass, Device, Resource, Usage};
use crate::shader_interface::Specialisation;
use std::sync::Arc;

/// The scene and the tables, and how shaders are specialised by them.
pub struct SceneBindings {
    /// The scene.
    pub scene: Arc<GpuScene>,
    /// The specialisation by scene and settings; techniques and passes add theirs.
    pub specialisation: Specialisation,
    specular_albedo: Buffer,
    light_bvh: LightBvhBuffer,
    device: Arc<Device>,
}

impl SceneBindings {
    /// Makes the tables that `settings` need, with at most `bounces` scattering events.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(
        device: &Arc<Device>,
        scene: Arc<GpuScene>,
        settings: &Settings,
        bounces: u32,
    ) -> Result<Self> {
        let table = match settings.energy {
            Energy::Compensated => energy::albedo_table(),
            Energy::Gltf => Vec::new(),
        };
        let usage = Usage::default();
        Ok(Self {
            specialisation: specialisation::of_scene(&scene, settings),
            specular_albedo: Buffer::from_slice(device, "specular_albedo", &table, usage)?,
            light_bvh: LightBvhBuffer::new(device, &scene, settings, bounces)?,
            scene,
            device: device.clone(),
        })
    }

    /// Makes the pass `glsl/passes/NAME.comp` for this scene.
    ///
    /// # Errors
    /// A shader whose interface cannot be bound by name.
    pub fn pass(&self, name: &str, specialisation: &Specialisation) -> Result<ComputePass> {
        let constants = specialisation.words();
        self.scene.pass(&self.device, name, &constants)
    }

    /// What shaders may bind.
    pub fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let mut resources = self.scene.resources();
        resources.push(("specular_albedo", Resource::Read(&self.specular_albedo)));
        resources.push(self.light_bvh.resource(self.scene.variant));
        resources
    }

    /// Poses the scene at the time `now`, and for passes that look back at the time `before`, both in seconds.
    ///
    /// # Errors
    /// At one of the times something is further away than can be rendered, or the device fails.
    pub fn set_pose(&self, now: f64, before: f64) -> Result<()> {
        self.scene.set_pose(now, before)?;
        self.light_bvh.follow(&self.scene)
    }

    /// Name and bytes of the light BVH's buffer, if there is one.
    pub fn light_bvh_memory(&self) -> Option<(&'static str, u64)> {
        self.light_bvh.memory()
    }

    /// Number of nodes of the light BVH; 0 if there is none.
    pub fn light_node_count(&self) -> u32 {
        self.light_bvh.node_count
    }
}
