//! Estimates: a value of results with its interval.

use super::figure::ResultFigure;
use crate::bench::board::LOAD_WARNED_OF;
use crate::evaluate::median::median_interval;
use crate::evaluate::wilson::Interval;
use serde::Serialize;
use serde_json::Value;

/// The number of runs from which the interval of a median is used: the least and the greatest of
/// five contain it with 94 %.
const ENOUGH_RUNS: usize = 5;

/// A number and its interval; both ends are the value where nothing varies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Estimate {
    /// The value: the median where there are several runs.
    pub value: f64,
    /// The lower end; none in JSON if it is unknown.
    #[serde(serialize_with = "finite")]
    pub low: f64,
    /// The upper end; none in JSON if it is unknown.
    #[serde(serialize_with = "finite")]
    pub high: f64,
}

fn finite<S: serde::Serializer>(end: &f64, to: S) -> Result<S::Ok, S::Error> {
    end.is_finite().then_some(*end).serialize(to)
}

/// The kind of a value, derived from its key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FigureKind {
    /// A time: less is better, and other work on the machine increases it.
    Time,
    /// Work per time: more is better, and other work on the machine decreases it.
    Rate,
    /// A value that is (nearly) the same on each run, such as bytes or accuracy, and which
    /// direction is better, if that is known.
    Steady(Option<BetterDirection>),
}

/// The direction in which a value is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BetterDirection {
    Less,
    More,
}

impl FigureKind {
    /// Returns the kind for a key, which ends in its unit.
    pub(crate) fn from_key(key: &str) -> Self {
        let ends = |ends: &[&str]| ends.iter().any(|end| key.ends_with(end));
        let is = |names: &[&str]| names.contains(&key);
        if ends(&["per_second"]) || is(&["throughput", "times_real_time"]) {
            Self::Rate
        } else if ends(&["_us", "_ms", "_ns", "_mj"]) || is(&["seconds", "ms"]) {
            Self::Time
        } else if ends(&["_bytes"])
            || is(&[
                "bytes",
                "params",
                "macs",
                "eer",
                "non_finite",
                "tied",
                "spread",
            ])
        {
            Self::Steady(Some(BetterDirection::Less))
        } else if key.starts_with("rank")
            || is(&["accuracy", "map", "minp", "auc", "tar", "hits", "jaccard"])
        {
            Self::Steady(Some(BetterDirection::More))
        } else {
            Self::Steady(None)
        }
    }

    /// Returns the direction that is better, if it is known.
    pub(crate) fn better(self) -> Option<BetterDirection> {
        match self {
            Self::Time => Some(BetterDirection::Less),
            Self::Rate => Some(BetterDirection::More),
            Self::Steady(better) => better,
        }
    }

    /// Returns whether the value depends on other work on the machine.
    pub(crate) fn is_timed(self) -> bool {
        matches!(self, Self::Time | Self::Rate)
    }
}

impl Estimate {
    /// Creates an estimate of a number that does not vary.
    pub(crate) fn exact(value: f64) -> Self {
        Self {
            value,
            low: value,
            high: value,
        }
    }

    /// Returns the estimate from the same value in each run.
    ///
    /// With one run, the interval comes from fields next to the value: the means of its windows for
    /// a time, or else `<key>_low` and `<key>_high`. With several runs, the value is
    /// their median. With fewer than five, which is too few for the interval of a median, the
    /// interval contains the intervals of all runs.
    pub(crate) fn from_runs(places: &[ResultFigure<'_>], measure: FigureKind) -> Self {
        let each: Vec<Self> = places
            .iter()
            .map(|place| Self::of_one(place, measure))
            .collect();
        let values: Vec<f64> = places.iter().map(|place| place.value).collect();
        let median = Self::of_median(&values);
        match each[..] {
            [one] => one,
            _ if measure.is_timed() && each.len() >= ENOUGH_RUNS => median,
            _ => Self {
                value: median.value,
                low: each
                    .iter()
                    .map(|estimate| estimate.low)
                    .fold(f64::INFINITY, f64::min),
                high: each
                    .iter()
                    .map(|estimate| estimate.high)
                    .fold(f64::NEG_INFINITY, f64::max),
            },
        }
    }

    fn of_one(place: &ResultFigure<'_>, measure: FigureKind) -> Self {
        let value = place.value;
        if measure.is_timed()
            && let Some(means) = windows(place)
        {
            return match means[..] {
                // The variation between windows is unknown, but within the range of the calls.
                [mean] => match ["min_us", "max_us"].map(|key| place.beside(key)) {
                    [Some(least), Some(most)] => Self {
                        value: mean,
                        low: least.min(mean),
                        high: most.max(mean),
                    }
                    .scaled_to(value, measure),
                    _ => Self {
                        value,
                        low: f64::NEG_INFINITY,
                        high: f64::INFINITY,
                    },
                },
                _ => Self::of_median(&means).scaled_to(value, measure),
            };
        }
        let [low, high] = ["low", "high"].map(|end| place.beside(&format!("{}_{end}", place.key)));
        let (Some(low), Some(high)) = (low, high) else {
            return Self::exact(value);
        };
        Self {
            value,
            low: low.min(value),
            high: high.max(value),
        }
    }

    /// Returns the sum with another estimate that counts a number of times.
    pub(crate) fn plus(self, other: Self, times: u32) -> Self {
        let plus = |first: f64, added: f64| first + f64::from(times) * added;
        Self {
            value: plus(self.value, other.value),
            low: plus(self.low, other.low),
            high: plus(self.high, other.high),
        }
    }

    /// Returns the median of several values, and its interval.
    fn of_median(values: &[f64]) -> Self {
        median_interval(values).map_or(Self::exact(f64::NAN), |(value, Interval { low, high })| {
            Self { value, low, high }
        })
    }

    /// Returns an estimate of another value with the same relative interval; inverted for a rate.
    fn scaled_to(self, value: f64, measure: FigureKind) -> Self {
        let (low, high) = (self.low / self.value, self.high / self.value);
        let (low, high) = match measure {
            FigureKind::Rate => (1.0 / high, 1.0 / low),
            _ => (low, high),
        };
        if !(low.is_finite() && high.is_finite()) {
            return Self::exact(value);
        }
        Self {
            value,
            low: (low * value).min(value),
            high: (high * value).max(value),
        }
    }

    /// Returns the estimate if other processes kept the machine busy: without a limit on the better
    /// side.
    pub(crate) fn disturbed(self, measure: FigureKind) -> Self {
        match measure {
            FigureKind::Time => Self {
                low: f64::NEG_INFINITY,
                ..self
            },
            FigureKind::Rate => Self {
                high: f64::INFINITY,
                ..self
            },
            FigureKind::Steady(_) => self,
        }
    }
}

/// Keys of times to which the intervals of the windows do not apply: they are not of all calls in
/// the windows, or are not typical calls.
const NOT_OF_WINDOWS: [&str; 9] = [
    "load_ms",
    "first_ms",
    "runtime_load_ms",
    "seconds",
    "min_us",
    "max_us",
    "sd_us",
    "p999_us",
    "reusing_p50_us",
];

/// Returns the means of the windows that a time was measured in, if they are in the same object.
fn windows(place: &ResultFigure<'_>) -> Option<Vec<f64>> {
    let means = place.object()?.get("window_mean_us")?.as_array()?;
    if NOT_OF_WINDOWS.contains(&place.key.as_str()) {
        return None;
    }
    let means: Vec<f64> = means.iter().filter_map(Value::as_f64).collect();
    (!means.is_empty()).then_some(means)
}

/// Returns why a time is unreliable, if other processes kept the machine busy.
pub(crate) fn disturbance(place: &ResultFigure<'_>) -> Option<String> {
    let shares = place.around.iter().flat_map(|object| {
        [
            ("load_of_others", "before it was measured"),
            ("others_busy", "while it was measured"),
        ]
        .map(|(key, when)| (object.get(key).and_then(Value::as_f64), when))
    });
    let noisy = shares.filter_map(|(share, when)| share.map(|share| (share, when)));
    let (share, when) = noisy
        .filter(|(share, _)| *share > LOAD_WARNED_OF)
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(format!(
        "other processes kept {:.0} % of the processors busy {when}",
        100.0 * share
    ))
}

#[cfg(test)]
mod tests {
    use super::super::figure::FigurePath;
    use super::*;
    use serde_json::json;

    fn estimate(results: &Value, path: &str) -> Estimate {
        let places = FigurePath::parse(path)
            .and_then(|path| path.places(results))
            .expect("a figure");
        Estimate::from_runs(&places, FigureKind::from_key(&places[0].key))
    }

    #[test]
    fn keys_tell_what_a_figure_is() {
        assert_eq!(FigureKind::from_key("p50_us"), FigureKind::Time);
        assert_eq!(FigureKind::from_key("single_mj"), FigureKind::Time);
        assert_eq!(
            FigureKind::from_key("silhouettes_per_second"),
            FigureKind::Rate
        );
        assert_eq!(FigureKind::from_key("throughput"), FigureKind::Rate);
        assert_eq!(
            FigureKind::from_key("rank1").better(),
            Some(BetterDirection::More)
        );
        assert_eq!(
            FigureKind::from_key("eer").better(),
            Some(BetterDirection::Less)
        );
        assert_eq!(
            FigureKind::from_key("peak_rss_bytes").better(),
            Some(BetterDirection::Less)
        );
        assert_eq!(FigureKind::from_key("probes").better(), None);
        assert!(!FigureKind::from_key("bytes").is_timed());
    }

    #[test]
    fn windows_make_the_interval_of_a_time_and_of_a_rate() {
        let results = json!({
            "p50_us": 200.0, "throughput": 5000.0, "load_ms": 3.0,
            "window_mean_us": [110.0, 100.0, 90.0, 105.0, 95.0],
        });
        let time = estimate(&results, "p50_us");
        assert_eq!(
            (time.value, time.low, time.high.round()),
            (200.0, 180.0, 220.0)
        );
        let rate = estimate(&results, "throughput");
        assert!((rate.low - 5000.0 / 1.1).abs() < 1e-9 && (rate.high - 5000.0 / 0.9).abs() < 1e-9);
        assert_eq!(estimate(&results, "load_ms"), Estimate::exact(3.0));
        let one = json!({ "p50_us": 200.0, "max_us": 300.0, "window_mean_us": [110.0] });
        let found = estimate(&one, "p50_us");
        assert_eq!((found.low, found.high), (f64::NEG_INFINITY, f64::INFINITY));
        assert_eq!(estimate(&one, "max_us"), Estimate::exact(300.0));
        // The ends are the shortest and the longest call: half as long and twice as long as their
        // mean.
        let calls = json!({
            "p50_us": 90.0, "throughput": 1e4, "min_us": 50.0, "max_us": 200.0, "window_mean_us": [100.0],
        });
        let time = estimate(&calls, "p50_us");
        assert_eq!((time.value, time.low, time.high), (90.0, 45.0, 180.0));
        let rate = estimate(&calls, "throughput");
        assert_eq!((rate.low, rate.high), (5e3, 2e4));
    }

    #[test]
    fn hits_have_the_interval_beside_them() {
        let results = json!({ "rank1": 0.5, "rank1_low": 0.4, "rank1_high": 0.7, "map": 0.6 });
        let found = estimate(&results, "rank1");
        assert_eq!((found.low, found.high), (0.4, 0.7));
        assert_eq!(estimate(&results, "map"), Estimate::exact(0.6));
    }

    #[test]
    fn a_busy_machine_may_hide_better_times_only() {
        let time = Estimate {
            value: 2.0,
            low: 1.0,
            high: 3.0,
        };
        let disturbed = time.disturbed(FigureKind::Time);
        assert_eq!((disturbed.low, disturbed.high), (f64::NEG_INFINITY, 3.0));
        let rate = time.disturbed(FigureKind::Rate);
        assert_eq!((rate.low, rate.high), (1.0, f64::INFINITY));
        assert_eq!(time.disturbed(FigureKind::from_key("bytes")), time);
        let json = serde_json::to_value(disturbed).expect("JSON");
        assert_eq!(json, json!({ "value": 2.0, "low": null, "high": 3.0 }));
    }

    #[test]
    fn who_kept_the_machine_busy_is_said() {
        let results = json!({
            "load_of_others": 0.02,
            "models": [{ "name": "a", "p50_us": 1.0, "others_busy": 0.52 }, { "name": "b", "p50_us": 1.0 }],
        });
        let said = |path: &str| {
            let path = FigurePath::parse(path).expect("a path");
            disturbance(&path.places(&results).expect("a figure")[0])
        };
        let expected = "other processes kept 52 % of the processors busy while it was measured";
        assert_eq!(said("models[a].p50_us").as_deref(), Some(expected));
        assert_eq!(said("models[b].p50_us"), None);
    }
}
