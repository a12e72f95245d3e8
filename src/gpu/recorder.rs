//! Objects that record and run commands, kept by the device for reuse; and commands that run.

use ash::vk;
use std::time::Instant;

/// The number of timestamp pairs of one command buffer; further regions are not timed.
pub(super) const MAX_TIMED_REGIONS: u32 = 256;

/// A command buffer and the objects that are needed to run it. The device keeps idle ones for reuse: the validation layers
/// (1.3.239) forget a destroyed command buffer late, in a separate thread and without a lock; by then a new one may have its
/// address, and the heap is damaged.
#[derive(Clone, Copy)]
pub(super) struct Recorder {
    pub(super) raw: vk::CommandBuffer,
    pool: vk::CommandPool,
    pub(super) fence: vk::Fence,
    /// Two timestamps per region; null if the device has no timestamps.
    pub(super) queries: vk::QueryPool,
}

impl Recorder {
    /// Makes a recorder for a queue family, with or without timestamps.
    pub(super) fn new(
        raw: &ash::Device,
        queue_family: u32,
        timestamps: bool,
    ) -> Result<Self, vk::Result> {
        let mut recorder = Self {
            raw: vk::CommandBuffer::null(),
            pool: vk::CommandPool::null(),
            fence: vk::Fence::null(),
            queries: vk::QueryPool::null(),
        };
        let made = recorder.make(raw, queue_family, timestamps);
        if made.is_err() {
            // SAFETY: nothing has been submitted.
            unsafe { recorder.destroy(raw) };
        }
        made.map(|()| recorder)
    }

    fn make(
        &mut self,
        raw: &ash::Device,
        queue_family: u32,
        timestamps: bool,
    ) -> Result<(), vk::Result> {
        // SAFETY: create-infos live through their calls.
        unsafe {
            let info = vk::CommandPoolCreateInfo::default()
                .queue_family_index(queue_family)
                .flags(vk::CommandPoolCreateFlags::TRANSIENT);
            self.pool = raw.create_command_pool(&info, None)?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(self.pool)
                .command_buffer_count(1);
            self.raw = raw.allocate_command_buffers(&info)?[0];
            self.fence = raw.create_fence(&vk::FenceCreateInfo::default(), None)?;
            if timestamps {
                let info = vk::QueryPoolCreateInfo::default()
                    .query_type(vk::QueryType::TIMESTAMP)
                    .query_count(2 * MAX_TIMED_REGIONS);
                self.queries = raw.create_query_pool(&info, None)?;
            }
        }
        Ok(())
    }

    /// Begins to record, from the start.
    pub(super) fn begin(&self, raw: &ash::Device) -> Result<(), vk::Result> {
        // SAFETY: an idle recorder's commands are not running.
        unsafe {
            raw.reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())?;
            raw.reset_fences(&[self.fence])?;
            let info = vk::CommandBufferBeginInfo::default()
                .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            raw.begin_command_buffer(self.raw, &info)?;
            if self.queries != vk::QueryPool::null() {
                raw.cmd_reset_query_pool(self.raw, self.queries, 0, 2 * MAX_TIMED_REGIONS);
            }
        }
        Ok(())
    }

    /// Destroys the recorder; null handles are ignored.
    ///
    /// # Safety
    /// Called once, while its commands are not running, or the device is lost.
    pub(super) unsafe fn destroy(&self, raw: &ash::Device) {
        // SAFETY: as the caller promises.
        unsafe {
            raw.destroy_query_pool(self.queries, None);
            raw.destroy_fence(self.fence, None);
            raw.destroy_command_pool(self.pool, None);
        }
    }
}

/// The time that a pass took on the device.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PassTime {
    /// The pass.
    pub name: String,
    /// The time between its first and last timestamp, in milliseconds.
    pub milliseconds: f64,
    /// The time from the first timestamp of its submission to the first one of the pass, in milliseconds.
    #[serde(skip)]
    pub start: f64,
    /// True if the pass ran for the first time, in which some drivers compile it.
    #[serde(skip)]
    pub first_run: bool,
}

impl PassTime {
    /// One time per pass, in the order of their first runs.
    pub fn by_name(times: Vec<Self>) -> Vec<Self> {
        let mut by_name = Vec::new();
        Self::add(&mut by_name, times);
        by_name
    }

    /// Adds `times` to `total`, in which passes with the same name have one entry; an entry is a first run if one of its runs
    /// is.
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

/// Commands that were submitted and not yet waited for. The caller keeps the resources that they use alive.
pub(super) struct Submission {
    pub(super) recorder: Recorder,
    /// Descriptor pools of the commands, destroyed after the wait.
    pub(super) descriptor_pools: Vec<vk::DescriptorPool>,
    /// The name of each timed region, and true if it is the first run of a pass.
    pub(super) regions: Vec<(String, bool)>,
    pub(super) started: Instant,
}

impl Submission {
    /// Destroys the objects of the submission.
    ///
    /// # Safety
    /// The commands do not run, or the device is lost.
    pub(super) unsafe fn destroy(self, raw: &ash::Device) {
        // SAFETY: as the caller promises.
        unsafe {
            for pool in self.descriptor_pools {
                raw.destroy_descriptor_pool(pool, None);
            }
            self.recorder.destroy(raw);
        }
    }

    /// The times of the regions after the wait, empty without timestamps; `period` is the length of a tick in nanoseconds.
    pub(super) fn times(
        &self,
        raw: &ash::Device,
        period: f64,
    ) -> Result<Vec<PassTime>, vk::Result> {
        let timed = self.regions.len().min(MAX_TIMED_REGIONS as usize);
        if self.recorder.queries == vk::QueryPool::null() || timed == 0 {
            return Ok(Vec::new());
        }
        let mut ticks = vec![0_u64; 2 * timed];
        // SAFETY: the queries up to here were written by the commands just waited for.
        unsafe {
            raw.get_query_pool_results(
                self.recorder.queries,
                0,
                &mut ticks,
                vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT,
            )?;
        }
        let milliseconds = |from: u64, to: u64| to.wrapping_sub(from) as f64 * period * 1e-6;
        let pairs = self.regions.iter().zip(ticks.chunks_exact(2));
        Ok(pairs
            .map(|((name, first_run), pair)| PassTime {
                name: name.clone(),
                start: milliseconds(ticks[0], pair[0]),
                milliseconds: milliseconds(pair[0], pair[1]),
                first_run: *first_run,
            })
            .collect())
    }
}
