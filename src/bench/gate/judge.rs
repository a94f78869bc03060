//! The decision whether a value is within a limit, beyond it, or undecided.

use super::estimate::{BetterDirection, Estimate, FigureKind};
use super::limits::{Bound, Judge};
use serde::Serialize;

/// The outcome of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub(crate) enum GateOutcome {
    /// The value is within the limit.
    #[serde(rename = "holds")]
    Holds,
    /// Undecided: the value is too close to the limit, or other work on the machine disturbed it.
    #[serde(rename = "cannot tell")]
    CannotTell,
    /// The value is beyond the limit.
    #[serde(rename = "missed")]
    Missed,
}

impl GateOutcome {
    /// Returns the outcome in words.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::CannotTell => "cannot tell",
            Self::Missed => "missed",
        }
    }
}

/// The ratio and the difference between a value and the baseline's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BaselineChange {
    /// The value divided by the baseline's.
    pub ratio: Estimate,
    /// The value minus the baseline's.
    pub difference: Estimate,
    /// Whether both are from the same probes.
    pub is_paired: bool,
}

impl BaselineChange {
    /// Compares two values that were measured independently: each may be anywhere in its interval.
    pub(crate) fn apart(new: Estimate, old: Estimate) -> Self {
        // A ratio of values below 0 is meaningless.
        let is_told = [new, old].iter().all(|estimate| estimate.value >= 0.0);
        let ratio = |new: f64, old: f64| match is_told {
            false => f64::NAN,
            true if new == old => 1.0,
            true => new / old,
        };
        // An unknown lower end may be as low as 0.
        let low = |end: f64| end.max(0.0);
        Self {
            ratio: Estimate {
                value: ratio(new.value, old.value),
                low: ratio(low(new.low), old.high),
                high: ratio(new.high, low(old.low)),
            },
            difference: Estimate {
                value: new.value - old.value,
                low: new.low - old.high,
                high: new.high - old.low,
            },
            is_paired: false,
        }
    }
}

/// Judges a value by an absolute limit.
pub(crate) fn absolute(
    found: Estimate,
    bound: Bound,
    measure: FigureKind,
    judge: Option<Judge>,
) -> GateOutcome {
    // Rates of hits have the same seed on each run, so their value decides.
    let usual = if measure.is_timed() {
        Judge::Interval
    } else {
        Judge::Value
    };
    within(found, bound, judge.unwrap_or(usual))
}

/// Judges a value by a limit relative to a baseline.
pub(crate) fn relative(
    between: BaselineChange,
    bound: Bound,
    measure: FigureKind,
    judge: Option<Judge>,
) -> GateOutcome {
    // The separate intervals of two values with the same seed say little about their difference.
    let usual = if measure.is_timed() || between.is_paired {
        Judge::Interval
    } else {
        Judge::Value
    };
    let by = judge.unwrap_or(usual);
    match bound {
        Bound::RatioAtMost(limit) => within(between.ratio, Bound::AtMost(limit), by),
        Bound::RatioAtLeast(limit) => within(between.ratio, Bound::AtLeast(limit), by),
        Bound::DifferenceAtMost(limit) => within(between.difference, Bound::AtMost(limit), by),
        Bound::DifferenceAtLeast(limit) => within(between.difference, Bound::AtLeast(limit), by),
        Bound::NotWorse => not_worse(
            between.difference,
            measure.better(),
            judge.unwrap_or(Judge::Interval),
        ),
        absolute => within(between.difference, absolute, by),
    }
}

fn within(found: Estimate, bound: Bound, judge: Judge) -> GateOutcome {
    let (value, low, high, limit) = match bound {
        Bound::AtLeast(limit) => (-found.value, -found.high, -found.low, -limit),
        Bound::AtMost(limit) => (found.value, found.low, found.high, limit),
        _ => (f64::NAN, f64::NAN, f64::NAN, 0.0),
    };
    let (low, high) = match judge {
        Judge::Value => (value, value),
        Judge::Interval => (low, high),
    };
    if high <= limit {
        GateOutcome::Holds
    } else if low > limit {
        GateOutcome::Missed
    } else {
        GateOutcome::CannotTell
    }
}

/// Judges a difference by `not_worse`. A value that is not worse holds, and one that is worse
/// beyond the interval is missed. It is undecided if it is worse within the interval, or not worse
/// than a value that may really be better.
fn not_worse(difference: Estimate, better: Option<BetterDirection>, judge: Judge) -> GateOutcome {
    let Estimate { value, low, high } = difference;
    // How much worse the value is.
    let (value, low, high) = match better {
        Some(BetterDirection::More) => (-value, -high, -low),
        _ => (value, low, high),
    };
    let (low, high) = match judge {
        Judge::Value => (value, value),
        Judge::Interval => (low, high),
    };
    if low > 0.0 {
        GateOutcome::Missed
    } else if value <= 0.0 && high < f64::INFINITY {
        GateOutcome::Holds
    } else {
        GateOutcome::CannotTell
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use GateOutcome::{CannotTell, Holds, Missed};

    const TIME: FigureKind = FigureKind::Time;

    fn about(value: f64, by: f64) -> Estimate {
        Estimate {
            value,
            low: value - by,
            high: value + by,
        }
    }

    #[test]
    fn an_interval_on_both_sides_of_a_limit_cannot_tell() {
        let time = |limit| absolute(about(10.0, 1.0), Bound::AtMost(limit), TIME, None);
        assert_eq!(
            [time(11.0), time(10.5), time(8.9)],
            [Holds, CannotTell, Missed]
        );
        let rate = |limit| {
            absolute(
                about(10.0, 1.0),
                Bound::AtLeast(limit),
                FigureKind::Rate,
                None,
            )
        };
        assert_eq!(
            [rate(9.0), rate(9.5), rate(11.1)],
            [Holds, CannotTell, Missed]
        );
        let hits = FigureKind::from_key("rank1");
        let hit = |judge| absolute(about(0.5, 0.1), Bound::AtLeast(0.45), hits, judge);
        assert_eq!(hit(None), Holds);
        assert_eq!(hit(Some(Judge::Interval)), CannotTell);
        let nan = absolute(Estimate::exact(f64::NAN), Bound::AtMost(1.0), hits, None);
        assert_eq!(nan, CannotTell, "which the command refuses before");
    }

    #[test]
    fn a_busy_machine_spoils_a_miss_and_no_pass() {
        let new = about(10.0, 1.0).disturbed(TIME);
        let time = |limit| absolute(new, Bound::AtMost(limit), TIME, None);
        assert_eq!([time(11.0), time(5.0)], [Holds, CannotTell]);
        let ratio = |new, old, limit| {
            relative(
                BaselineChange::apart(new, old),
                Bound::RatioAtMost(limit),
                TIME,
                None,
            )
        };
        let quiet = about(10.0, 0.0);
        assert_eq!(ratio(quiet, quiet, 1.0), Holds);
        // As fast as a baseline that was measured too slow.
        assert_eq!(ratio(quiet, quiet.disturbed(TIME), 1.5), CannotTell);
        // Twice as slow as a baseline that was measured too slow.
        assert_eq!(ratio(about(20.0, 0.0), quiet.disturbed(TIME), 1.5), Missed);
        assert_eq!(
            ratio(about(20.0, 0.0).disturbed(TIME), quiet, 1.5),
            CannotTell
        );
    }

    #[test]
    fn not_worse_is_missed_beyond_the_interval_alone() {
        let rank1 = FigureKind::from_key("rank1");
        let of = |value: f64, by: f64, measure, judge, is_paired| {
            let difference = about(value, by);
            let between = BaselineChange {
                ratio: Estimate::exact(f64::NAN),
                difference,
                is_paired,
            };
            relative(between, Bound::NotWorse, measure, judge)
        };
        assert_eq!(of(-0.1, 0.05, rank1, None, true), Missed);
        assert_eq!(of(-0.1, 0.15, rank1, None, true), CannotTell);
        assert_eq!(of(0.1, 0.05, rank1, None, true), Holds);
        assert_eq!(of(-0.1, 0.15, rank1, Some(Judge::Value), true), Missed);
        assert_eq!(of(1.0, 0.5, TIME, None, false), Missed);
        assert_eq!(of(-1.0, 0.5, TIME, None, false), Holds);
        let apart =
            |new, old| relative(BaselineChange::apart(new, old), Bound::NotWorse, TIME, None);
        let (fast, slow) = (about(1.0, 0.1), about(2.0, 0.1));
        assert_eq!(apart(slow, fast), Missed);
        assert_eq!(apart(slow.disturbed(TIME), fast), CannotTell);
        assert_eq!(apart(fast.disturbed(TIME), slow), Holds);
        assert_eq!(apart(fast, slow.disturbed(TIME)), CannotTell);
    }

    #[test]
    fn differences_and_ratios_have_limits_on_either_side() {
        let between = BaselineChange::apart(about(12.0, 0.0), about(10.0, 0.0));
        for (bound, outcome) in [
            (Bound::RatioAtMost(1.2), Holds),
            (Bound::RatioAtMost(1.1), Missed),
            (Bound::RatioAtLeast(1.1), Holds),
            (Bound::RatioAtLeast(1.3), Missed),
            (Bound::DifferenceAtMost(2.0), Holds),
            (Bound::DifferenceAtMost(1.0), Missed),
            (Bound::DifferenceAtLeast(2.0), Holds),
            (Bound::DifferenceAtLeast(2.5), Missed),
        ] {
            let found = relative(between, bound, FigureKind::from_key("bytes"), None);
            assert_eq!(found, outcome, "{bound}");
        }
        // A ratio of values below 0 is meaningless.
        for both in [(0.5, -0.01), (-0.5, 0.01), (-2.0, -1.0)] {
            let below = BaselineChange::apart(Estimate::exact(both.0), Estimate::exact(both.1));
            let spread = FigureKind::from_key("spread");
            let found = relative(below, Bound::RatioAtMost(1.2), spread, None);
            assert_eq!(found, CannotTell);
        }
        let nothing = BaselineChange::apart(Estimate::exact(0.0), Estimate::exact(0.0));
        assert_eq!(nothing.ratio, Estimate::exact(1.0));
    }
}
