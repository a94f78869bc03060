//! The intervals of Rank-1 in results.

use serde::{Deserialize, Serialize};

use super::bootstrap::rank1_95;
use super::rank1::Tally;

/// The two 95 % intervals of a Rank-1.
///
/// A person's probes are correlated, so Wilson's interval, which takes probes as independent, is
/// too narrow. The interval that resamples people therefore has the plain names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rank1Intervals {
    /// Lower end of the interval that resamples people, 0..1; none with fewer than two people.
    pub rank1_low: Option<f64>,
    /// Upper end of the interval that resamples people.
    pub rank1_high: Option<f64>,
    /// Lower end of Wilson's interval, probes taken as independent, 0..1.
    pub rank1_wilson_low: f64,
    /// Upper end of Wilson's interval.
    pub rank1_wilson_high: f64,
}

impl Rank1Intervals {
    /// Returns the intervals from counts by person; `seed` is the seed for resampling people.
    #[must_use]
    pub fn from_tallies(people: &[Tally], seed: u64) -> Self {
        let wilson = people.iter().copied().sum::<Tally>().interval();
        let drawn = rank1_95(people, seed);
        Self {
            rank1_low: drawn.map(|drawn| drawn.low),
            rank1_high: drawn.map(|drawn| drawn.high),
            rank1_wilson_low: wilson.low,
            rank1_wilson_high: wilson.high,
        }
    }

    /// Returns the interval that resamples people, (low, high).
    #[must_use]
    pub fn over_people(&self) -> Option<(f64, f64)> {
        self.rank1_low.zip(self.rank1_high)
    }

    /// Returns the interval to show: over people or, where there is none, Wilson's.
    #[must_use]
    pub fn shown(&self) -> (f64, f64) {
        let wilson = (self.rank1_wilson_low, self.rank1_wilson_high);
        self.over_people().unwrap_or(wilson)
    }
}
