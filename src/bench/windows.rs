//! How long is measured: warm-up, and windows of many calls.

use super::statistics::Times;
use crate::error::{Error, Result};
use std::time::{Duration, Instant};

/// Fewest inferences of a window (the suggestion of gait benchmarks at the edge: enough for a
/// 99th percentile).
pub(crate) const LEAST_INFERENCES: u64 = 100;

/// How long is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plan {
    /// Calls before each window that are not timed.
    pub warm_up: u32,
    /// Shortest window; one also has at least [`LEAST_INFERENCES`].
    pub window: Duration,
    /// Windows, at least one.
    pub windows: u32,
}

impl Plan {
    /// Ten calls to warm up, five windows of 1 s.
    pub(crate) const DEFAULT: Self = Self {
        warm_up: 10,
        window: Duration::from_secs(1),
        windows: 5,
    };
    /// As MLPerf Tiny 1.2 runs its performance script: five windows, median; 10 s at least,
    /// here each; 10 calls to warm up before each, the most that any of its tasks has.
    pub(crate) const MLPERF: Self = Self {
        warm_up: 10,
        window: Duration::from_secs(10),
        windows: 5,
    };
}

/// What is timed: one call.
pub(crate) type Work<'w> = &'w mut dyn FnMut() -> Result<()>;

/// What was measured in one window.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Window {
    /// Times of the calls.
    pub times: Times,
    /// Energy in joules, where it was metered.
    pub energy_j: Option<f64>,
}

/// Is told when a window begins and ends, outside of what is timed.
pub(crate) trait Watch {
    /// A window begins.
    fn begin(&mut self);
    /// It has ended; the energy that it took, joules, if that is metered.
    fn end(&mut self) -> Option<f64>;
}

/// Measures calls of which each makes `batch` inferences; several kinds of work take turns,
/// window by window, the first and the last of them by turns, so that what slows the machine
/// slows all of them. Windows of each kind.
///
/// A call's time is from the end of the call before it, so that the times of a window add up to
/// its length and one reading of the clock a call is all that is added.
///
/// # Errors
/// When a call fails.
pub(crate) fn measure<const N: usize>(
    plan: &Plan,
    batch: usize,
    works: [Work<'_>; N],
    watch: &mut dyn Watch,
) -> Result<[Vec<Window>; N]> {
    let mut all = [const { Vec::new() }; N];
    let mut times = Vec::new();
    for round in 0..plan.windows {
        for turn in 0..N {
            let at = if round % 2 == 0 { turn } else { N - 1 - turn };
            for _ in 0..plan.warm_up {
                works[at]()?;
            }
            watch.begin();
            window(plan, batch as u64, works[at], &mut times)?;
            let energy_j = watch.end();
            let times = Times::of(&mut times).ok_or(Error::Missing("a call in each window"))?;
            all[at].push(Window { times, energy_j });
        }
    }
    Ok(all)
}

fn window(plan: &Plan, batch: u64, work: Work<'_>, times: &mut Vec<u64>) -> Result<()> {
    times.clear();
    let started = Instant::now();
    let mut last = started;
    loop {
        work()?;
        let now = Instant::now();
        times.push(u64::try_from((now - last).as_nanos()).unwrap_or(u64::MAX));
        last = now;
        if now - started >= plan.window && times.len() as u64 * batch >= LEAST_INFERENCES {
            return Ok(());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts windows, and says that each took 2 J.
    #[derive(Default)]
    struct Counted(usize);

    impl Watch for Counted {
        fn begin(&mut self) {}
        fn end(&mut self) -> Option<f64> {
            self.0 += 1;
            Some(2.0)
        }
    }

    fn plan(window_ms: u64) -> Plan {
        Plan {
            warm_up: 3,
            window: Duration::from_millis(window_ms),
            windows: 2,
        }
    }

    #[test]
    fn a_window_has_a_hundred_inferences_however_short() {
        let mut calls = 0_u64;
        let mut watch = Counted::default();
        let mut work = || {
            calls += 1;
            Ok(())
        };
        let [windows] = measure(&plan(0), 1, [&mut work], &mut watch).expect("never fails");
        assert_eq!(calls, 2 * (3 + 100));
        assert_eq!(watch.0, 2);
        assert!(
            windows
                .iter()
                .all(|w| w.times.calls == 100 && w.energy_j == Some(2.0))
        );
        // Two batches of 64 are 128 inferences.
        let [windows] = measure(&plan(0), 64, [&mut || Ok(())], &mut watch).expect("never fails");
        assert!(windows.iter().all(|window| window.times.calls == 2));
    }

    #[test]
    fn a_window_is_as_long_as_asked_and_its_times_add_up_to_it() {
        let mut work = || {
            std::thread::sleep(Duration::from_micros(50));
            Ok(())
        };
        let [windows] = measure(&plan(30), 1, [&mut work], &mut Counted::default()).expect("ok");
        for Window { times, .. } in windows {
            let sum_us = times.mean_us * times.calls as f64;
            assert!(sum_us >= 30_000.0, "{sum_us}");
            assert!(times.min_us >= 50.0, "{}", times.min_us);
        }
    }

    #[test]
    fn kinds_of_work_take_turns_and_change_places() {
        let order = std::cell::RefCell::new(Vec::new());
        let work = |name| {
            let order = &order;
            move || {
                let mut order = order.borrow_mut();
                if order.last() != Some(&name) {
                    order.push(name);
                }
                Ok(())
            }
        };
        let (mut a, mut b) = (work('a'), work('b'));
        measure(&plan(0), 1, [&mut a, &mut b], &mut Counted::default()).expect("never fails");
        assert_eq!(*order.borrow(), ['a', 'b', 'a']); // a, b, then b, a
    }

    #[test]
    fn what_fails_ends_the_measurement() {
        let mut left = 50;
        let mut work = || {
            left -= 1;
            if left > 0 {
                Ok(())
            } else {
                Err(Error::Missing("a 50th call"))
            }
        };
        let failed = measure(&plan(0), 1, [&mut work], &mut Counted::default());
        assert_eq!(
            failed.expect_err("fails").to_string(),
            "expected a 50th call, found none"
        );
    }
}
