//! The memory of this process, where the system reports it (`proc_pid_status(5)`).

/// Returns the peak memory of the process, bytes.
#[must_use]
pub(crate) fn peak_rss_bytes() -> Option<u64> {
    status("VmHWM:")
}

/// Returns the current memory of the process, bytes.
pub(super) fn rss_bytes() -> Option<u64> {
    status("VmRSS:")
}

/// Resets [`peak_rss_bytes`] (`proc_pid_clear_refs(5)`, value 5), where the system allows it.
pub(super) fn forget_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Returns the memory that is available on the machine, bytes (`MemAvailable` of `proc(5)`).
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
    fn a_peak_is_at_least_what_is_held_and_can_be_reset() {
        // Other tests hold memory and free it at the same time, so nothing stronger can be
        // asserted.
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
