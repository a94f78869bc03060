//! The duration of measurements: warm-up, and windows of many calls.

use super::statistics::Times;
use crate::error::{Error, Result};
use std::time::{Duration, Instant};

/// The fewest inferences in a window: enough for a 99th percentile, as benchmarks of gait
/// recognition on edge devices suggest.
pub(crate) const LEAST_INFERENCES: u64 = 100;

/// The duration of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TimingPlan {
    /// The number of untimed calls before each window.
    pub warm_up: u32,
    /// The minimum length of a window.
    pub window: Duration,
    /// The minimum number of inferences in a window; at least one.
    pub inferences: u64,
    /// The number of windows; at least one.
    pub windows: u32,
}

impl TimingPlan {
    /// The default: ten warm-up calls, five windows of 1 s.
    pub(crate) const DEFAULT: Self = Self {
        warm_up: 10,
        window: Duration::from_secs(1),
        inferences: LEAST_INFERENCES,
        windows: 5,
    };
    /// The performance script of MLPerf Tiny 1.2: the median of five windows, here of at least 10 s
    /// each, and 10 warm-up calls before each, the most of any of its tasks.
    pub(crate) const MLPERF: Self = Self {
        warm_up: 10,
        window: Duration::from_secs(10),
        inferences: LEAST_INFERENCES,
        windows: 5,
    };

    /// Returns the duration of the plan, seconds, if a call of `batch` inferences takes `call_s`.
    #[must_use]
    pub(crate) fn takes_s(&self, call_s: f64, batch: usize) -> f64 {
        let calls = self.inferences.div_ceil(batch.max(1) as u64) as f64;
        let timed = self.window.as_secs_f64().max(calls * call_s);
        f64::from(self.windows) * (f64::from(self.warm_up) * call_s + timed)
    }

    /// Returns the plan, shortened to fit `most_s` seconds: as many windows as have ten calls each
    /// (a 90th percentile needs ten), at least one; one warm-up call for every ten calls of a
    /// window; and the rest of the time for timed calls, at least one.
    #[must_use]
    pub(crate) fn within(&self, most_s: f64, call_s: f64, batch: usize) -> Self {
        if self.takes_s(call_s, batch) <= most_s {
            return *self;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates; fewer than windows that are asked for, or calls of an hour"
        )]
        let whole = |count: f64| count as u64;
        let calls = whole(most_s / call_s);
        let windows = (calls / CALLS_FOR_P90).clamp(1, u64::from(self.windows));
        let each_s = most_s.max(0.0) / windows as f64;
        let calls = whole(each_s / call_s).max(1);
        let warm_up = u64::from(self.warm_up).min(calls / CALLS_FOR_P90);
        let timed = (calls - warm_up).max(1);
        let timed_s = each_s - warm_up as f64 * call_s;
        Self {
            warm_up: u32::try_from(warm_up).unwrap_or(self.warm_up),
            window: self
                .window
                .min(Duration::try_from_secs_f64(timed_s).unwrap_or_default()),
            inferences: self.inferences.min(timed.saturating_mul(batch as u64)),
            windows: u32::try_from(windows).unwrap_or(self.windows),
        }
    }
}

/// The fewest calls in a window that have a 90th percentile.
const CALLS_FOR_P90: u64 = 10;

/// The call that is timed.
pub(crate) type TimedCall<'w> = &'w mut dyn FnMut() -> Result<()>;

/// The measurements of one window.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeasuredWindow {
    /// The times of the calls.
    pub times: Times,
    /// Energy in joules, where it was metered.
    pub energy_j: Option<f64>,
}

/// An observer that is called when a window begins and ends, outside the timed part.
pub(crate) trait Watch {
    /// Called when a window begins.
    ///
    /// # Errors
    /// If the observer cannot start.
    fn begin(&mut self) -> Result<()>;
    /// Called when a window has ended; returns its energy in joules, if metered.
    fn end(&mut self) -> Option<f64>;
}

/// Measures calls of `batch` inferences each and returns the windows of each kind of work. Several
/// kinds of work alternate, window by window, in an order that reverses each round, so that what
/// slows the machine slows all of them.
///
/// A call's time starts at the end of the previous call, so that the times of a window add up to
/// its length, and each call reads the clock only once.
///
/// After the moment `until`, each window ends with its current call, at least its first, and no
/// further round begins.
///
/// # Errors
/// If a call fails.
pub(crate) fn measure<const N: usize>(
    plan: &TimingPlan,
    until: Option<Instant>,
    batch: usize,
    works: [TimedCall<'_>; N],
    watch: &mut dyn Watch,
) -> Result<[Vec<MeasuredWindow>; N]> {
    let mut all = [const { Vec::new() }; N];
    let mut times = Vec::new();
    let is_over = || until.is_some_and(|until| Instant::now() >= until);
    for round in 0..plan.windows {
        if round > 0 && is_over() {
            break;
        }
        for turn in 0..N {
            let at = if round % 2 == 0 { turn } else { N - 1 - turn };
            for _ in 0..plan.warm_up {
                if is_over() {
                    break;
                }
                works[at]()?;
            }
            watch.begin()?;
            window(plan, until, batch as u64, works[at], &mut times)?;
            let energy_j = watch.end();
            let times =
                Times::from_samples(&mut times).ok_or(Error::Missing("a call in each window"))?;
            all[at].push(MeasuredWindow { times, energy_j });
        }
    }
    Ok(all)
}

fn window(
    plan: &TimingPlan,
    until: Option<Instant>,
    batch: u64,
    work: TimedCall<'_>,
    times: &mut Vec<u64>,
) -> Result<()> {
    times.clear();
    let started = Instant::now();
    let mut last = started;
    loop {
        work()?;
        let now = Instant::now();
        times.push(u64::try_from((now - last).as_nanos()).unwrap_or(u64::MAX));
        last = now;
        let is_whole =
            now - started >= plan.window && times.len() as u64 * batch >= plan.inferences;
        if is_whole || until.is_some_and(|until| now >= until) {
            return Ok(());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts windows, and reports 2 J for each.
    #[derive(Default)]
    struct Counted(usize);

    impl Watch for Counted {
        fn begin(&mut self) -> Result<()> {
            Ok(())
        }
        fn end(&mut self) -> Option<f64> {
            self.0 += 1;
            Some(2.0)
        }
    }

    fn plan(window_ms: u64) -> TimingPlan {
        TimingPlan {
            warm_up: 3,
            window: Duration::from_millis(window_ms),
            inferences: LEAST_INFERENCES,
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
        let [windows] = measure(&plan(0), None, 1, [&mut work], &mut watch).expect("never fails");
        assert_eq!(calls, 2 * (3 + 100));
        assert_eq!(watch.0, 2);
        assert!(
            windows
                .iter()
                .all(|w| w.times.calls == 100 && w.energy_j == Some(2.0))
        );
        // Two batches of 64 are 128 inferences.
        let [windows] =
            measure(&plan(0), None, 64, [&mut || Ok(())], &mut watch).expect("never fails");
        assert!(windows.iter().all(|window| window.times.calls == 2));
    }

    #[test]
    fn a_window_is_as_long_as_asked_and_its_times_add_up_to_it() {
        let mut work = || {
            std::thread::sleep(Duration::from_micros(50));
            Ok(())
        };
        let [windows] =
            measure(&plan(30), None, 1, [&mut work], &mut Counted::default()).expect("ok");
        for MeasuredWindow { times, .. } in windows {
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
        measure(&plan(0), None, 1, [&mut a, &mut b], &mut Counted::default()).expect("never fails");
        assert_eq!(*order.borrow(), ['a', 'b', 'a']); // a, b, then b, a
    }

    #[test]
    fn a_plan_takes_its_windows_or_its_inferences_whichever_is_longer() {
        // Five windows of 1 s, each after 10 calls of 1 ms.
        assert!((TimingPlan::DEFAULT.takes_s(1e-3, 1) - 5.05).abs() < 1e-9);
        // Five of 100 inferences of 2 s, each after 10.
        assert!((TimingPlan::DEFAULT.takes_s(2.0, 1) - 5.0 * 110.0 * 2.0).abs() < 1e-9);
        // Five of two batches of 64 that take 128 s, each after 10.
        assert!((TimingPlan::DEFAULT.takes_s(128.0, 64) - 5.0 * 12.0 * 128.0).abs() < 1e-9);
    }

    #[test]
    fn a_plan_that_takes_too_long_is_cut_and_others_are_not() {
        let cut = |most_s, call_s, batch| {
            let plan = TimingPlan::DEFAULT.within(most_s, call_s, batch);
            (plan.windows, plan.inferences, plan.warm_up)
        };
        assert_eq!(
            TimingPlan::DEFAULT.within(5.06, 1e-3, 1),
            TimingPlan::DEFAULT
        );
        assert_eq!(
            TimingPlan::DEFAULT.within(f64::INFINITY, 2.0, 1),
            TimingPlan::DEFAULT
        );
        // 7 calls: one window, none to spare for a warm-up.
        assert_eq!(cut(15.0, 2.0, 1), (1, 7, 0));
        // 35 calls: three windows of 11, of which one warms up.
        assert_eq!(cut(35.0, 1.0, 1), (3, 10, 1));
        // 250 calls: five of 50, of which five warm up.
        assert_eq!(cut(250.0, 1.0, 1), (5, 45, 5));
        // 12 batches of 8.
        assert_eq!(cut(12.0, 1.0, 8), (1, 88, 1));
        // No time for one call: one is made.
        assert_eq!(cut(1.0, 2.0, 1), (1, 1, 0));
        assert_eq!(cut(0.0, 2.0, 4), (1, 4, 0));
        // Short calls have shorter windows, with as many inferences.
        let short = TimingPlan::DEFAULT.within(3.0, 1e-3, 1);
        assert_eq!(
            (short.windows, short.inferences, short.warm_up),
            (5, 100, 10)
        );
        assert!((short.window.as_secs_f64() - 0.59).abs() < 1e-9);
        // A shortened plan takes no longer than allowed.
        for call_s in [1e-3, 0.01, 0.1, 0.3, 1.0, 3.0] {
            for most_s in [3.0_f64, 10.0, 33.0, 150.0] {
                let plan = TimingPlan::DEFAULT.within(most_s, call_s, 1);
                let takes_s = plan.takes_s(call_s, 1);
                assert!(takes_s <= most_s.max(call_s) + 1e-6, "{call_s} {most_s}");
                assert!(
                    takes_s > 0.5 * most_s || plan == TimingPlan::DEFAULT,
                    "{call_s} {most_s}"
                );
            }
        }
    }

    #[test]
    fn after_its_time_a_window_ends_with_its_current_call() {
        let calls = std::cell::Cell::new(0);
        let mut a = || {
            calls.set(calls.get() + 1);
            Ok(())
        };
        let mut b = || Ok(());
        let over = Some(Instant::now());
        let works: [TimedCall<'_>; 2] = [&mut a, &mut b];
        let both = measure(&plan(1000), over, 1, works, &mut Counted::default());
        // Each kind of work has one window of one call, and no warm-up.
        for windows in both.expect("never fails") {
            assert_eq!((windows.len(), windows[0].times.calls), (1, 1));
        }
        assert_eq!(calls.get(), 1);
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
        let failed = measure(&plan(0), None, 1, [&mut work], &mut Counted::default());
        assert_eq!(
            failed.expect_err("fails").to_string(),
            "expected a 50th call, found none"
        );
    }
}
