//! The resources that every pass may bind besides its own buffers: the scene, the light BVH (a tree of lights), and a table
//! of the energy that specular lobes reflect.

use super::energy;
use crate::Result;
use crate::device_scene::GpuScene;
use crate::gpu::{Buffer, ComputePass, Device, Offers, Resource, Usage};
use crate::shader_interface::{Specialisation, Variant};
use std::sync::Arc;

/// A buffer that is computed from the scene, such as the light BVH (a tree of lights). Every pass may bind it. When the
/// scene moves to another time, [`Self::follow`] computes the buffer again, so that it fits the scene at this time.
pub trait SceneResource: Send + Sync {
    /// The name of the binding in the shaders, and the buffer in the form in which it is bound: as texels or as a storage
    /// buffer. `variant` (the combination of tracer and access to memory for which shaders are compiled) decides the
    /// form.
    fn resource(&self, variant: Variant) -> (&'static str, Resource<'_>);

    /// The name and the size in bytes of this buffer, for reports of memory; `None` if the buffer is empty.
    fn memory(&self) -> Option<(&'static str, u64)>;

    /// Writes the buffer again for the current pose of `scene` (its state at one time), unless it was already computed for
    /// the time of this pose.
    ///
    /// # Errors
    /// The device fails, or an earlier update failed in another thread.
    fn follow(&self, scene: &GpuScene) -> Result<()>;
}

/// The resources that every pass may bind besides its own buffers, and the specialisation constants that follow from scene
/// and settings. All passes of a renderer use the same `SceneBindings`, so that they compute with the same scene.
pub struct SceneBindings {
    /// The scene on the device: its buffers, which passes bind, and its units of length and radiance.
    pub scene: Arc<GpuScene>,
    /// The specialisation constants that follow from the scene and from the settings `energy` and `variant`. All other
    /// constants have their defaults here; an integrator sets them in a copy, for its own passes.
    pub specialisation: Specialisation,
    specular_albedo: Buffer,
    light_bvh: Box<dyn SceneResource>,
    device: Arc<Device>,
}

impl Offers for SceneBindings {
    /// All resources that a pass may bind besides its own buffers, each with the name of its binding in the shaders.
    fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let mut resources = self.scene.resources();
        resources.push(("specular_albedo", Resource::Read(&self.specular_albedo)));
        resources.push(self.light_bvh.resource(self.scene.variant));
        resources
    }
}

impl SceneBindings {
    /// Makes the bindings from the scene, the constants and the light BVH. If `energy_compensated` is true in
    /// `specialisation`, it also computes the table of specular albedos, from which shaders find the energy that the
    /// specular lobe loses. Otherwise the table is empty.
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

    /// Makes the compute pass from the shader with the name `name` (the file `name.comp`), for this scene and with the
    /// constants of `specialisation`.
    ///
    /// # Errors
    /// The shader's interface cannot be bound by name.
    pub fn pass(&self, name: &str, specialisation: &Specialisation) -> Result<ComputePass> {
        let constants = specialisation.words();
        self.scene.pass(&self.device, name, &constants)
    }

    /// Moves the scene to its pose (the positions of all objects and lights) at the time `now`. Passes that reuse samples of
    /// the previous frame also see the scene in its pose at the time `before`. Both times are in seconds.
    ///
    /// # Errors
    /// At one of the times an instance is too far away to be rendered, or the device fails.
    pub fn set_pose(&self, now: f64, before: f64) -> Result<()> {
        self.scene.set_pose(now, before)?;
        self.light_bvh.follow(&self.scene)
    }

    /// The name and the size in bytes of the light BVH's buffer, for reports of memory; `None` if no candidates are drawn
    /// from a light BVH (a tree of lights).
    pub fn light_bvh_memory(&self) -> Option<(&'static str, u64)> {
        self.light_bvh.memory()
    }
}
