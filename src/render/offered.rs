//! What every pass is offered: the scene on the device, and the tables that materials look up.

use super::energy;
use super::settings::{Energy, Settings};
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Resource, Usage};
use crate::tracing::{GpuScene, shaders};
use std::sync::Arc;

/// Specialisation constant: whether energy is compensated.
const ENERGY_COMPENSATED: u32 = 1;

/// The scene's resources and the tables that materials look up.
pub struct Offered {
    /// The scene.
    pub scene: Arc<GpuScene>,
    specular_albedo: Buffer,
    compensated: bool,
    device: Arc<Device>,
}

impl Offered {
    /// Makes the tables that `settings` need.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(device: &Arc<Device>, scene: Arc<GpuScene>, settings: &Settings) -> Result<Self> {
        let compensated = settings.energy == Energy::Compensated;
        let table = if compensated {
            energy::albedo_table()
        } else {
            Vec::new()
        };
        let usage = Usage::default();
        Ok(Self {
            specular_albedo: Buffer::from_slice(device, "specular_albedo", &table, usage)?,
            compensated,
            scene,
            device: device.clone(),
        })
    }

    /// Makes a pass for this scene; `constants` are specialisation constants beside its own.
    ///
    /// # Errors
    /// A shader that the device refuses.
    pub fn pass(&self, name: &str, constants: &[(u32, u32)]) -> Result<ComputePass> {
        let mut all = vec![(ENERGY_COMPENSATED, u32::from(self.compensated))];
        all.extend_from_slice(constants);
        shaders::tracing_pass(&self.device, name, &self.scene, &all)
    }

    /// What shaders may name.
    pub fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let mut resources = self.scene.resources();
        resources.push(("specular_albedo", Resource::Read(&self.specular_albedo)));
        resources
    }
}
