//! How busy the machine is before anything is measured.

use super::tree::Tree;
use std::path::Path;
use std::time::Duration;

/// Above this share of busy processors, times are not to be trusted.
pub(crate) const LOAD_WARNED_OF: f64 = 0.1;

/// How long others are watched.
const WATCHED: Duration = Duration::from_millis(500);

/// The share of the machine's processors that others keep busy, 0..1, while this process sleeps
/// for half a second; none if the machine does not tell.
#[must_use]
pub(crate) fn load_of_others(root: &Path) -> Option<f64> {
    let files = Tree::new(root);
    let before = files.raw_text("proc/stat")?;
    std::thread::sleep(WATCHED);
    busy_share(&before, &files.raw_text("proc/stat")?)
}

/// From two readings of `/proc/stat` (`proc_stat(5)`): all but idle and waiting for disks. Time
/// that a hypervisor gives to others is busy.
fn busy_share(before: &str, after: &str) -> Option<f64> {
    let (before, after) = (times(before)?, times(after)?);
    let total = after.0.checked_sub(before.0).filter(|&total| total > 0)?;
    let idle = after.1.saturating_sub(before.1).min(total);
    Some(1.0 - idle as f64 / total as f64)
}

/// All, and idle.
fn times(stat: &str) -> Option<(u64, u64)> {
    let line = stat.lines().find_map(|line| line.strip_prefix("cpu "))?;
    // user nice system idle iowait irq softirq steal; guests are part of user.
    let fields = line.split_whitespace().take(8).map(str::parse);
    let fields: Vec<u64> = fields.collect::<Result<_, _>>().ok()?;
    Some((
        fields.iter().sum(),
        fields.get(3)? + fields.get(4).unwrap_or(&0),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_the_time_between_two_readings_is_busy() {
        let before = "cpu  100 0 50 800 50 0 0 0 7 0\ncpu0 1 2 3 4\n";
        let after = "cpu  110 0 55 870 55 5 0 5 7 0\ncpu0 1 2 3 4\n";
        // 10 + 5 + 5 + 5 of 100 are busy, 70 + 5 are not.
        assert_eq!(busy_share(before, after), Some(0.25));
        assert_eq!(busy_share(before, before), None);
        assert_eq!(busy_share("", after), None);
    }
}
