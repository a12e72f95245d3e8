//! Recorders and submissions. A recorder is a command buffer with the objects that are needed to run it; the device keeps it
//! for reuse. A submission is a recorder whose commands may still run.

use ash::vk;
use std::time::Instant;

/// The maximum number of timed regions, usually passes, in one command buffer; each has two timestamps. The commands of
/// further regions run, but their time is not measured.
pub(super) const MAX_TIMED_REGIONS: u32 = 256;

/// A command buffer and the objects that are needed to run it. The device keeps idle recorders for reuse instead of
/// destroying them. This avoids a fault of the validation layers (1.3.239), which forget a destroyed command buffer late, in
/// a separate thread and without a lock. If a new command buffer has received the same address by then, they damage the
/// heap.
#[derive(Default)]
pub(super) struct Recorder {
    pub(super) raw: vk::CommandBuffer,
    pool: vk::CommandPool,
    pub(super) fence: vk::Fence,
    /// Pool of timestamp queries, two per region for [`MAX_TIMED_REGIONS`] regions; null if the device has no timestamps.
    pub(super) queries: vk::QueryPool,
    /// Descriptor pools from which the commands get their descriptor sets. A new pool is made when all are
    /// full, and later recordings reuse all pools.
    pub(super) descriptor_pools: Vec<vk::DescriptorPool>,
}

impl Recorder {
    /// Makes a recorder for the queue family with the index `queue_family`. It gets a pool of timestamp queries, with which
    /// passes are timed, if `timestamps` is true.
    pub(super) fn new(
        raw: &ash::Device,
        queue_family: u32,
        timestamps: bool,
    ) -> Result<Self, vk::Result> {
        let mut recorder = Self::default();
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

    /// Resets the command buffer, the fence, the queries and the descriptor pools, and begins to record new
    /// commands. The commands that were submitted with this recorder before must have finished.
    pub(super) fn begin(&self, raw: &ash::Device) -> Result<(), vk::Result> {
        // SAFETY: an idle recorder's commands are not running.
        unsafe {
            raw.reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())?;
            raw.reset_fences(&[self.fence])?;
            for pool in &self.descriptor_pools {
                raw.reset_descriptor_pool(*pool, vk::DescriptorPoolResetFlags::empty())?;
            }
            let info = vk::CommandBufferBeginInfo::default()
                .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            raw.begin_command_buffer(self.raw, &info)?;
            if self.queries != vk::QueryPool::null() {
                raw.cmd_reset_query_pool(self.raw, self.queries, 0, 2 * MAX_TIMED_REGIONS);
            }
        }
        Ok(())
    }

    /// Destroys the objects of the recorder; null handles are ignored.
    ///
    /// # Safety
    /// Must be called once, when the recorder's commands are not running or the device is lost.
    pub(super) unsafe fn destroy(&self, raw: &ash::Device) {
        // SAFETY: as the caller promises.
        unsafe {
            for pool in &self.descriptor_pools {
                raw.destroy_descriptor_pool(*pool, None);
            }
            raw.destroy_query_pool(self.queries, None);
            raw.destroy_fence(self.fence, None);
            raw.destroy_command_pool(self.pool, None);
        }
    }
}

/// Time that one run of a pass took on the device, or the sum of the times of several runs ([`PassTime::by_name`]). Profiles
/// and the reports of renders show these times.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PassTime {
    /// Name of the pass or of another timed region, such as `present`.
    pub name: String,
    /// Time on the device from the start to the end of the run, in milliseconds. If the entry is a sum of several runs, this
    /// is the total time of these runs.
    pub milliseconds: f64,
    /// Time at which the run started, in milliseconds after the first timestamp of its submission (the
    /// commands that were submitted together). It is the position of the run on the timeline of a trace. If
    /// the entry is a sum of several runs, this is the start of the first of them.
    #[serde(skip)]
    pub start: f64,
    /// True if the run is the first one of its pass, or if the entry is a sum that contains the first run. Some drivers
    /// compile a pass only at its first run, so the time can contain the compilation. Reports list such times separately.
    #[serde(skip)]
    pub first_run: bool,
}

impl PassTime {
    /// Sums the times of passes with the same name. Returns one entry per name, in the order in which the names first occur.
    pub fn by_name(times: Vec<Self>) -> Vec<Self> {
        let mut by_name = Vec::new();
        Self::add(&mut by_name, times);
        by_name
    }

    /// Adds `times` to `total`, which has one entry per pass name. The times of passes with the same name are summed, and
    /// passes with a new name are appended. `first_run` of an entry is true if it is true for one of the summed runs.
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

/// Commands that were submitted and may still run, with the objects and data that are needed to wait for
/// them, to reuse the recorder, and to compute the times of passes. The resources that the commands use must
/// stay alive until the commands have finished.
pub(super) struct Submission {
    pub(super) recorder: Recorder,
    /// The timed regions (usually passes) in the order of recording. Each has its name and a flag, which is true if the
    /// region is the first run of a pass. [`Self::times`] copies both to the times that it returns.
    pub(super) regions: Vec<(String, bool)>,
    pub(super) started: Instant,
}

impl Submission {
    /// Destroys the submission's recorder, when the device is lost or closed.
    ///
    /// # Safety
    /// The commands of the submission must have finished, or the device must be lost.
    pub(super) unsafe fn destroy(self, raw: &ash::Device) {
        // SAFETY: as the caller promises.
        unsafe {
            self.recorder.destroy(raw);
        }
    }

    /// The durations of the first [`MAX_TIMED_REGIONS`] timed regions (usually passes), in milliseconds and in the order of
    /// recording; empty on a device without timestamps. The caller must have waited for the commands. `period` is the
    /// length of a timestamp tick in nanoseconds.
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
