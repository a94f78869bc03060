//! Rank-1: whether the best match is the right person.

use super::wilson::{Interval, wilson_95};

/// The outcome of one probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbeOutcome {
    /// The best match is the right person.
    Hit,
    /// The best match is another person.
    Miss,
    /// The recognizer gave a number that is not finite: a miss that is also counted separately.
    NonFinite,
}

impl ProbeOutcome {
    const fn from_hit(is_right: bool) -> Self {
        if is_right { Self::Hit } else { Self::Miss }
    }
}

/// Counts of outcomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// All probes.
    pub probes: u64,
    /// The hits among them.
    pub hits: u64,
    /// The misses among them whose output was not finite.
    pub non_finite: u64,
}

impl Tally {
    /// Counts one more probe.
    pub const fn add(&mut self, outcome: ProbeOutcome) {
        self.probes += 1;
        match outcome {
            ProbeOutcome::Hit => self.hits += 1,
            ProbeOutcome::Miss => {}
            ProbeOutcome::NonFinite => self.non_finite += 1,
        }
    }

    /// Returns the rate of hits, 0..1; none without probes.
    #[must_use]
    pub fn rank1(&self) -> Option<f64> {
        (self.probes > 0).then(|| self.hits as f64 / self.probes as f64)
    }

    /// Returns Wilson's 95 % interval of the rate.
    #[must_use]
    pub fn interval(&self) -> Interval {
        wilson_95(self.hits, self.probes)
    }
}

impl std::ops::AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.probes += other.probes;
        self.hits += other.hits;
        self.non_finite += other.non_finite;
    }
}

impl std::ops::AddAssign<&Self> for Tally {
    fn add_assign(&mut self, other: &Self) {
        *self += *other;
    }
}

impl std::iter::Sum for Tally {
    fn sum<I: Iterator<Item = Self>>(tallies: I) -> Self {
        let mut sum = Self::default();
        for tally in tallies {
            sum += tally;
        }
        sum
    }
}

impl FromIterator<ProbeOutcome> for Tally {
    fn from_iter<I: IntoIterator<Item = ProbeOutcome>>(outcomes: I) -> Self {
        let mut tally = Self::default();
        for outcome in outcomes {
            tally.add(outcome);
        }
        tally
    }
}

/// Returns the outcome in a closed set by class score: a hit if class `truth` has the highest
/// score.
///
/// Ties go to the lowest index, so that a recognizer with constant answers hits one class only.
/// A row with a number that is not finite is [`ProbeOutcome::NonFinite`]; a `truth` beyond the row
/// is a miss.
#[must_use]
pub(crate) fn closed_set(scores: &[f32], truth: usize) -> ProbeOutcome {
    if scores.iter().any(|score| !score.is_finite()) {
        return ProbeOutcome::NonFinite;
    }
    let mut best: Option<(usize, f32)> = None;
    for (class, &score) in scores.iter().enumerate() {
        if best.is_none_or(|(_, highest)| score > highest) {
            best = Some((class, score));
        }
    }
    ProbeOutcome::from_hit(best.is_some_and(|(class, _)| class == truth))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_score_decides_and_the_lowest_index_wins_a_tie() {
        assert_eq!(closed_set(&[0.1, 0.7, 0.2], 1), ProbeOutcome::Hit);
        assert_eq!(closed_set(&[0.1, 0.7, 0.2], 2), ProbeOutcome::Miss);
        assert_eq!(closed_set(&[0.5, 0.5], 0), ProbeOutcome::Hit);
        assert_eq!(closed_set(&[0.5, 0.5], 1), ProbeOutcome::Miss);
        assert_eq!(closed_set(&[-3.0, -2.0], 1), ProbeOutcome::Hit);
        assert_eq!(closed_set(&[], 0), ProbeOutcome::Miss);
        assert_eq!(closed_set(&[1.0], 5), ProbeOutcome::Miss);
    }

    #[test]
    fn numbers_that_are_not_finite_are_misses_counted_apart() {
        let rows = [
            [f32::NAN, 1.0],
            [0.0, f32::INFINITY],
            [0.0, 1.0],
            [1.0, 0.0],
        ];
        let tally: Tally = rows.iter().map(|row| closed_set(row, 1)).collect();
        assert_eq!(
            tally,
            Tally {
                probes: 4,
                hits: 1,
                non_finite: 2
            }
        );
        assert_eq!(tally.rank1(), Some(0.25));
        assert_eq!(Tally::default().rank1(), None);
    }
}
