//! Waiting for commands that were submitted, and reuse of the recorders (command buffers with fence and timestamps) in which
//! they were recorded.

use super::device::Device;
use super::recorder::{PassTime, Recorder, Submission};
use crate::Result;
use ash::vk;
use std::time::Duration;

impl Device {
    /// Waits for the oldest submissions of [`Recording::submit`](super::Recording::submit) until at most `most` submissions
    /// may still run, which limits the frames in flight. Returns one entry per finished submission, the oldest first: the
    /// times of its passes in the order of recording.
    ///
    /// # Errors
    /// The device is lost.
    pub fn wait_for_running(&self, most: usize) -> Result<Vec<Vec<PassTime>>> {
        let mut times = Vec::new();
        loop {
            let Ok(mut running) = self.running.lock() else {
                return Ok(times);
            };
            if running.len() <= most {
                return Ok(times);
            }
            // It stays in the list while it runs: whatever drops a resource meanwhile must find it there.
            let fence = running.front().map(|oldest| oldest.recorder.fence);
            // SAFETY: the fence was given to the submission. The wait below says what went wrong.
            let _ =
                fence.map(|fence| unsafe { self.raw.wait_for_fences(&[fence], true, u64::MAX) });
            let oldest = running.pop_front();
            drop(running);
            if let Some(submission) = oldest {
                times.push(self.wait_for(submission)?.0);
            }
        }
    }

    /// Waits for a submission, and stores its recorder (command buffer with fence and timestamps) for reuse. Returns two
    /// times: those of its passes in the order of recording, and the duration on the host from the call that submitted it to
    /// the end of the wait.
    ///
    /// # Errors
    /// The device is lost.
    pub(super) fn wait_for(&self, submission: Submission) -> Result<(Vec<PassTime>, Duration)> {
        // SAFETY: the fence was given to the submission.
        let waited = unsafe {
            let fences = [submission.recorder.fence];
            self.raw.wait_for_fences(&fences, true, u64::MAX)
        };
        let taken = submission.started.elapsed();
        let period = f64::from(self.info.timestamp_period);
        let times = waited.and_then(|()| submission.times(&self.raw, period));
        match waited {
            Ok(()) => self.keep(submission.recorder),
            // SAFETY: the device is lost.
            Err(_) => unsafe { submission.destroy(&self.raw) },
        }
        let times = times.map_err(|e| self.failure("run the recorded passes", e))?;
        Ok((times, taken))
    }

    /// Stores a recorder (command buffer with fence and timestamps), so that
    /// [`Commands::new`](super::commands::Commands::new) can use it again. The commands that were submitted with it last must
    /// have finished.
    pub(super) fn keep(&self, recorder: Recorder) {
        match self.idle.lock() {
            Ok(mut idle) => idle.push(recorder),
            // SAFETY: the commands do not run, and it is not used again.
            Err(_) => unsafe { recorder.destroy(&self.raw) },
        }
    }

    /// Waits until all submissions have finished. Objects that submissions may use, such as buffers, call this function when
    /// they are dropped, before they are destroyed. The submissions stay in the device's list of running ones, so that
    /// [`Device::wait_for_running`] still returns their times.
    pub(super) fn wait_before_drop(&self) {
        let Ok(running) = self.running.lock() else {
            return;
        };
        let fences: Vec<vk::Fence> = running.iter().map(|s| s.recorder.fence).collect();
        if !fences.is_empty() {
            // SAFETY: the fences were given to submissions. If the device is lost, nothing runs.
            let _ = unsafe { self.raw.wait_for_fences(&fences, true, u64::MAX) };
        }
    }
}
