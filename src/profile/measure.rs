//! The loop over frames that is timed. Nothing is read back in it.

use crate::Result;
use crate::gpu::{Device, PassTime};
use crate::render::Renderer;
use std::sync::Arc;
use std::time::Instant;

/// The frames that are rendered.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// The number of frames before the timed ones: they compile shaders and fill the history.
    pub warm_up: u32,
    /// The number of timed frames.
    pub frames: u32,
    /// The maximum number of frames that are submitted but not finished.
    pub in_flight: u32,
}

/// The times of one frame, in milliseconds.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// The index of the frame.
    pub number: u32,
    /// The time of its start on the host, since the first frame.
    pub start: f64,
    /// The time from its start to the start of the next frame.
    pub host: f64,
    /// The time on the device, from the submission to the end of the wait; 0 with several frames in flight.
    pub submitted: f64,
    /// The passes of the frame, one entry for each run.
    pub passes: Vec<PassTime>,
}

/// Renders the frames of a plan, first those of the warm-up. `prepare` sets the time and the camera of each frame, and may end
/// the work.
///
/// # Errors
/// The device fails, or the errors of `prepare`.
pub fn measure(
    device: &Arc<Device>,
    renderer: &mut Renderer,
    plan: Plan,
    prepare: &mut dyn FnMut(&mut Renderer, u32) -> Result<()>,
) -> Result<Vec<Frame>> {
    let began = Instant::now();
    let milliseconds = |since: Instant| since.elapsed().as_secs_f64() * 1e3;
    let mut frames: Vec<Frame> = Vec::new();
    // Frames end in the order in which they were submitted.
    let mut finished = 0;
    let mut finish = |frames: &mut [Frame], most: u32| -> Result<()> {
        for passes in device.wait_for_running(most as usize)? {
            frames[finished].passes = passes;
            finished += 1;
        }
        Ok(())
    };
    for number in 0..plan.warm_up + plan.frames {
        let start = milliseconds(began);
        let frame_began = Instant::now();
        prepare(renderer, number)?;
        let before = device.records.submitted_time();
        let label = device.label(&format!("frame {number}"));
        let mut frame = Frame {
            number,
            start,
            ..Frame::default()
        };
        if plan.in_flight == 1 {
            frame.passes = renderer.single_frame(number)?;
            frame.submitted = (device.records.submitted_time() - before).as_secs_f64() * 1e3;
        } else {
            // Path tracing waits, and has its times at once.
            frame.passes = renderer.submit_frame(number)?.unwrap_or_default();
        }
        drop(label);
        frames.push(frame);
        if plan.in_flight > 1 {
            finish(&mut frames, plan.in_flight - 1)?;
        }
        if let Some(frame) = frames.last_mut() {
            frame.host = milliseconds(frame_began);
        }
    }
    if plan.in_flight > 1 {
        finish(&mut frames, 0)?;
    }
    Ok(frames)
}
