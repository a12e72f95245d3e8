//! The bindings that every pass may use besides its own buffers: the scene, and the tables for materials.

use super::energy;
use crate::Result;
use crate::device_scene::GpuScene;
use crate::gpu::{Buffer, ComputePass, Device, Resource, Usage};
use crate::shader_interface::{Specialisation, Variant};
use std::sync::Arc;

/// A buffer made from the scene, which every pass may bind, and which follows the scene in motion.
pub trait SceneResource: Send + Sync {
    /// The name and the buffer, for shaders of a variant.
    fn resource(&self, variant: Variant) -> (&'static str, Resource<'_>);

    /// The name and the size in bytes of the buffer, unless it is empty.
    fn memory(&self) -> Option<(&'static str, u64)>;

    /// Fits the buffer to the scene as it is now.
    ///
    /// # Errors
    /// The device fails.
    fn follow(&self, scene: &GpuScene) -> Result<()>;
}

/// The scene, the tables, and the specialisation of shaders that follows from them.
pub struct SceneBindings {
    /// The scene.
    pub scene: Arc<GpuScene>,
    /// The specialisation by scene and settings; integrators and passes add their constants.
    pub specialisation: Specialisation,
    specular_albedo: Buffer,
    light_bvh: Box<dyn SceneResource>,
    device: Arc<Device>,
}

impl SceneBindings {
    /// Makes the table of the energy that single scattering loses, if shaders compensate it.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(
        device: &Arc<Device>,
        scene: Arc<GpuScene>,
        specialisation: Specialisation,
        light_bvh: Box<dyn SceneResource>,
    ) -> Result<Self> {
        let table = match specialisation.energy_compensated {
            true => energy::albedo_table(),
            false => Vec::new(),
        };
        let usage = Usage::default();
        Ok(Self {
            specialisation,
            specular_albedo: Buffer::from_slice(device, "specular_albedo", &table, usage)?,
            light_bvh,
            scene,
            device: device.clone(),
        })
    }

    /// Makes the pass `NAME.comp` for this scene.
    ///
    /// # Errors
    /// A shader whose interface cannot be bound by name.
    pub fn pass(&self, name: &str, specialisation: &Specialisation) -> Result<ComputePass> {
        let constants = specialisation.words();
        self.scene.pass(&self.device, name, &constants)
    }

    /// The resources that shaders may bind, by name.
    pub fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let mut resources = self.scene.resources();
        resources.push(("specular_albedo", Resource::Read(&self.specular_albedo)));
        resources.push(self.light_bvh.resource(self.scene.variant));
        resources
    }

    /// Poses the scene at the time `now`, and for passes that use the previous frame also at the time `before`, both in
    /// seconds.
    ///
    /// # Errors
    /// At one of the times something is further away than can be rendered, or the device fails.
    pub fn set_pose(&self, now: f64, before: f64) -> Result<()> {
        self.scene.set_pose(now, before)?;
        self.light_bvh.follow(&self.scene)
    }

    /// The name and the size in bytes of the light BVH's buffer, if there is one.
    pub fn light_bvh_memory(&self) -> Option<(&'static str, u64)> {
        self.light_bvh.memory()
    }
}
