//! The resources that every pass may bind besides its own buffers: the scene, the light BVH, and a table for materials.

use super::energy;
use crate::Result;
use crate::device_scene::GpuScene;
use crate::gpu::{Buffer, ComputePass, Device, Resource, Usage};
use crate::shader_interface::{Specialisation, Variant};
use std::sync::Arc;

/// A buffer that is computed from the scene, such as the light BVH. Every pass may bind it, and it is updated when the scene
/// moves.
pub trait SceneResource: Send + Sync {
    /// The name of the binding and the buffer, in the form in which shaders of `variant` read it (as texels or as storage).
    fn resource(&self, variant: Variant) -> (&'static str, Resource<'_>);

    /// The name and the size in bytes of the buffer; `None` if it is empty.
    fn memory(&self) -> Option<(&'static str, u64)>;

    /// Updates the buffer to the current pose of `scene`.
    ///
    /// # Errors
    /// The device fails, or an earlier update failed in another thread.
    fn follow(&self, scene: &GpuScene) -> Result<()>;
}

/// The resources that every pass may bind, and the specialisation constants that scene and settings decide. All passes of a
/// renderer are made from it.
pub struct SceneBindings {
    /// The scene on the device.
    pub scene: Arc<GpuScene>,
    /// The specialisation constants that follow from the scene and from the settings `energy` and `variant`. Integrators set
    /// the other constants in a copy.
    pub specialisation: Specialisation,
    specular_albedo: Buffer,
    light_bvh: Box<dyn SceneResource>,
    device: Arc<Device>,
}

impl SceneBindings {
    /// Collects the resources and constants from which the passes of a renderer are made. If shaders compensate the energy
    /// that single scattering loses, it also makes the table of specular albedos that they read.
    ///
    /// # Errors
    /// The table exceeds a limit or the free memory of the device.
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

    /// Makes the compute pass `NAME.comp` for this scene, with the constants of `specialisation`.
    ///
    /// # Errors
    /// The shader's interface cannot be bound by name.
    pub fn pass(&self, name: &str, specialisation: &Specialisation) -> Result<ComputePass> {
        let constants = specialisation.words();
        self.scene.pass(&self.device, name, &constants)
    }

    /// All resources that a pass may bind, each with the name of its binding in the shaders.
    pub fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let mut resources = self.scene.resources();
        resources.push(("specular_albedo", Resource::Read(&self.specular_albedo)));
        resources.push(self.light_bvh.resource(self.scene.variant));
        resources
    }

    /// Moves the scene to its pose at the time `now`. Passes that use the previous frame see it in its pose at the time
    /// `before`. Both times are in seconds.
    ///
    /// # Errors
    /// At one of the times an instance is too far away to be rendered, or the device fails.
    pub fn set_pose(&self, now: f64, before: f64) -> Result<()> {
        self.scene.set_pose(now, before)?;
        self.light_bvh.follow(&self.scene)
    }

    /// The name and the size in bytes of the light BVH's buffer; `None` if no candidates are drawn from a light BVH.
    pub fn light_bvh_memory(&self) -> Option<(&'static str, u64)> {
        self.light_bvh.memory()
    }
}
