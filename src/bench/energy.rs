//! Energy meters, where the machine has one.

use super::board::SystemFiles;
use crate::error::{Error, Result};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// The time between two readings of a power sensor.
const SAMPLED_EVERY: Duration = Duration::from_millis(50);

/// A counter of energy or a sensor of power. It measures all that it is wired to, including idle
/// power and the work of other processes.
#[derive(Debug)]
pub(crate) struct Meter {
    files: SystemFiles,
    source: String,
    kind: EnergyKind,
}

#[derive(Debug)]
enum EnergyKind {
    /// Counters in microjoules, each with the value at which it wraps to 0, if known.
    Counters(Vec<(PathBuf, Option<u64>)>),
    /// Sensors in microwatts, sampled by a thread.
    Sensors(Vec<PathBuf>),
}

impl Meter {
    /// Finds the first readable meter: a processor's own counters (powercap: RAPL), then energy
    /// counters and power sensors of hwmon (`Documentation/hwmon/sysfs-interface`); none if there
    /// is none.
    #[must_use]
    pub(crate) fn find(root: &Path) -> Option<Self> {
        let files = SystemFiles::new(root);
        let is_read = |path: &PathBuf| files.number::<u64>(path).is_some();
        let zones: Vec<PathBuf> = files
            .entries("sys/class/powercap", "intel-rapl:")
            .into_iter()
            // Subzones (intel-rapl:0:0) are included in their zone's count.
            .filter(|zone| zone.to_string_lossy().matches(':').count() == 1)
            .filter(|zone| is_read(&zone.join("energy_uj")))
            .collect();
        if !zones.is_empty() {
            let names = zones
                .iter()
                .filter_map(|zone| files.text(zone.join("name")));
            let source = format!("powercap {}", names.collect::<Vec<_>>().join(", "));
            let counters = zones.iter().map(|zone| {
                let range = files.number(zone.join("max_energy_range_uj"));
                (zone.join("energy_uj"), range)
            });
            let kind = EnergyKind::Counters(counters.collect());
            return Some(Self {
                files,
                source,
                kind,
            });
        }
        for prefix in ["energy", "power"] {
            for device in files.entries("sys/class/hwmon", "hwmon") {
                let inputs: Vec<PathBuf> = files
                    .entries(&device, prefix)
                    .into_iter()
                    .filter(|path| path.to_string_lossy().ends_with("_input") && is_read(path))
                    .collect();
                if inputs.is_empty() {
                    continue;
                }
                let name = files.text(device.join("name")).unwrap_or_default();
                let labels = inputs.iter().map(|input| {
                    let stem = input.to_string_lossy().replace("_input", "_label");
                    let file = input
                        .file_name()
                        .unwrap_or_default()
                        .to_string_lossy()
                        .into_owned();
                    files.text(stem).unwrap_or(file)
                });
                let labels = labels.collect::<Vec<_>>().join(", ");
                let source = format!("hwmon {name} {labels}");
                let kind = match prefix {
                    "energy" => {
                        EnergyKind::Counters(inputs.into_iter().map(|path| (path, None)).collect())
                    }
                    _ => EnergyKind::Sensors(inputs),
                };
                return Some(Self {
                    files,
                    source,
                    kind,
                });
            }
        }
        None
    }

    /// Returns the name of the counters or sensors that are read.
    #[must_use]
    pub(crate) fn source(&self) -> &str {
        &self.source
    }

    /// Starts to count energy.
    ///
    /// # Errors
    /// If the system cannot start the thread that reads a sensor.
    pub(crate) fn start(&self) -> Result<EnergyCount> {
        Ok(match &self.kind {
            EnergyKind::Counters(counters) => EnergyCount::Counters(self.read(counters)),
            EnergyKind::Sensors(sensors) => {
                let (stop, stopped) = channel();
                let (files, sensors) = (self.files.clone(), sensors.clone());
                let started = Instant::now();
                let sampler = move || {
                    let mut watts = Vec::new();
                    loop {
                        let microwatts = sensors.iter().map(|path| files.number::<f64>(path));
                        watts.push(1e-6 * microwatts.sum::<Option<f64>>()?);
                        match stopped.recv_timeout(SAMPLED_EVERY) {
                            Err(RecvTimeoutError::Timeout) => {}
                            _ => break,
                        }
                    }
                    let mean = watts.iter().sum::<f64>() / watts.len() as f64;
                    Some(mean * started.elapsed().as_secs_f64())
                };
                let sampler = Builder::new().spawn(sampler).map_err(Error::Threads)?;
                EnergyCount::Sensors { stop, sampler }
            }
        })
    }

    /// Returns the joules since `count` started; none if the meter can no longer be read.
    #[must_use]
    pub(crate) fn stop(&self, count: EnergyCount) -> Option<f64> {
        match (count, &self.kind) {
            (EnergyCount::Sensors { stop, sampler }, _) => {
                drop(stop);
                sampler.join().ok().flatten()
            }
            (EnergyCount::Counters(before), EnergyKind::Counters(counters)) => {
                let (before, after) = (before?, self.read(counters)?);
                let microjoules = before.iter().zip(&after).zip(counters);
                microjoules
                    .map(
                        |((&before, &after), (_, range))| match after.checked_sub(before) {
                            Some(more) => Some(more as f64 * 1e-6),
                            // The counter wrapped once: windows are shorter than its range.
                            None => {
                                let rest = range.as_ref()?.checked_sub(before)?;
                                Some((rest + after + 1) as f64 * 1e-6)
                            }
                        },
                    )
                    .sum()
            }
            (EnergyCount::Counters(_), EnergyKind::Sensors(_)) => None,
        }
    }

    fn read(&self, counters: &[(PathBuf, Option<u64>)]) -> Option<Vec<u64>> {
        counters
            .iter()
            .map(|(path, _)| self.files.number(path))
            .collect()
    }
}

/// Energy that is being counted.
#[derive(Debug)]
pub(crate) enum EnergyCount {
    /// The values of the counters at the start.
    Counters(Option<Vec<u64>>),
    /// A thread that samples the sensors until it is stopped.
    Sensors {
        /// The channel that stops the thread when it is dropped.
        stop: Sender<()>,
        /// The thread, which returns joules.
        sampler: JoinHandle<Option<f64>>,
    },
}

#[cfg(test)]
mod tests {
    use super::super::board::tests::{machine, write};
    use super::*;

    #[test]
    fn a_machine_without_counters_has_no_meter() {
        assert!(Meter::find(machine(&[]).path()).is_none());
        // A counter that cannot be read counts as absent.
        let root = machine(&[("sys/class/powercap/intel-rapl:0/name", "package-0\n")]);
        assert!(Meter::find(root.path()).is_none());
    }

    #[test]
    fn a_processors_counters_are_added_and_may_wrap() {
        let zone = "sys/class/powercap/intel-rapl";
        let root = machine(&[
            (&format!("{zone}:0/name"), "package-0\n"),
            (&format!("{zone}:0/energy_uj"), "999000\n"),
            (&format!("{zone}:0/max_energy_range_uj"), "999999\n"),
            (&format!("{zone}:0:0/energy_uj"), "5\n"),
            (&format!("{zone}:1/name"), "package-1\n"),
            (&format!("{zone}:1/energy_uj"), "1000000\n"),
            (&format!("{zone}:1/max_energy_range_uj"), "262143328850\n"),
        ]);
        let meter = Meter::find(root.path()).expect("a meter");
        assert_eq!(meter.source(), "powercap package-0, package-1");
        let count = meter.start().expect("a count");
        write(root.path(), &format!("{zone}:0/energy_uj"), "499000\n");
        write(root.path(), &format!("{zone}:1/energy_uj"), "3000000\n");
        // 0.5 J past the wrap, and 2 J.
        let joules = meter.stop(count).expect("counted");
        assert!((joules - 2.5).abs() < 1e-9, "{joules}");
    }

    #[test]
    fn a_counter_of_hwmon_is_preferred_to_a_sensor() {
        let root = machine(&[
            ("sys/class/hwmon/hwmon0/name", "ina3221\n"),
            ("sys/class/hwmon/hwmon0/power1_input", "5000000\n"),
            ("sys/class/hwmon/hwmon1/name", "ltc4282\n"),
            ("sys/class/hwmon/hwmon1/energy1_input", "1500000\n"),
            ("sys/class/hwmon/hwmon1/energy1_enable", "1\n"),
        ]);
        let meter = Meter::find(root.path()).expect("a meter");
        assert_eq!(meter.source(), "hwmon ltc4282 energy1_input");
        let count = meter.start().expect("a count");
        write(
            root.path(),
            "sys/class/hwmon/hwmon1/energy1_input",
            "1750000\n",
        );
        assert_eq!(meter.stop(count), Some(0.25));
        // It wrapped, at an unknown value.
        let count = meter.start().expect("a count");
        write(root.path(), "sys/class/hwmon/hwmon1/energy1_input", "1\n");
        assert_eq!(meter.stop(count), None);
    }

    #[test]
    fn a_sensor_of_5_watts_gives_5_joules_a_second() {
        let root = machine(&[
            ("sys/class/hwmon/hwmon2/name", "ina219\n"),
            ("sys/class/hwmon/hwmon2/power1_input", "5000000\n"),
            ("sys/class/hwmon/hwmon2/power1_label", "VDD_IN\n"),
        ]);
        let meter = Meter::find(root.path()).expect("a meter");
        assert_eq!(meter.source(), "hwmon ina219 VDD_IN");
        let started = Instant::now();
        let count = meter.start().expect("a count");
        std::thread::sleep(Duration::from_millis(120));
        let least = 5.0 * 0.12;
        let joules = meter.stop(count).expect("sampled");
        let most = 5.0 * started.elapsed().as_secs_f64();
        assert!((least - 1e-9..=most).contains(&joules), "{joules}");
    }
}
