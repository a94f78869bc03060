//! The load of other processes, before and during a measurement.

use super::tree::SystemFiles;
use std::path::Path;
use std::time::Duration;

/// The share of busy processors above which times are unreliable.
pub(crate) const LOAD_WARNED_OF: f64 = 0.1;

/// The time over which the load is measured.
const WATCHED: Duration = Duration::from_millis(500);

/// Returns the share of the machine's processors that other processes keep busy, 0..1, while this
/// process sleeps for half a second; none if the machine does not report it.
#[must_use]
pub(crate) fn load_of_others(root: &Path) -> Option<f64> {
    let files = SystemFiles::new(root);
    let before = files.raw_text("proc/stat")?;
    std::thread::sleep(WATCHED);
    busy_share(&before, &files.raw_text("proc/stat")?)
}

/// The start of measuring the load of other processes while this process works.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadWatch {
    /// The ticks of all processors: in total, and idle.
    all: (u64, u64),
    /// The ticks that this process used.
    own: u64,
}

impl LoadWatch {
    /// Starts now; none if the machine does not report its load.
    #[must_use]
    pub(crate) fn start(root: &Path) -> Option<Self> {
        let files = SystemFiles::new(root);
        Some(Self {
            all: times(&files.raw_text("proc/stat")?)?,
            own: own_ticks(&files.raw_text("proc/self/stat")?)?,
        })
    }

    /// Returns the share of the machine's processors that other processes have kept busy since the
    /// start, 0..1; none within the first second, as a tick is a hundredth of a second.
    #[must_use]
    pub(crate) fn share(self, root: &Path) -> Option<f64> {
        let now = Self::start(root)?;
        let total = now.all.0.checked_sub(self.all.0)?;
        if total < 100 {
            return None;
        }
        let idle = now.all.1.saturating_sub(self.all.1).min(total);
        let own = now.own.saturating_sub(self.own);
        Some((total - idle).saturating_sub(own) as f64 / total as f64)
    }
}

/// Returns the user and system ticks of `/proc/self/stat` (`proc_pid_stat(5)`), which follow a name
/// in brackets.
fn own_ticks(stat: &str) -> Option<u64> {
    let (_, fields) = stat.rsplit_once(')')?;
    // The 12th and 13th field after the name, counting from the state.
    let mut ticks = fields.split_whitespace().skip(11).map(str::parse::<u64>);
    Some(ticks.next()?.ok()? + ticks.next()?.ok()?)
}

/// Returns the busy share between two readings of `/proc/stat` (`proc_stat(5)`): all time except
/// idle and waiting for disks. Time that a hypervisor gives to other machines counts as busy.
fn busy_share(before: &str, after: &str) -> Option<f64> {
    let (before, after) = (times(before)?, times(after)?);
    let total = after.0.checked_sub(before.0).filter(|&total| total > 0)?;
    let idle = after.1.saturating_sub(before.1).min(total);
    Some(1.0 - idle as f64 / total as f64)
}

/// Returns the total and the idle ticks.
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
    fn the_load_of_others_leaves_out_this_process() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        let write = |stat: &str, own: &str| {
            let proc = root.join("proc");
            std::fs::create_dir_all(proc.join("self")).expect("made");
            std::fs::write(proc.join("stat"), stat).expect("written");
            std::fs::write(proc.join("self/stat"), own).expect("written");
        };
        let own = |user, system| {
            format!("7 (edge (gait) R) S 1 7 7 0 -1 4 1 0 0 0 {user} {system} 0 0\n")
        };
        write("cpu  100 0 50 800 50 0 0 0\n", &own(30, 5));
        let watch = LoadWatch::start(root).expect("it tells");
        write("cpu  180 0 60 890 70 0 0 0\n", &own(70, 10));
        // 90 of 200 ticks were busy, 45 of them by this process.
        assert_eq!(watch.share(root), Some(45.0 / 200.0));
        write("cpu  101 0 50 890 50 0 0 0\n", &own(31, 5));
        assert_eq!(watch.share(root), None, "less than a second");
        assert!(LoadWatch::start(&root.join("none")).is_none());
    }

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
