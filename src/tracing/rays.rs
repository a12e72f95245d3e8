//! Tracing rays from a list: for tests and benchmarks of the tracers.

use super::{GpuScene, shaders};
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage};
use crate::layouts::{RAYS_PER_GROUP, RayAnswer, RayBatch, RayQuery};
use std::sync::Arc;

crate::bindings! {
    /// What the pass `trace_rays` is bound to.
    pub struct TraceRays {
        [offers scene: GpuScene]
        read rays,
        write answers,
    }
}

/// A list of rays on the device, ready to be traced again and again.
pub struct RayTracer<'a> {
    scene: &'a GpuScene,
    pass: ComputePass,
    rays: Buffer,
    answers: Buffer,
    device: Arc<Device>,
    count: usize,
}

impl<'a> RayTracer<'a> {
    /// Uploads the rays.
    ///
    /// # Errors
    /// The device has no memory left or refuses the shader.
    pub fn new(device: &Arc<Device>, scene: &'a GpuScene, rays: &[RayQuery]) -> Result<Self> {
        let pass = shaders::tracing_pass(device, "trace_rays", scene, &[])?;
        let size = (rays.len() * size_of::<RayAnswer>()) as u64;
        Ok(Self {
            scene,
            pass,
            rays: Buffer::from_slice(device, "rays", rays, Usage::default())?,
            answers: Buffer::new(device, "answers", size, Usage::default())?,
            device: device.clone(),
            count: rays.len(),
        })
    }

    /// Traces every ray once.
    ///
    /// # Errors
    /// The device fails.
    pub fn run(&self) -> Result<Vec<PassTime>> {
        let bindings = TraceRays {
            scene: self.scene,
            rays: &self.rays,
            answers: &self.answers,
        };
        let batch = RayBatch {
            count: self.count as u32,
            interleave: self.device.info.interleave(),
        };
        let groups = (self.count as u32).div_ceil(RAYS_PER_GROUP);
        // One dimension holds at least 65,535 groups everywhere; more go into rows.
        let rows = groups.div_ceil(32768).max(1);
        let mut recording = Recording::new(&self.device)?;
        recording.pass(
            &self.pass,
            &bindings,
            &batch,
            [groups.div_ceil(rows).max(1), rows, 1],
        )?;
        recording.finish()
    }

    /// What the last run found, in the order of the rays.
    ///
    /// # Errors
    /// The device fails.
    pub fn answers(&self) -> Result<Vec<RayAnswer>> {
        self.answers.read(self.count)
    }
}
