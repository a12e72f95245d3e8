//! Writes a time for people, with three digits or more.

/// The time of a frame as text, such as `4.25 ms`. `is_measured` is false if it follows from other times; then it is
/// `about 4.25 ms`.
pub fn text(milliseconds: f64, is_measured: bool) -> String {
    let about = if is_measured { "" } else { "about " };
    match milliseconds {
        ms if ms < 10.0 => format!("{about}{ms:.2} ms"),
        ms if ms < 100.0 => format!("{about}{ms:.1} ms"),
        ms => format!("{about}{ms:.0} ms"),
    }
}
