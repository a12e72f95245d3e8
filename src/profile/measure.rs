//! The loop over frames that is timed. It reads nothing back from the device. The exception is a counter after each frame on
//! drivers that end long loops ([`DeviceInfo::loop_turns`](crate::gpu::DeviceInfo::loop_turns)).

use crate::Result;
use crate::gpu::{Device, PassTime};
use crate::render::Renderer;
use std::sync::Arc;
use std::time::Instant;

/// The numbers of frames that a profile renders.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Number of frames that are rendered before the timed ones, to compile the shaders and to fill the history (what a
    /// frame reuses of earlier frames).
    pub warm_up: u32,
    /// Number of timed frames, which follow the warm-up.
    pub frames: u32,
    /// The maximum number of frames that are submitted but not finished, at least 1. With 1, the host waits for each frame;
    /// with more, the device has no gaps between frames.
    pub in_flight: u32,
}

/// The times of one frame and of its passes, in milliseconds.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Index of the frame, counted from 0 at the first frame of the warm-up.
    pub index: u32,
    /// Time on the host from the start of the first frame to the start of this one, in milliseconds.
    pub start: f64,
    /// Time on the host from the start of this frame to the start of the next one, in milliseconds.
    pub host: f64,
    /// Time from the submission of the frame to the end of the wait for it, in milliseconds, summed over the submissions of
    /// the frame; 0 with several frames in flight.
    pub submitted: f64,
    /// Times of the passes on the device, one entry per run in the order of the runs. Path tracing has one entry per pass,
    /// and a device without timestamps has none.
    pub passes: Vec<PassTime>,
}

/// Renders the frames of a plan, first those of the warm-up, and returns their times in order. `prepare` is called before
/// each frame with its index; it sets the time and the camera, and can end the work with an error.
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
    for index in 0..plan.warm_up + plan.frames {
        let start = milliseconds(began);
        let frame_began = Instant::now();
        prepare(renderer, index)?;
        let before = device.records.submitted_time();
        let label = device.label(&format!("frame {index}"));
        let mut frame = Frame {
            index,
            start,
            ..Frame::default()
        };
        if plan.in_flight == 1 {
            frame.passes = renderer.single_frame(index)?;
            frame.submitted = (device.records.submitted_time() - before).as_secs_f64() * 1e3;
        } else {
            // Path tracing waits, and has its times at once.
            frame.passes = renderer.submit_frame(index)?.unwrap_or_default();
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
