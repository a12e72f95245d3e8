//! A command buffer that is recorded, submitted once, and waited for. Copies, builds of acceleration structures, and passes
//! are run in this way.

use super::device::Device;
use super::recorder::{MAX_TIMED_REGIONS, PassTime, Recorder, Submission};
use crate::Result;
use ash::vk;
use std::ffi::CString;
use std::sync::Arc;
use std::time::Instant;

/// One command buffer with the objects that are needed to run it once: fence, timestamps and descriptor pools. Until the
/// submission, the caller keeps the resources that the commands use alive. From then on, dropping such a resource waits for
/// the commands ([`Device::wait_before_drop`]).
pub(super) struct Commands {
    pub(super) device: Arc<Device>,
    pub(super) recorder: Recorder,
    /// Index of the frame that the submission ends, and the image that shows this frame, for capture tools
    /// (`VK_EXT_frame_boundary`). `None` if the submission ends no frame.
    frame_end: Option<(u32, vk::Image)>,
    /// True after [`Commands::submit`]. The recorder (the command buffer with its fence and timestamps) then belongs to a
    /// [`Submission`], so dropping this value must not give the recorder back for reuse.
    is_submitted: bool,
    /// The timed regions recorded so far, in order; a region is usually one pass. Each entry is a pair: the name of the
    /// region, and true if the region's pass runs for the first time. Region `i` has the timestamp queries `2 i` (start) and
    /// `2 i + 1` (end).
    regions: Vec<(String, bool)>,
}

impl Commands {
    /// Begins to record commands. The recorder (a command buffer with fence and timestamps) is an idle one of the device, or
    /// a new one if none is idle.
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
            recorder,
            frame_end: None,
            is_submitted: false,
            regions: Vec::new(),
        };
        commands.recorder.begin(&device.raw).map_err(fail)?;
        Ok(commands)
    }

    /// Vulkan handle of the command buffer, to which other modules record commands.
    pub(super) const fn raw(&self) -> vk::CommandBuffer {
        self.recorder.raw
    }

    /// Records a global memory barrier. All commands recorded before it finish before later commands begin, and their writes
    /// become visible to these commands and to the host.
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

    /// Records a command that fills the whole buffer with zeros. The caller keeps the buffer alive until the commands have
    /// run.
    pub(super) fn clear(&self, buffer: vk::Buffer) {
        // SAFETY: every buffer allows transfers, and this one is alive until the commands have run.
        unsafe {
            let raw = &self.device.raw;
            raw.cmd_fill_buffer(self.raw(), buffer, 0, vk::WHOLE_SIZE, 0);
        }
    }

    /// Opens a timed region, usually one pass: records the debug label `name` and a start timestamp. [`Commands::end`]
    /// closes it; regions must not nest. `first_run` is true if the region's pass runs for the first time, and is copied to
    /// [`PassTime::first_run`].
    pub(super) fn begin(&mut self, name: &str, first_run: bool) {
        if let (Some(debug), Ok(label)) = (&self.device.debug, CString::new(name)) {
            let label = vk::DebugUtilsLabelEXT::default().label_name(&label);
            // SAFETY: plain command; closed in `end`.
            unsafe { debug.cmd_begin_debug_utils_label(self.raw(), &label) };
        }
        self.timestamp(2 * self.regions.len() as u32);
        self.regions.push((name.to_owned(), first_run));
    }

    /// Closes the region that `begin` opened: writes the end timestamp and ends the debug label.
    pub(super) fn end(&mut self) {
        self.timestamp(2 * self.regions.len() as u32 - 1);
        if let Some(debug) = &self.device.debug {
            // SAFETY: `begin` opened a label.
            unsafe { debug.cmd_end_debug_utils_label(self.raw()) };
        }
    }

    /// Marks the submission as the end of the frame with the index `index`; the image `picture` shows this frame. Capture
    /// tools find frames by such marks. The mark has no effect if [`Device::ends_frames`] is false.
    pub(super) fn ends_frame(&mut self, index: u32, picture: vk::Image) {
        self.frame_end = Some((index, picture));
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

    /// Submits all commands, waits for them, and returns the time that each timed region (usually one pass) took on the
    /// device, in the order of recording. Regions after the first [`MAX_TIMED_REGIONS`] have no times. The list is empty on
    /// a device without timestamps.
    ///
    /// # Errors
    /// The device is lost or out of memory.
    pub(super) fn finish(self) -> Result<Vec<PassTime>> {
        let device = self.device.clone();
        Ok(device.wait_for(self.submit()?)?.0)
    }

    /// Submits all commands without waiting for them. The caller passes the returned [`Submission`] to [`Device::wait_for`],
    /// which waits for the commands and returns the times of their passes.
    ///
    /// # Errors
    /// The device is lost or out of memory.
    pub(super) fn submit(mut self) -> Result<Submission> {
        let device = self.device.clone();
        let fail = |e| device.failure("run the recorded passes", e);
        // The host reads and frees what the commands wrote.
        self.barrier();
        // SAFETY: the recording is complete; the recorder and the resources live until the wait ends.
        let started = unsafe {
            let raw = &device.raw;
            raw.end_command_buffer(self.raw()).map_err(fail)?;
            let commands = [self.raw()];
            let (frame, image) = self.frame_end.unwrap_or_default();
            let images = [image];
            let mut end = vk::FrameBoundaryEXT::default()
                .flags(vk::FrameBoundaryFlagsEXT::FRAME_END)
                .frame_id(frame.into())
                .images(&images);
            let mut submit = vk::SubmitInfo::default().command_buffers(&commands);
            if self.frame_end.is_some() && device.ends_frames {
                submit = submit.push_next(&mut end);
            }
            let _lock = device.queue_lock.lock();
            let started = Instant::now();
            raw.queue_submit(device.queue, &[submit], self.recorder.fence)
                .map_err(fail)?;
            started
        };
        self.is_submitted = true;
        Ok(Submission {
            recorder: std::mem::take(&mut self.recorder),
            regions: std::mem::take(&mut self.regions),
            started,
        })
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        if !self.is_submitted {
            self.device.keep(std::mem::take(&mut self.recorder));
        }
    }
}
