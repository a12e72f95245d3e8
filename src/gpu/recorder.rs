//! What records and runs commands, kept by the device and used again and again.

use ash::vk;

/// Timestamp pairs of one command buffer; regions beyond are not timed.
pub(super) const MAX_TIMED_REGIONS: u32 = 256;

/// A command buffer and what it takes to run it. The device keeps those that are idle, to be used again: the validation
/// layers (1.3.239) forget a destroyed command buffer in a thread of their own, late, and without a lock; by then a new one
/// may have its address, and the heap is damaged.
#[derive(Clone, Copy)]
pub(super) struct Recorder {
    pub(super) raw: vk::CommandBuffer,
    pool: vk::CommandPool,
    pub(super) fence: vk::Fence,
    /// Two timestamps a region; null if the device has no timestamps.
    pub(super) queries: vk::QueryPool,
}

impl Recorder {
    /// Makes one for a queue family, with or without timestamps.
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

    /// Destroys it; null handles are ignored.
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
