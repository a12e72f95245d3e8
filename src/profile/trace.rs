//! Profiles as traces in the Trace Event Format, a JSON format that Chrome (`chrome://tracing`) and
//! [Perfetto](https://ui.perfetto.dev) show as a timeline.

use super::Frame;
use serde_json::{Value, json};

/// Number (`tid`) of the track on the timeline that shows the frames on the host; viewers of traces group
/// events by this number. `DEVICE` is the number of the track with the frames and the passes on the device.
const HOST: u32 = 1;
const DEVICE: u32 = 2;

/// A trace of frames as JSON. The track of the host shows the frames; the track of the device shows the frames and each run
/// of their passes. Times are in microseconds, as the format requires.
///
/// The clocks of the host and of the device have different zero points. So the times of a frame's passes are shifted: the
/// last pass ends when the frame on the host ends, because at this time the host stops waiting for the device.
pub fn trace(frames: &[Frame]) -> Value {
    let mut events = vec![
        json!({"ph": "M", "pid": 1, "name": "process_name", "args": {"name": "headwater"}}),
        json!({"ph": "M", "pid": 1, "tid": HOST, "name": "thread_name", "args": {"name": "host"}}),
        json!({"ph": "M", "pid": 1, "tid": DEVICE, "name": "thread_name", "args": {"name": "device"}}),
    ];
    let mut slice = |track: u32, name: &str, start: f64, length: f64, args: Value| {
        events.push(json!({
            "ph": "X", "pid": 1, "tid": track, "name": name,
            "ts": start * 1e3, "dur": length * 1e3, "args": args,
        }));
    };
    for frame in frames {
        let name = format!("frame {}", frame.index);
        slice(HOST, &name, frame.start, frame.host, json!({}));
        let ends = frame
            .passes
            .iter()
            .map(|pass| pass.start + pass.milliseconds);
        let length = ends.fold(0.0, f64::max);
        // A device that waits for the host between two passes may seem to take longer than the frame.
        let length = length.min(frame.host);
        let start = frame.start + frame.host - length;
        slice(DEVICE, &name, start, length, json!({}));
        for pass in &frame.passes {
            let (from, to) = (
                pass.start.min(length),
                (pass.start + pass.milliseconds).min(length),
            );
            let args = json!({"first_run": pass.first_run});
            slice(DEVICE, &pass.name, start + from, to - from, args);
        }
    }
    json!({"displayTimeUnit": "ms", "traceEvents": events})
}
