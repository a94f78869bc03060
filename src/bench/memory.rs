//! How much memory this process has, where the system tells (`proc_pid_status(5)`).

/// The most memory that the process has had, bytes.
#[must_use]
pub(crate) fn peak_rss_bytes() -> Option<u64> {
    status("VmHWM:")
}

/// The memory that the process has now, bytes.
pub(super) fn rss_bytes() -> Option<u64> {
    status("VmRSS:")
}

/// Lets [`peak_rss_bytes`] begin anew (`proc_pid_clear_refs(5)`, value 5); where the system
/// refuses, the peak stays what it was.
pub(super) fn forget_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// The memory that the machine can still give, bytes (`MemAvailable` of `proc(5)`).
pub(super) fn available_bytes() -> Option<u64> {
    kilobytes("/proc/meminfo", "MemAvailable:")
}

fn status(name: &str) -> Option<u64> {
    kilobytes("/proc/self/status", name)
}

fn kilobytes(file: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn a_peak_is_at_least_what_is_held_and_can_be_asked_for_anew() {
        // Other tests hold memory too, and free it meanwhile: no more can be said.
        let big = std::hint::black_box(vec![1_u8; 64 << 20]);
        let peak = peak_rss_bytes().expect("Linux tells");
        assert!(available_bytes().is_some_and(|bytes| bytes > 0));
        assert!(peak >= big.len() as u64, "{peak}");
        forget_peak();
        let now = rss_bytes().expect("Linux tells");
        assert!(
            now >= big.len() as u64 && peak_rss_bytes().is_some(),
            "{now}"
        );
    }
}
