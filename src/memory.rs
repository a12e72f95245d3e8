//! Memory: how much there is, asked before an input takes much of it. Linux promises more than it has, and then ends
//! the process that uses it; so a reservation alone proves nothing.

use crate::out_of_memory::may_fail;

/// Less is taken without a look at what there is.
const LITTLE: u64 = 64 << 20;

/// Checks that there is memory for so many bytes more.
///
/// # Errors
/// There is not; the text gives both numbers of bytes.
pub fn check(bytes: u64) -> Result<(), String> {
    match available() {
        Some(available) if bytes > LITTLE && bytes > available => Err(format!(
            "{bytes} bytes are more than there is memory for, {available} bytes are free"
        )),
        _ => Ok(()),
    }
}

/// An empty vector with a capacity of `bytes`.
///
/// # Errors
/// There is not enough memory; the text gives the number of bytes.
pub fn room_for(bytes: u64) -> Result<Vec<u8>, String> {
    check(bytes)?;
    let mut room = Vec::new();
    usize::try_from(bytes)
        .ok()
        .and_then(|bytes| may_fail(|| room.try_reserve_exact(bytes).ok()))
        .ok_or_else(|| format!("{bytes} bytes are more than there is memory for"))?;
    Ok(room)
}

/// Bytes that the process can still take: what is free or can be freed, and no more than the limit of its control
/// group. None where the system does not report it.
fn available() -> Option<u64> {
    let report = std::fs::read_to_string("/proc/meminfo").ok()?;
    let free = kibibytes(&report, "MemAvailable:")? + kibibytes(&report, "SwapFree:").unwrap_or(0);
    let group = std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok();
    let limit = group.and_then(|limit| limit.trim().parse().ok());
    Some((1024 * free).min(limit.unwrap_or(u64::MAX)))
}

/// A number of `/proc/meminfo`.
fn kibibytes(report: &str, key: &str) -> Option<u64> {
    let line = report.lines().find_map(|line| line.strip_prefix(key))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_for_little_and_none_for_all() {
        assert!(room_for(1000).unwrap().capacity() >= 1000);
        for bytes in [1 << 60, u64::MAX] {
            let text = room_for(bytes).unwrap_err();
            assert!(text.contains(&format!("{bytes} bytes")), "{text}");
        }
    }

    #[test]
    fn numbers_of_the_report_are_found() {
        let report = "MemFree:  7 kB\nMemAvailable:   1234 kB\nSwapFree: 0 kB\n";
        assert_eq!(kibibytes(report, "MemAvailable:"), Some(1234));
        assert_eq!(kibibytes(report, "SwapFree:"), Some(0));
        assert_eq!(kibibytes(report, "Other:"), None);
    }
}
