//! How the time that the measuring of a model may take is shared by its kinds of work.
//!
//! A network of a second an inference would take hours for what a linear model does in half a minute.
//! What is to be done is known ahead, from the first inference on: what would take longer than there
//! is time for is cut, and each result states it.

use super::process::MeasuringProgress;
use std::time::{Duration, Instant};

/// A kind of work that is still to come.
#[derive(Clone, Debug)]
pub(super) struct WorkKind {
    /// What progress calls it.
    pub what: String,
    /// How long all of it would take, seconds, as far as that is known.
    pub full_s: f64,
    /// Its share of the time, as against those of the others.
    pub weight: f64,
}

/// What one kind of work may take.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeShare {
    /// Seconds, without end if there is no cap.
    pub most_s: f64,
    /// When they are over.
    pub until: Option<Instant>,
}

impl TimeShare {
    /// Seconds that are left of it.
    #[must_use]
    pub(super) fn left_s(&self) -> f64 {
        self.until.map_or(self.most_s, |until| {
            until
                .saturating_duration_since(Instant::now())
                .as_secs_f64()
        })
    }
}

/// The time that is left, and what it is for.
pub(super) struct Cap<'a> {
    started: Instant,
    until: Option<Instant>,
    to_come: Vec<WorkKind>,
    tell: &'a (dyn Fn(&MeasuringProgress) + Sync),
    /// What is being done, and when all will be over.
    now: (String, Instant),
    /// How long all of what has begun would have taken in full, seconds.
    full_s: f64,
}

impl<'a> Cap<'a> {
    /// From now on at most so long, for these kinds of work one after another; `tell` is told what is
    /// done and how long the rest takes.
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

    /// Begins the next kind of work, of which all would take `full_s`: it may take what the others do
    /// not need, or what its weight gives it of the time that is left, whichever is more.
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

    /// How long those that are still to come would take in full, in their order, is known better now.
    pub(super) fn expect(&mut self, full_s: &[f64]) {
        for (kind, &full_s) in self.to_come.iter_mut().zip(full_s) {
            kind.full_s = full_s;
        }
    }

    /// Says what is being done, and how long the rest takes.
    pub(super) fn tell(&self) {
        let (what, over) = &self.now;
        (self.tell)(&MeasuringProgress {
            what: what.clone(),
            left_s: over.saturating_duration_since(Instant::now()).as_secs_f64(),
        });
    }

    /// Seconds that are left, without end if there is no cap.
    #[must_use]
    pub(super) fn left_s(&self) -> f64 {
        self.until.map_or(f64::INFINITY, |until| {
            until
                .saturating_duration_since(Instant::now())
                .as_secs_f64()
        })
    }

    /// Seconds since it began.
    #[must_use]
    pub(super) fn taken_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Seconds that all that has begun would have taken without a cap, as far as that is known.
    #[must_use]
    pub(super) const fn full_s(&self) -> f64 {
        self.full_s
    }
}

/// The most that a kind of work may take of `left_s` seconds: its share of them, or what those after it
/// leave.
fn most_of(left_s: f64, share: f64, later_s: f64) -> f64 {
    (left_s * share).max(left_s - later_s).max(0.0)
}

/// Fewest calls of a batch that are worth their time: one to warm up, three that are timed.
pub(super) const LEAST_BATCHES: f64 = 4.0;

/// The largest size of a batch that is `asked` or a power of two below it, and whose
/// [`LEAST_BATCHES`] fit the time, at `call_s` an inference; below two there is none.
#[must_use]
pub(super) fn batch_within(most_s: f64, call_s: f64, asked: usize) -> Option<usize> {
    largest(asked, |size| LEAST_BATCHES * size as f64 * call_s <= most_s)
}

/// The largest that fits of `asked` and the powers of two below it, down to two.
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
        // 100 s for work of 500, 300 and 10 s: half of them, which is more than 100 - 310.
        assert_eq!(most_of(100.0, 0.5, 310.0), 50.0);
        // Others need 30 s only.
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
    fn what_is_told_is_how_long_the_rest_takes_within_the_cap() {
        let told = std::sync::Mutex::new(Vec::new());
        let tell =
            |one: &MeasuringProgress| told.lock().expect("no panic").push(one.left_s.round());
        let to_come = kinds(&[(1.0, 1.0), (200.0, 1.0)]);
        let _ = Cap::new(Some(Duration::from_secs(90)), to_come.clone(), &tell).begin(100.0);
        let _ = Cap::new(None, to_come, &tell).begin(100.0);
        assert_eq!(*told.lock().expect("no panic"), [90.0, 300.0]);
    }

    #[test]
    fn a_batch_is_as_large_as_four_of_it_fit_the_time() {
        assert_eq!(batch_within(10.0, 0.001, 64), Some(64));
        assert_eq!(batch_within(10.0, 0.001, 3), Some(3));
        // Four of 32 take 12.8 s, of 16 half as long.
        assert_eq!(batch_within(10.0, 0.1, 48), Some(16));
        assert_eq!(batch_within(10.0, 1.0, 64), Some(2));
        assert_eq!(batch_within(7.9, 1.0, 64), None);
        assert_eq!(batch_within(1e9, 1.0, 1), Some(1));
    }
}
