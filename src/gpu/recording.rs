//! A sequence of passes that is recorded, submitted and waited for.

use super::buffer::Buffer;
use super::device::Device;
use super::pass::{Bindings, ComputePass, Resource};
use super::reflection::Kind;
use crate::{Error, Result};
use ash::vk;
use std::ffi::CString;
use std::marker::PhantomData;
use std::sync::Arc;

/// Passes a recording can time.
const TIMED_PASSES: u32 = 256;

/// How long a pass took on the device.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PassTime {
    /// The pass.
    pub name: String,
    /// Milliseconds between its first and last timestamp.
    pub milliseconds: f64,
    /// Whether the pass ran for the first time, in which some drivers compile it.
    #[serde(skip)]
    pub first_run: bool,
}

impl PassTime {
    /// Adds times to those of passes of the same name; one that holds a first run is one.
    pub fn add(total: &mut Vec<Self>, times: Vec<Self>) {
        for time in times {
            match total.iter_mut().find(|t| t.name == time.name) {
                Some(same) => {
                    same.milliseconds += time.milliseconds;
                    same.first_run |= time.first_run;
                }
                None => total.push(time),
            }
        }
    }
}

/// Passes in order, with one global memory barrier before each. Each is a debug label and a pair
/// of timestamps. The lifetime keeps every resource alive until [`Recording::finish`] has waited.
pub struct Recording<'a> {
    device: Arc<Device>,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    queries: vk::QueryPool,
    descriptors: Vec<vk::DescriptorPool>,
    /// The passes' names, and whether each runs for the first time.
    passes: Vec<(String, bool)>,
    resources: PhantomData<&'a ()>,
}

impl<'a> Recording<'a> {
    /// Begins a recording.
    ///
    /// # Errors
    /// The driver has no memory left.
    pub fn new(device: &Arc<Device>) -> Result<Self> {
        let mut recording = Self {
            device: device.clone(),
            pool: vk::CommandPool::null(),
            commands: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            queries: vk::QueryPool::null(),
            descriptors: Vec::new(),
            passes: Vec::new(),
            resources: PhantomData,
        };
        let fail = |e| device.failure("begin recording", e);
        // SAFETY: create-infos live through their calls; Drop destroys what was made.
        unsafe {
            let raw = &device.raw;
            let info = vk::CommandPoolCreateInfo::default()
                .queue_family_index(device.info.queue_family)
                .flags(vk::CommandPoolCreateFlags::TRANSIENT);
            recording.pool = raw.create_command_pool(&info, None).map_err(fail)?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(recording.pool)
                .command_buffer_count(1);
            recording.commands = raw.allocate_command_buffers(&info).map_err(fail)?[0];
            recording.fence = raw
                .create_fence(&vk::FenceCreateInfo::default(), None)
                .map_err(fail)?;
            let info = vk::CommandBufferBeginInfo::default()
                .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            raw.begin_command_buffer(recording.commands, &info)
                .map_err(fail)?;
            if device.info.timestamp_period > 0.0 {
                let info = vk::QueryPoolCreateInfo::default()
                    .query_type(vk::QueryType::TIMESTAMP)
                    .query_count(2 * TIMED_PASSES);
                recording.queries = raw.create_query_pool(&info, None).map_err(fail)?;
                raw.cmd_reset_query_pool(
                    recording.commands,
                    recording.queries,
                    0,
                    2 * TIMED_PASSES,
                );
            }
        }
        Ok(recording)
    }

    /// Records one dispatch of `groups` workgroups.
    ///
    /// # Errors
    /// Bindings or push constants that the shader does not have, or a full pool.
    pub fn pass<P: bytemuck::Pod>(
        &mut self,
        pass: &'a ComputePass,
        bindings: &dyn Bindings<'a>,
        push: &P,
        groups: [u32; 3],
    ) -> Result<()> {
        let resources = pass.resolve(bindings)?;
        if size_of::<P>() as u32 != pass.interface.push_constant_size {
            return Err(Error::failed(format!(
                "pass {} takes {} bytes of push constants, {} were given",
                pass.name(),
                pass.interface.push_constant_size,
                size_of::<P>()
            )));
        }
        let set = self.descriptor_set(pass, &resources)?;
        self.barrier();
        self.begin(pass.name());
        if let Some((_, first_run)) = self.passes.last_mut() {
            *first_run = pass.is_first_run();
        }
        let raw = &self.device.raw;
        // SAFETY: pipeline, layout and set belong together; the resources live as long as 'a.
        unsafe {
            raw.cmd_bind_pipeline(self.commands, vk::PipelineBindPoint::COMPUTE, pass.pipeline);
            raw.cmd_bind_descriptor_sets(
                self.commands,
                vk::PipelineBindPoint::COMPUTE,
                pass.layout,
                0,
                &[set],
                &[],
            );
            if size_of::<P>() > 0 {
                raw.cmd_push_constants(
                    self.commands,
                    pass.layout,
                    vk::ShaderStageFlags::COMPUTE,
                    0,
                    bytemuck::bytes_of(push),
                );
            }
            raw.cmd_dispatch(self.commands, groups[0], groups[1], groups[2]);
        }
        self.end();
        Ok(())
    }

    /// Fills a buffer with zeros.
    pub fn clear(&mut self, buffer: &'a Buffer) {
        self.barrier();
        // SAFETY: the buffer allows transfers and lives as long as 'a.
        unsafe {
            self.device
                .raw
                .cmd_fill_buffer(self.commands, buffer.raw, 0, vk::WHOLE_SIZE, 0);
        }
    }

    /// Submits everything, waits, and returns each pass's time (empty without timestamps).
    ///
    /// # Errors
    /// The device is lost or out of memory.
    pub fn finish(self) -> Result<Vec<PassTime>> {
        let device = self.device.clone();
        let fail = |e| device.failure("run the recorded passes", e);
        // The host reads and frees what the passes wrote.
        self.barrier();
        // SAFETY: the recording is complete; the wait ends before `self` and 'a end.
        unsafe {
            let raw = &device.raw;
            raw.end_command_buffer(self.commands).map_err(fail)?;
            let commands = [self.commands];
            let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
            {
                let _lock = device.queue_lock.lock();
                raw.queue_submit(device.queue, &submit, self.fence)
                    .map_err(fail)?;
            }
            raw.wait_for_fences(&[self.fence], true, u64::MAX)
                .map_err(fail)?;
        }
        self.times().map_err(fail)
    }

    fn times(&self) -> std::result::Result<Vec<PassTime>, vk::Result> {
        let timed = self.passes.len().min(TIMED_PASSES as usize);
        if self.queries == vk::QueryPool::null() || timed == 0 {
            return Ok(Vec::new());
        }
        let mut ticks = vec![0_u64; 2 * timed];
        // SAFETY: the queries up to here were written by the commands just waited for.
        unsafe {
            self.device.raw.get_query_pool_results(
                self.queries,
                0,
                &mut ticks,
                vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT,
            )?;
        }
        let period = f64::from(self.device.info.timestamp_period);
        Ok(self
            .passes
            .iter()
            .zip(ticks.chunks_exact(2))
            .map(|((name, first_run), pair)| PassTime {
                name: name.clone(),
                milliseconds: pair[1].wrapping_sub(pair[0]) as f64 * period * 1e-6,
                first_run: *first_run,
            })
            .collect())
    }

    /// Everything before is finished and visible to everything after.
    pub(super) fn barrier(&self) {
        let all = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
        let barrier = [vk::MemoryBarrier::default()
            .src_access_mask(all)
            .dst_access_mask(all)];
        let stages = vk::PipelineStageFlags::ALL_COMMANDS;
        // SAFETY: plain command on a buffer that is being recorded.
        unsafe {
            self.device.raw.cmd_pipeline_barrier(
                self.commands,
                stages,
                stages | vk::PipelineStageFlags::HOST,
                vk::DependencyFlags::empty(),
                &barrier,
                &[],
                &[],
            );
        }
    }

    /// Opens a labelled, timed region.
    pub(super) fn begin(&mut self, name: &str) {
        if let (Some(debug), Ok(label)) = (&self.device.debug, CString::new(name)) {
            let label = vk::DebugUtilsLabelEXT::default().label_name(&label);
            // SAFETY: plain command; closed in `end`.
            unsafe { debug.cmd_begin_debug_utils_label(self.commands, &label) };
        }
        self.timestamp(0);
        self.passes.push((name.to_owned(), false));
    }

    /// Closes the region that `begin` opened.
    pub(super) fn end(&mut self) {
        let last = self.passes.pop();
        self.timestamp(1);
        self.passes.extend(last);
        if let Some(debug) = &self.device.debug {
            // SAFETY: `begin` opened a label.
            unsafe { debug.cmd_end_debug_utils_label(self.commands) };
        }
    }

    fn timestamp(&self, which: u32) {
        let index = self.passes.len() as u32;
        if self.queries != vk::QueryPool::null() && index < TIMED_PASSES {
            // SAFETY: each query is written once after the reset in `new`.
            unsafe {
                self.device.raw.cmd_write_timestamp(
                    self.commands,
                    vk::PipelineStageFlags::BOTTOM_OF_PIPE,
                    self.queries,
                    2 * index + which,
                );
            }
        }
    }

    pub(super) fn commands(&self) -> vk::CommandBuffer {
        self.commands
    }

    fn descriptor_set(
        &mut self,
        pass: &ComputePass,
        resources: &[Resource<'a>],
    ) -> Result<vk::DescriptorSet> {
        let fail = |e| {
            self.device
                .failure(&format!("bind pass {}", pass.name()), e)
        };
        let size = |ty| vk::DescriptorPoolSize {
            ty,
            descriptor_count: resources.len().max(1) as u32,
        };
        let mut sizes = vec![
            size(vk::DescriptorType::STORAGE_BUFFER),
            size(vk::DescriptorType::UNIFORM_BUFFER),
            size(vk::DescriptorType::UNIFORM_TEXEL_BUFFER),
        ];
        if self.device.features.ray_query {
            sizes.push(size(vk::DescriptorType::ACCELERATION_STRUCTURE_KHR));
        }
        let raw = &self.device.raw;
        let info = vk::DescriptorPoolCreateInfo::default()
            .max_sets(1)
            .pool_sizes(&sizes);
        // SAFETY: create-infos live through their calls; the pool is destroyed by Drop.
        let set = unsafe {
            let pool = raw.create_descriptor_pool(&info, None).map_err(fail)?;
            self.descriptors.push(pool);
            let layouts = [pass.set_layout];
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(pool)
                .set_layouts(&layouts);
            raw.allocate_descriptor_sets(&info).map_err(fail)?[0]
        };
        let whole = |buffer: &Buffer| {
            [vk::DescriptorBufferInfo {
                buffer: buffer.raw,
                offset: 0,
                range: vk::WHOLE_SIZE,
            }]
        };
        for (binding, resource) in pass.interface.bindings.iter().zip(resources) {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(binding.number);
            let update = |write| {
                // SAFETY: set, buffers and structures are alive; kinds were checked by `resolve`.
                unsafe { raw.update_descriptor_sets(&[write], &[]) }
            };
            match (resource, binding.kind) {
                (Resource::AccelerationStructure(structure), _) => {
                    let handles = [structure.raw];
                    let mut chain = vk::WriteDescriptorSetAccelerationStructureKHR::default()
                        .acceleration_structures(&handles);
                    let mut write = write
                        .descriptor_type(vk::DescriptorType::ACCELERATION_STRUCTURE_KHR)
                        .push_next(&mut chain);
                    write.descriptor_count = 1;
                    update(write);
                }
                (Resource::Uniform(buffer), _) => update(
                    write
                        .descriptor_type(vk::DescriptorType::UNIFORM_BUFFER)
                        .buffer_info(&whole(buffer)),
                ),
                (Resource::Texels(buffer), _) => update(
                    write
                        .descriptor_type(vk::DescriptorType::UNIFORM_TEXEL_BUFFER)
                        .texel_buffer_view(&[buffer.view]),
                ),
                (Resource::Read(buffer) | Resource::Write(buffer), Kind::Storage { .. }) => update(
                    write
                        .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                        .buffer_info(&whole(buffer)),
                ),
                _ => {}
            }
        }
        Ok(set)
    }
}

impl Drop for Recording<'_> {
    fn drop(&mut self) {
        // SAFETY: either never submitted, or waited for, or the device is lost.
        unsafe {
            let raw = &self.device.raw;
            for pool in self.descriptors.drain(..) {
                raw.destroy_descriptor_pool(pool, None);
            }
            raw.destroy_query_pool(self.queries, None);
            raw.destroy_fence(self.fence, None);
            raw.destroy_command_pool(self.pool, None);
        }
    }
}

/// Copies `size` bytes between buffers, at once.
pub(super) fn copy(
    device: &Arc<Device>,
    (from, from_offset): (&Buffer, u64),
    (to, to_offset): (&Buffer, u64),
    size: u64,
) -> Result<()> {
    let recording = Recording::new(device)?;
    let region = [vk::BufferCopy {
        src_offset: from_offset,
        dst_offset: to_offset,
        size,
    }];
    recording.barrier();
    // SAFETY: both buffers allow transfers, the callers checked the ranges, and `finish` waits.
    unsafe {
        device
            .raw
            .cmd_copy_buffer(recording.commands, from.raw, to.raw, &region);
    }
    recording.finish().map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{DeviceInfo, Features, Instance, Usage};

    /// Synchronization validation is on, and what it says is heard.
    #[test]
    fn a_planted_hazard_is_caught() {
        let instance = Instance::new(true).unwrap();
        // The tests' device, as everywhere: a machine may have others that nobody tests.
        let info = match std::env::var("HEADWATER_DEVICE") {
            Ok(name) => instance.choose(Some(&name)).unwrap().0,
            Err(_) => {
                let devices = instance.devices().unwrap();
                devices.into_iter().find(DeviceInfo::is_cpu).unwrap()
            }
        };
        let device = Device::open(&instance, info, Features::default()).unwrap();
        let buffer = Buffer::new(&device, "planted", 1024, Usage::default()).unwrap();
        let mut recording = Recording::new(&device).unwrap();
        recording.clear(&buffer);
        recording.clear(&buffer);
        assert_eq!(device.validation_messages(), Vec::<String>::new());
        // SAFETY: as in `clear`; the barrier that it lacks is the point.
        unsafe {
            device
                .raw
                .cmd_fill_buffer(recording.commands, buffer.raw, 0, vk::WHOLE_SIZE, 1);
        }
        recording.finish().unwrap();
        let messages = device.validation_messages().join("\n");
        assert!(
            messages.contains("SYNC-HAZARD-WRITE-AFTER-WRITE"),
            "{messages}"
        );
    }
}
