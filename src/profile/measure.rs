//! The loop that renders and times the frames of a profile. It reads no data back from the device, because that would add to
//! the times. There is one exception: on drivers that end long loops
//! ([`DeviceInfo::loop_turns`](crate::gpu::DeviceInfo::loop_turns)), it reads the counters after each frame.

use crate::Result;
use crate::gpu::{Device, PassTime};
use crate::render::Renderer;
use std::sync::Arc;
use std::time::Instant;

/// The plan of a measurement, which [`measure()`] follows: how many frames a profile renders, and how many of them can be in
/// flight at once.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Number of frames that are rendered before the timed ones. During them, the shaders are compiled and the history (the
    /// data that a frame reuses of earlier frames) is filled, so that the timed frames do only the usual work of a frame.
    pub warm_up: u32,
    /// Number of timed frames, at least 1, which follow the warm-up. The medians and percentiles of the
    /// profile are computed from them. More frames give less noise in these values.
    pub frames: u32,
    /// The maximum number of frames that are submitted to the device but not finished, at least 1. With 1, the host waits
    /// for each frame before it submits the next one. With more, the device has no gaps between frames, but the time of a
    /// single frame on the device is not known.
    pub in_flight: u32,
}

/// The times of one frame, on the host and on the device, and of its passes, in milliseconds. Profiles take their medians
/// and percentiles from the timed frames, and traces show each frame on a timeline.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Index of the frame: 0 is the first frame of the warm-up, and the timed frames continue the count. Traces show it as
    /// the name of the frame.
    pub index: u32,
    /// Time by the clock of the host from the start of the first frame of the warm-up to the start of this frame, in
    /// milliseconds. It is the position of the frame on the timeline of a trace.
    pub start: f64,
    /// Time by the clock of the host from the start of this frame to the start of the next one, in milliseconds. With
    /// several frames in flight, it is the only time of a whole frame that is known.
    pub host: f64,
    /// Time by the clock of the host from the submission of the frame to the end of the wait for the device, in
    /// milliseconds. A frame with several submissions has the sum of their times. 0 with several frames in flight, because
    /// the host then does not wait for each frame.
    pub submitted: f64,
    /// Times of the frame's passes on the device, one entry per run of a pass, in the order of the runs. With path tracing,
    /// there is one entry per pass with the sum of its runs. Empty on a device without timestamps.
    pub passes: Vec<PassTime>,
}

/// Renders the frames of `plan`, first those of the warm-up and then the timed ones, and returns the times of all of them in
/// this order. `prepare` is called before each frame with the frame's index; it sets the time and the camera of the frame.
/// If it returns an error, the measurement ends.
///
/// # Errors
/// The device fails, or `prepare` returns an error.
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
