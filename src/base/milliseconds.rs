//! Formats the time of a frame for people, with at least three digits.

/// The time of a frame as text, such as `4.25 ms`. If `is_measured` is false, the time was computed from
/// other times, and the text begins with `about`.
pub fn text(milliseconds: f64, is_measured: bool) -> String {
    let about = if is_measured { "" } else { "about " };
    match milliseconds {
        ms if ms < 10.0 => format!("{about}{ms:.2} ms"),
        ms if ms < 100.0 => format!("{about}{ms:.1} ms"),
        ms => format!("{about}{ms:.0} ms"),
    }
}
