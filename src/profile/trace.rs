//! Profiles as traces in the Trace Event Format, which Chrome (`chrome://tracing`) and [Perfetto](https://ui.perfetto.dev)
//! show.

use super::Frame;
use serde_json::{Value, json};

/// Index (`tid`) of the trace's track for the frames on the host. `DEVICE` is the index of the track for the frames and
/// passes on the device.
const HOST: u32 = 1;
const DEVICE: u32 = 2;

/// A trace of frames as JSON: the track of the host has the frames, the track of the device has the frames and the runs of
/// their passes. Times are in microseconds, as the format requires.
///
/// The host and the device have different clocks. So the passes of a frame are moved until the last one ends at the end of
/// the frame on the host, when the wait for the device ends.
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
