//! A command buffer that is recorded, submitted once and waited for.

use super::device::Device;
use super::recorder::{MAX_TIMED_REGIONS, Recorder};
use crate::Result;
use ash::vk;
use std::ffi::CString;
use std::sync::Arc;

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
    /// Adds `times` to `total`, where passes of the same name share one entry; it is a first run if one of
    /// them is.
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

/// One command buffer, with what is needed to run it once. The caller keeps the resources that
/// the commands use alive until [`Commands::finish`] returns.
pub(super) struct Commands {
    pub(super) device: Arc<Device>,
    /// Descriptor pools of the recorded commands, destroyed after the wait.
    pub(super) descriptor_pools: Vec<vk::DescriptorPool>,
    recorder: Recorder,
    /// Whether the commands were submitted and not waited for, which is so only if the device is lost.
    is_running: bool,
    /// Name of each region so far, and whether its pass runs for the first time.
    regions: Vec<(String, bool)>,
}

impl Commands {
    /// An empty command buffer, ready to be recorded.
    pub(super) fn new(device: &Arc<Device>) -> Result<Self> {
        let fail = |e| device.failure("begin recording", e);
        let timestamps = device.info.timestamp_period > 0.0;
        let idle = device.idle.lock().ok().and_then(|mut idle| idle.pop());
        let recorder = idle
            .map_or_else(
                || Recorder::new(&device.raw, device.info.queue_family, timestamps),
                Ok,
            )
            .map_err(fail)?;
        let commands = Self {
            device: device.clone(),
            descriptor_pools: Vec::new(),
            recorder,
            is_running: false,
            regions: Vec::new(),
        };
        commands.recorder.begin(&device.raw).map_err(fail)?;
        Ok(commands)
    }

    /// The command buffer.
    pub(super) const fn raw(&self) -> vk::CommandBuffer {
        self.recorder.raw
    }

    /// A global memory barrier: everything before it is finished and visible to everything after.
    pub(super) fn barrier(&self) {
        let all = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
        let barrier = [vk::MemoryBarrier::default()
            .src_access_mask(all)
            .dst_access_mask(all)];
        let stages = vk::PipelineStageFlags::ALL_COMMANDS;
        // SAFETY: plain command on a buffer that is being recorded.
        unsafe {
            self.device.raw.cmd_pipeline_barrier(
                self.raw(),
                stages,
                stages | vk::PipelineStageFlags::HOST,
                vk::DependencyFlags::empty(),
                &barrier,
                &[],
                &[],
            );
        }
    }

    /// Opens a labelled, timed region. Regions do not nest. `first_run` is passed on to its time.
    pub(super) fn begin(&mut self, name: &str, first_run: bool) {
        if let (Some(debug), Ok(label)) = (&self.device.debug, CString::new(name)) {
            let label = vk::DebugUtilsLabelEXT::default().label_name(&label);
            // SAFETY: plain command; closed in `end`.
            unsafe { debug.cmd_begin_debug_utils_label(self.raw(), &label) };
        }
        self.timestamp(2 * self.regions.len() as u32);
        self.regions.push((name.to_owned(), first_run));
    }

    /// Closes the region that `begin` opened.
    pub(super) fn end(&mut self) {
        self.timestamp(2 * self.regions.len() as u32 - 1);
        if let Some(debug) = &self.device.debug {
            // SAFETY: `begin` opened a label.
            unsafe { debug.cmd_end_debug_utils_label(self.raw()) };
        }
    }

    fn timestamp(&self, query: u32) {
        if self.recorder.queries != vk::QueryPool::null() && query < 2 * MAX_TIMED_REGIONS {
            // SAFETY: each query is written once after the reset in `new`.
            unsafe {
                self.device.raw.cmd_write_timestamp(
                    self.raw(),
                    vk::PipelineStageFlags::BOTTOM_OF_PIPE,
                    self.recorder.queries,
                    query,
                );
            }
        }
    }

    /// Submits everything, waits, and returns each region's time (empty without timestamps).
    ///
    /// # Errors
    /// The device is lost or out of memory.
    pub(super) fn finish(mut self) -> Result<Vec<PassTime>> {
        let device = self.device.clone();
        let fail = |e| device.failure("run the recorded passes", e);
        // The host reads and frees what the commands wrote.
        self.barrier();
        // SAFETY: the recording is complete; the wait ends before `self` and the resources do.
        unsafe {
            let raw = &device.raw;
            raw.end_command_buffer(self.raw()).map_err(fail)?;
            let commands = [self.raw()];
            let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
            {
                let _lock = device.queue_lock.lock();
                raw.queue_submit(device.queue, &submit, self.recorder.fence)
                    .map_err(fail)?;
            }
            self.is_running = true;
            raw.wait_for_fences(&[self.recorder.fence], true, u64::MAX)
                .map_err(fail)?;
            self.is_running = false;
        }
        self.times().map_err(fail)
    }

    fn times(&self) -> std::result::Result<Vec<PassTime>, vk::Result> {
        let timed = self.regions.len().min(MAX_TIMED_REGIONS as usize);
        if self.recorder.queries == vk::QueryPool::null() || timed == 0 {
            return Ok(Vec::new());
        }
        let mut ticks = vec![0_u64; 2 * timed];
        // SAFETY: the queries up to here were written by the commands just waited for.
        unsafe {
            self.device.raw.get_query_pool_results(
                self.recorder.queries,
                0,
                &mut ticks,
                vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT,
            )?;
        }
        let period = f64::from(self.device.info.timestamp_period);
        Ok(self
            .regions
            .iter()
            .zip(ticks.chunks_exact(2))
            .map(|((name, first_run), pair)| PassTime {
                name: name.clone(),
                milliseconds: pair[1].wrapping_sub(pair[0]) as f64 * period * 1e-6,
                first_run: *first_run,
            })
            .collect())
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        let raw = &self.device.raw;
        // SAFETY: either never submitted, or waited for, or the device is lost.
        unsafe {
            for pool in self.descriptor_pools.drain(..) {
                raw.destroy_descriptor_pool(pool, None);
            }
        }
        match self.device.idle.lock() {
            Ok(mut idle) if !self.is_running => idle.push(self.recorder),
            // SAFETY: as above, and it is not used again.
            _ => unsafe { self.recorder.destroy(raw) },
        }
    }
}
