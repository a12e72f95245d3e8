//! A tracer of lists of rays on the device. The light BVH (a tree of lights) uses it to limit boxes of influence; outside
//! its box, a light is not drawn from the tree. Tests and benchmarks use it to compare methods of tracing rays.

use super::counters::Counters;
use crate::Result;
use crate::device_scene::GpuScene;
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage, in_rows};
use crate::shader_interface::{RAYS_PER_GROUP, RayBatch, RayHit, RayQuery};
use std::sync::Arc;

crate::bindings! {
    /// Bindings of the pass `trace_rays`, which traces each ray in the buffer `rays` and writes its hit, or a ray
    /// parameter of −1 if it hits nothing, to the buffer `answers`.
    pub struct TraceRays {
        [offers scene: GpuScene]
        read rays,
        write answers,
        write counters,
    }
}

/// A list of rays on the device, the pass that traces them, and the buffer of their hits. The light BVH (a tree of lights)
/// limits its boxes of influence to the surfaces that rays from lights hit. Tests compare the hits with those of other
/// methods of tracing rays. The same list can be traced repeatedly, for measurements of time.
pub struct RayTracer {
    scene: Arc<GpuScene>,
    pass: ComputePass,
    counters: Counters,
    rays: Buffer,
    answers: Buffer,
    device: Arc<Device>,
    count: usize,
}

impl RayTracer {
    /// Uploads `rays`, and makes the pass that finds their hits in `scene`. Origins and directions of rays are in scene
    /// units. Origins are relative to `scene.units.origin`, the point of the world that has the coordinates (0, 0, 0) on the
    /// device.
    ///
    /// # Errors
    /// A buffer exceeds a limit or the free memory of the device, or the shader's interface cannot be bound by name.
    pub fn new(device: &Arc<Device>, scene: Arc<GpuScene>, rays: &[RayQuery]) -> Result<Self> {
        // The direction is scaled like the origin, so that the ray parameter of a hit stays the same.
        let unit = scene.units.length as f32;
        let rays: Vec<RayQuery> = (rays.iter())
            .map(|ray| RayQuery {
                origin: ray.origin / unit,
                direction: ray.direction / unit,
                ..*ray
            })
            .collect();
        let specialisation = scene.specialisation(false);
        let pass = scene.pass(device, "trace_rays", &specialisation.words())?;
        let size = (rays.len() * size_of::<RayHit>()) as u64;
        Ok(Self {
            scene,
            pass,
            counters: Counters::new(device, false)?,
            rays: Buffer::from_slice(device, "rays", &rays, Usage::default())?,
            answers: Buffer::new(device, "answers", size, Usage::default())?,
            device: device.clone(),
            count: rays.len(),
        })
    }

    /// Traces each ray of the list once, waits for the device, and returns the time that the pass took. [`Self::answers`]
    /// then returns the hits.
    pub fn run(&self) -> Result<Vec<PassTime>> {
        let bindings = TraceRays {
            scene: &self.scene,
            rays: &self.rays,
            answers: &self.answers,
            counters: &self.counters.buffer,
        };
        let batch = RayBatch {
            count: self.count as u32,
            interleave: self.device.info.interleave(),
        };
        let groups = (self.count as u32).div_ceil(RAYS_PER_GROUP);
        let mut recording = Recording::new(&self.device)?;
        recording.pass(&self.pass, &bindings, &batch, in_rows(groups))?;
        recording.finish()
    }

    /// Reads the hits of the last call of [`Self::run`], one per ray, in the order of the rays. The ray parameter of a hit
    /// is its distance from the ray's origin, divided by the length of the ray's direction.
    pub fn answers(&self) -> Result<Vec<RayHit>> {
        self.answers.read(self.count)
    }
}
