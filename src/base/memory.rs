//! Checks whether enough memory is available before an input takes much of it. Such a check is needed because Linux lets
//! processes reserve more memory than the machine has, and kills a process that then uses too much. A successful
//! reservation does not prove that there is enough memory.

use crate::base::out_of_memory::may_fail;
use std::fs::read_to_string;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// The maximum sum of requested bytes for which [`check`] does not read the available memory from the system:
/// 64 MiB. The available memory is not read for each small request, because reading it takes several system
/// calls.
const LITTLE: u64 = 64 << 20;

/// The sum, in bytes, of the requests to [`check`] of at most [`LITTLE`] bytes since the available memory was last read.
/// When the sum exceeds [`LITTLE`], the available memory is read again. All threads share this sum.
static TAKEN: AtomicU64 = AtomicU64::new(0);

/// Checks that at least `bytes` bytes of memory, and at least [`LITTLE`] bytes, are available; reserves nothing. A request
/// of at most [`LITTLE`] bytes passes unchecked while the sum of such requests is at most [`LITTLE`]. For any other
/// request, the available memory is read from the system, and the sum starts again at 0.
///
/// # Errors
/// Less memory is available than needed; the text names the needed and the available number of bytes. If the system does
/// not report its memory, the check passes.
pub fn check(bytes: u64) -> Result<(), String> {
    if bytes <= LITTLE && TAKEN.fetch_add(bytes, Ordering::Relaxed) + bytes <= LITTLE {
        return Ok(());
    }
    TAKEN.store(0, Ordering::Relaxed);
    let needed = bytes.max(LITTLE);
    match available() {
        Some(available) if needed > available => Err(format!(
            "{needed} bytes are more than there is memory for, {available} bytes are free"
        )),
        _ => Ok(()),
    }
}

/// An empty vector with a capacity of `bytes` bytes, for example for the content of a file.
///
/// # Errors
/// There is not enough memory; the text names the number of bytes.
pub fn room_for(bytes: u64) -> Result<Vec<u8>, String> {
    check(bytes)?;
    let mut room = Vec::new();
    usize::try_from(bytes)
        .ok()
        .and_then(|bytes| may_fail(|| room.try_reserve_exact(bytes).ok()))
        .ok_or_else(|| format!("{bytes} bytes are more than there is memory for"))?;
    Ok(room)
}

/// The number of bytes of memory that the process can still use: memory that is free or that the system can free, within
/// the limits of the process's control groups and of its address space. `None` if the system does not report it.
fn available() -> Option<u64> {
    let report = read_to_string("/proc/meminfo").ok()?;
    let kibibytes = |key| value(&report, key);
    let free = 1024 * (kibibytes("MemAvailable:")? + kibibytes("SwapFree:").unwrap_or(0));
    let groups = read_to_string("/proc/self/cgroup").unwrap_or_default();
    let in_groups = left_in_groups(&groups, Path::new("/sys/fs/cgroup"));
    let limits = [in_groups, left_in_address_space()];
    Some(limits.into_iter().flatten().fold(free, u64::min))
}

/// The number after `key` in a report with one key per line, such as `/proc/meminfo`; `None` if the report has no number for
/// it.
fn value(report: &str, key: &str) -> Option<u64> {
    number(report.lines().find_map(|line| line.strip_prefix(key))?)
}

/// The first word of `text`, such as a size in a report of the system, as an unsigned integer; `None` if there is no word or
/// it is not an integer.
fn number(text: &str) -> Option<u64> {
    text.split_whitespace().next()?.parse().ok()
}

/// The number of bytes that a process may still take before it reaches a memory limit of its control groups (cgroups);
/// `None` if they have no limit. `groups` is the content of the process's `/proc/self/cgroup`, and `root` is the folder
/// where the system shows the groups, `/sys/fs/cgroup`.
fn left_in_groups(groups: &str, root: &Path) -> Option<u64> {
    let left = groups.lines().filter_map(|line| {
        let (controllers, path) = line.split_once(':')?.1.split_once(':')?;
        let (root, limit, used, prefix) = match controllers {
            "" => (root.to_owned(), "memory.max", "memory.current", ""),
            _ if controllers.split(',').any(|name| name == "memory") => (
                root.join("memory"),
                "memory.limit_in_bytes",
                "memory.usage_in_bytes",
                "total_",
            ),
            _ => return None,
        };
        // Each group has the limits of those around it too. In a container the path may be that of the host: then the
        // root is the process's own group.
        let groups = Path::new(path.trim_start_matches('/')).ancestors();
        let left = groups.filter_map(|group| {
            let read = |name| read_to_string(root.join(group).join(name)).ok();
            let limit = number(&read(limit)?)?;
            // What was read from files counts as used, though it is given up when memory is needed.
            let statistics = read("memory.stat").unwrap_or_default();
            let cached = ["inactive_file ", "active_file "].map(|kind| {
                let key = format!("{prefix}{kind}");
                value(&statistics, &key).unwrap_or(0)
            });
            let used = number(&read(used)?)?.saturating_sub(cached.iter().sum());
            Some(limit.saturating_sub(used))
        });
        left.min()
    });
    left.min()
}

/// The number of bytes by which the process's address space can still grow until its limit (`ulimit -v`); `None` if it
/// has no limit.
fn left_in_address_space() -> Option<u64> {
    let limit = rustix::process::getrlimit(rustix::process::Resource::As).current?;
    let used = number(&read_to_string("/proc/self/statm").ok()?)?;
    Some(limit.saturating_sub(used * rustix::param::page_size() as u64))
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
        assert_eq!(value(report, "MemAvailable:"), Some(1234));
        assert_eq!(value(report, "SwapFree:"), Some(0));
        assert_eq!(value(report, "Other:"), None);
    }

    #[test]
    fn control_groups_of_both_versions_limit_what_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, content: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, content).unwrap();
        };
        let left = |groups: &str| left_in_groups(groups, folder.path());
        assert_eq!(left("0::/\n"), None);
        write("a/memory.max", "1000\n");
        write("a/memory.current", "700\n");
        write(
            "a/memory.stat",
            "anon 1\ninactive_file 30\nactive_file 70\n",
        );
        write("a/b/memory.max", "max\n");
        write("a/b/memory.current", "600\n");
        assert_eq!(left("1:cpu:/x\n0::/a/b\n"), Some(400));
        assert_eq!(left("0::/other\n"), None);
        write("memory/memory.limit_in_bytes", "500\n");
        write("memory/memory.usage_in_bytes", "450\n");
        write(
            "memory/memory.stat",
            "active_file 1\ntotal_active_file 20\n",
        );
        let first = "4:cpu,memory:/of/the/host\n";
        assert_eq!(left(first), Some(70));
        assert_eq!(left(&format!("{first}0::/a\n")), Some(70));
        write("a/memory.current", "2000\n");
        assert_eq!(left("0::/a\n"), Some(0));
    }
}
