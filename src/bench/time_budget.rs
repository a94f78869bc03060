//! Sharing a model's measuring time among its kinds of work.
//!
//! What a linear model finishes in half a minute would take hours with a network that needs a
//! second an inference. After the first inference the duration of all work can be estimated. What
//! does not fit the time is cut, and each result states that.

use super::process::MeasuringProgress;
use std::time::{Duration, Instant};

/// A kind of work that has not begun.
#[derive(Clone, Debug)]
pub(super) struct WorkKind {
    /// The work's name in progress reports.
    pub what: String,
    /// The estimated time of the full work, seconds.
    pub full_s: f64,
    /// The weight of the work in sharing the time.
    pub weight: f64,
}

/// The time for one kind of work.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeShare {
    /// The time in seconds; infinite if there is no limit.
    pub most_s: f64,
    /// The end of that time.
    pub until: Option<Instant>,
}

impl TimeShare {
    /// Returns the seconds that remain.
    #[must_use]
    pub(super) fn left_s(&self) -> f64 {
        self.until.map_or(self.most_s, |until| {
            until
                .saturating_duration_since(Instant::now())
                .as_secs_f64()
        })
    }
}

/// The remaining time, and the work that shares it.
pub(super) struct Cap<'a> {
    started: Instant,
    until: Option<Instant>,
    to_come: Vec<WorkKind>,
    tell: &'a (dyn Fn(&MeasuringProgress) + Sync),
    /// The current work, and the estimated end of all work.
    now: (String, Instant),
    /// The time that all work so far would have taken in full, seconds.
    full_s: f64,
}

impl<'a> Cap<'a> {
    /// Starts a time limit of `most` for these kinds of work in turn; `tell` is called with the
    /// current work and the remaining time.
    #[must_use]
    pub(super) fn new(
        most: Option<Duration>,
        to_come: Vec<WorkKind>,
        tell: &'a (dyn Fn(&MeasuringProgress) + Sync),
    ) -> Self {
        let started = Instant::now();
        Self {
            started,
            until: most.and_then(|most| started.checked_add(most)),
            to_come,
            tell,
            now: (String::new(), started),
            full_s: 0.0,
        }
    }

    /// Begins the next kind of work, which would take `full_s` in full. It gets its weighted share
    /// of the remaining time, or what the later work does not need, whichever is more.
    pub(super) fn begin(&mut self, full_s: f64) -> TimeShare {
        let kind = WorkKind {
            full_s,
            ..self.to_come.remove(0)
        };
        self.full_s += full_s;
        let now = Instant::now();
        let later_s: f64 = self.to_come.iter().map(|kind| kind.full_s).sum();
        let weights: f64 = self.to_come.iter().map(|kind| kind.weight).sum();
        let left_s = self.left_s();
        let most_s = most_of(left_s, kind.weight / (kind.weight + weights), later_s);
        let over = Duration::try_from_secs_f64((full_s + later_s).min(left_s));
        self.now = (kind.what, now + over.unwrap_or_default());
        self.tell();
        TimeShare {
            most_s,
            until: self
                .until
                .and_then(|_| now.checked_add(Duration::try_from_secs_f64(most_s).ok()?)),
        }
    }

    /// Updates the estimated full times of the remaining work, in order.
    pub(super) fn expect(&mut self, full_s: &[f64]) {
        for (kind, &full_s) in self.to_come.iter_mut().zip(full_s) {
            kind.full_s = full_s;
        }
    }

    /// Reports the current work and the remaining time.
    pub(super) fn tell(&self) {
        let (what, over) = &self.now;
        (self.tell)(&MeasuringProgress {
            what: what.clone(),
            left_s: over.saturating_duration_since(Instant::now()).as_secs_f64(),
        });
    }

    /// Returns the seconds that remain; infinite if there is no limit.
    #[must_use]
    pub(super) fn left_s(&self) -> f64 {
        self.until.map_or(f64::INFINITY, |until| {
            until
                .saturating_duration_since(Instant::now())
                .as_secs_f64()
        })
    }

    /// Returns the seconds since the start.
    #[must_use]
    pub(super) fn taken_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Returns the estimated seconds that all work so far would have taken without a limit.
    #[must_use]
    pub(super) const fn full_s(&self) -> f64 {
        self.full_s
    }
}

/// Returns how many of `left_s` seconds a kind of work may take: its share, or what the later work
/// leaves, whichever is more.
fn most_of(left_s: f64, share: f64, later_s: f64) -> f64 {
    (left_s * share).max(left_s - later_s).max(0.0)
}

/// The fewest calls for which a batch is measured: one warm-up call and three timed ones.
pub(super) const LEAST_BATCHES: f64 = 4.0;

/// Returns the largest batch size, `asked` or a power of two below it, whose [`LEAST_BATCHES`]
/// calls fit the time at `call_s` an inference; none below two.
#[must_use]
pub(super) fn batch_within(most_s: f64, call_s: f64, asked: usize) -> Option<usize> {
    largest(asked, |size| LEAST_BATCHES * size as f64 * call_s <= most_s)
}

/// Returns the largest size that fits, `asked` or a power of two below it, down to two.
pub(super) fn largest(asked: usize, fits: impl Fn(usize) -> bool) -> Option<usize> {
    let powers = std::iter::successors(Some(1_usize), |size| size.checked_mul(2));
    let below: Vec<usize> = powers.skip(1).take_while(|&size| size < asked).collect();
    let mut sizes = std::iter::once(asked).chain(below.into_iter().rev());
    sizes.find(|&size| fits(size))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(of: &[(f64, f64)]) -> Vec<WorkKind> {
        let kind = |&(full_s, weight)| WorkKind {
            what: "work".to_owned(),
            full_s,
            weight,
        };
        of.iter().map(kind).collect()
    }

    #[test]
    fn each_kind_takes_its_share_or_what_the_others_leave() {
        // 100 s for work of 500, 300 and 10 s: half, which is more than 100 - 310.
        assert_eq!(most_of(100.0, 0.5, 310.0), 50.0);
        // The others need only 30 s.
        assert_eq!(most_of(100.0, 0.5, 30.0), 70.0);
        assert_eq!(most_of(0.0, 0.5, 30.0), 0.0);
        assert_eq!(most_of(f64::INFINITY, 0.1, 30.0), f64::INFINITY);

        let quiet = |_: &MeasuringProgress| {};
        let most = Some(Duration::from_secs(100));
        let mut cap = Cap::new(most, kinds(&[(1.0, 3.0), (1.0, 1.0), (1.0, 1.0)]), &quiet);
        cap.expect(&[0.0, 500.0, 500.0]);
        let first = cap.begin(500.0);
        assert!((first.most_s - 60.0).abs() < 1.0, "{first:?}");
        assert!(first.until.is_some());
        // Nothing was used yet, and the last needs 20 s.
        cap.expect(&[500.0, 20.0]);
        assert!((cap.begin(500.0).most_s - 80.0).abs() < 1.0);
        cap.begin(20.0);
        assert_eq!(cap.full_s(), 1020.0);

        let mut free = Cap::new(None, kinds(&[(1.0, 1.0)]), &quiet);
        let share = free.begin(1e9);
        assert_eq!((share.most_s, share.until), (f64::INFINITY, None));
    }

    #[test]
    fn progress_states_the_remaining_time_within_the_limit() {
        let told = std::sync::Mutex::new(Vec::new());
        let tell =
            |one: &MeasuringProgress| told.lock().expect("no panic").push(one.left_s.round());
        let to_come = kinds(&[(1.0, 1.0), (200.0, 1.0)]);
        let _ = Cap::new(Some(Duration::from_secs(90)), to_come.clone(), &tell).begin(100.0);
        let _ = Cap::new(None, to_come, &tell).begin(100.0);
        assert_eq!(*told.lock().expect("no panic"), [90.0, 300.0]);
    }

    #[test]
    fn a_batch_is_as_large_as_four_calls_in_the_time_allow() {
        assert_eq!(batch_within(10.0, 0.001, 64), Some(64));
        assert_eq!(batch_within(10.0, 0.001, 3), Some(3));
        // Four of 32 take 12.8 s, of 16 half as long.
        assert_eq!(batch_within(10.0, 0.1, 48), Some(16));
        assert_eq!(batch_within(10.0, 1.0, 64), Some(2));
        assert_eq!(batch_within(7.9, 1.0, 64), None);
        assert_eq!(batch_within(1e9, 1.0, 1), Some(1));
    }
}
