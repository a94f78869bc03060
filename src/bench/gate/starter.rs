//! A file of limits to begin with, derived from good results.

use super::estimate::{BetterDirection, Estimate, FigureKind};
use super::figure::{FigurePath, written};
use super::report::number;
use super::results::ResultFile;
use crate::error::{Error, Result, visible_name, visible_toml};
use serde_json::Value;

/// How a limit follows from a value. Each limit has a bound that needs no baseline, so that the
/// results alone can be judged.
#[derive(Clone, Copy)]
enum UsualLimit {
    /// A time or throughput may be worse than the baseline's by this factor, and worse than the
    /// value by [`OTHER_MACHINE`].
    Factor(f64),
    /// A size or an error may grow by this factor.
    Size(f64),
    /// A rate of hits may fall by 0.02, and must not be worse than the baseline's.
    Hits,
    /// A rate of errors may grow by a tenth and 0.01.
    Errors,
    /// A count may not grow.
    Count,
}

/// A key and its limit.
type Usual = (&'static str, UsualLimit);

/// How much slower a first limit lets another machine be. Our choice.
const OTHER_MACHINE: f64 = 3.0;

/// Values of one model in results of `bench`.
const OF_BENCH: [Usual; 11] = [
    ("p50_us", UsualLimit::Factor(1.2)),
    ("p99_us", UsualLimit::Factor(1.5)),
    ("throughput", UsualLimit::Factor(1.25)),
    ("load_ms", UsualLimit::Factor(3.0)),
    ("first_ms", UsualLimit::Factor(3.0)),
    ("bytes", UsualLimit::Size(1.1)),
    ("peak_rss_over_baseline_bytes", UsualLimit::Size(1.3)),
    ("energy.single_mj", UsualLimit::Factor(1.2)),
    ("offline.throughput", UsualLimit::Factor(1.25)),
    ("parts.end_to_end.p50_us", UsualLimit::Factor(1.2)),
    ("accuracy.rank1", UsualLimit::Hits),
];

/// Values of one recognizer in results of `score`.
const OF_SCORE: [Usual; 2] = [
    ("rank1", UsualLimit::Hits),
    ("non_finite", UsualLimit::Count),
];

/// Values of one set of probes in results of `score`.
const OF_PROBES: [Usual; 2] = [
    ("rank1", UsualLimit::Hits),
    ("verification.eer", UsualLimit::Errors),
];

/// Values of one benchmark of criterion.
const OF_CRITERION: [Usual; 2] = [
    ("median_ns", UsualLimit::Factor(1.2)),
    ("bytes", UsualLimit::Size(1.1)),
];

/// Values in results of `sweep` and `segment`.
const OF_IMAGES: [Usual; 2] = [
    ("silhouettes_per_second", UsualLimit::Factor(1.25)),
    ("frames_per_second", UsualLimit::Factor(1.25)),
];

impl UsualLimit {
    /// Returns the limit of a value for which results of any command have a better direction.
    fn from_kind(kind: FigureKind) -> Option<Self> {
        Some(match kind {
            FigureKind::Time | FigureKind::Rate => Self::Factor(1.25),
            FigureKind::Steady(better) => match better? {
                BetterDirection::Less => Self::Size(1.1),
                BetterDirection::More => Self::Hits,
            },
        })
    }

    /// Returns the bounds on a value in TOML.
    fn bounds(self, value: Estimate, kind: FigureKind) -> String {
        let Estimate { value, low, high } = value;
        // A difference of two noisy times can be below 0, where a factor lowers it.
        let at_most = |limit: f64| format!("at_most = {}", round_up(limit.max(0.0)));
        match self {
            Self::Factor(factor) => {
                let is_rate = kind == FigureKind::Rate;
                let end = if is_rate { low } else { high };
                // Where the interval is unknown, it cannot decide.
                let (end, judge) = match end.is_finite() {
                    true => (end, ""),
                    false => (value, "\njudge = \"value\""),
                };
                let (own, ratio) = match is_rate {
                    true => (
                        format!("at_least = {}", round_down(end / OTHER_MACHINE)),
                        format!("ratio_at_least = {:?}", 1.0 / factor),
                    ),
                    false => (
                        at_most(end * OTHER_MACHINE),
                        format!("ratio_at_most = {factor:?}"),
                    ),
                };
                format!("{own}\n{ratio}{judge}")
            }
            Self::Size(factor) => at_most(factor * value),
            Self::Hits => format!("at_least = {}\nnot_worse = true", below(value)),
            Self::Errors => at_most(1.1 * value + 0.01),
            Self::Count => format!("at_most = {value}"),
        }
    }
}

/// Returns the rate minus 0.02, rounded down to hundredths.
fn below(rate: f64) -> String {
    let least = ((rate - 0.02) * 100.0).floor() / 100.0;
    // A rate below 0 is a difference.
    format!("{:.2}", if rate < 0.0 { least } else { least.max(0.0) })
}

/// Rounds up to two significant digits.
fn round_up(value: f64) -> String {
    rounded(value, f64::ceil)
}

/// Rounds down to two significant digits.
fn round_down(value: f64) -> String {
    rounded(value, f64::floor)
}

fn rounded(value: f64, round: fn(f64) -> f64) -> String {
    let step = 10_f64.powf(value.max(1e-9).log10().floor() - 1.0);
    let rounded = round(value / step) * step;
    if step >= 1.0 {
        format!("{rounded:.0}")
    } else {
        number(rounded)
    }
}

/// Returns a file of limits, with the current values as comments: of what matters in results of
/// `bench`, `score`, `sweep`, `segment` and criterion, and of each value that has a better
/// direction in those of other commands. The results themselves are within the limits.
///
/// # Errors
/// If the results have no value that has a better direction.
pub(crate) fn starter(results: &ResultFile) -> Result<String> {
    let command = visible_name(&results.header.command);
    let mut text = format!(
        "# Limits on the results of {command}: edgegait gate LIMITS.toml RESULT [BASELINE]\n\
         # figure is the path of a value, which is divided by that of per. Limits: at_most, at_least; relative to a baseline: ratio_at_most,\n\
         # ratio_at_least, difference_at_most, difference_at_least, not_worse = true. judge = \"value\" or \"interval\".\n"
    );
    let start = text.len();
    let mut add = |prefix: &str, usual: &[Usual]| {
        for &(key, limit) in usual {
            text += &written_limit(&results.value, &format!("{prefix}{key}"), limit);
        }
    };
    for model in list(&results.value, "models") {
        let threads = model.get("threads").and_then(Value::as_u64);
        let (Some(name), Some(threads)) = (name_of(model), threads) else {
            continue;
        };
        let prefix = format!("models[{name}].");
        let is_alone = FigurePath::parse(&format!("{prefix}threads"))
            .is_ok_and(|path| path.places(&results.value).is_ok());
        add(
            &if is_alone {
                prefix
            } else {
                format!("models[{name},threads={threads}].")
            },
            &OF_BENCH,
        );
    }
    for recognizer in list(&results.value, "recognizers") {
        let is_baseline = recognizer.get("baseline") == Some(&Value::Bool(true));
        let Some(name) = name_of(recognizer).filter(|_| !is_baseline) else {
            continue;
        };
        add(&format!("recognizers[{name}]."), &OF_SCORE);
        let sets = list(recognizer, "probe_sets");
        // With one set, its rate is the leading one.
        let usual = if sets.len() > 1 {
            &OF_PROBES[..]
        } else {
            &OF_PROBES[1..]
        };
        for set in sets {
            if let Some(set) = name_of(set) {
                add(&format!("recognizers[{name}].probe_sets[{set}]."), usual);
            }
        }
    }
    for benchmark in list(&results.value, "benchmarks") {
        if let Some(name) = name_of(benchmark) {
            add(&format!("benchmarks[{name}]."), &OF_CRITERION);
        }
    }
    add("", &OF_IMAGES);
    if text.len() == start {
        let mut paths = Vec::new();
        if let Value::Object(all) = &results.value {
            let is_header = |key: &str| ["settings", "inputs", "warnings"].contains(&key);
            let own = all.iter().filter(|(key, _)| !is_header(key));
            own.for_each(|(key, value)| add_paths(&written(key), key, value, &mut paths));
        }
        for (path, kind) in paths {
            if let Some(limit) = UsualLimit::from_kind(kind) {
                text += &written_limit(&results.value, &path, limit);
            }
        }
    }
    if text.len() == start {
        return Err(Error::input(
            &results.path,
            format!(
                "expected results with a time, a size or a rate, found those of {command}, which have none"
            ),
        ));
    }
    Ok(text)
}

/// Returns the limit of the values at a path in TOML, which all of them hold; empty if there are
/// none, or not all are numbers.
fn written_limit(results: &Value, path: &str, limit: UsualLimit) -> String {
    let places = FigurePath::parse(path).and_then(|path| path.places(results));
    let Ok(places) = places else {
        return String::new();
    };
    let Some(first) = places.first() else {
        return String::new();
    };
    let kind = FigureKind::from_key(&first.key);
    let of_each = places
        .iter()
        .map(|place| Estimate::from_runs(std::slice::from_ref(place), kind));
    // The worst counts. An unknown direction is that of one value.
    let is_less = kind.better() != Some(BetterDirection::More);
    let worst = of_each.reduce(|worst, next| match is_less == (next.value > worst.value) {
        true => next,
        false => worst,
    });
    let Some(worst) = worst.filter(|_| places.iter().all(|place| place.value.is_finite())) else {
        return String::new();
    };
    // A limit close to chance is useless.
    if matches!(limit, UsualLimit::Errors) && worst.value > 0.35 {
        return String::new();
    }
    let path = match &places[..] {
        [one] => one.path.clone(),
        _ => path.to_owned(),
    };
    format!(
        "\n[[limit]]\nfigure = {} # now {}\n{}\n",
        visible_toml(&path),
        number(worst.value),
        limit.bounds(worst, kind)
    )
}

/// Adds the paths of the values in `value` that have a better direction, with all elements of
/// lists, each path once. Ends of intervals are left out.
fn add_paths(path: &str, key: &str, value: &Value, paths: &mut Vec<(String, FigureKind)>) {
    match value {
        Value::Number(_) => {
            let kind = FigureKind::from_key(key);
            let is_end = key.ends_with("_low") || key.ends_with("_high");
            let is_known = paths.iter().any(|(known, _)| known == path);
            if kind.better().is_some() && !is_end && !is_known {
                paths.push((path.to_owned(), kind));
            }
        }
        Value::Object(inner) => {
            for (key, value) in inner {
                add_paths(&format!("{path}.{}", written(key)), key, value, paths);
            }
        }
        Value::Array(list) => {
            let objects = list.iter().filter(|element| element.is_object());
            objects.for_each(|element| add_paths(&format!("{path}[*]"), key, element, paths));
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

/// Returns the elements of a list; empty if there is no such list.
fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    let list = value.get(key).and_then(Value::as_array);
    list.map_or(&[], Vec::as_slice)
}

/// Returns the name of an element, as it is written in a path.
fn name_of(value: &Value) -> Option<String> {
    value.get("name").and_then(Value::as_str).map(written)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_below_0_holds_its_own_limit() {
        let value = Estimate {
            value: -36.0,
            low: -40.0,
            high: -30.0,
        };
        for limit in [UsualLimit::Factor(1.25), UsualLimit::Size(1.1)] {
            let bounds = limit.bounds(value, FigureKind::Time);
            assert!(bounds.starts_with("at_most = 0"), "{bounds}");
        }
    }

    #[test]
    fn limits_are_beyond_what_is_there() {
        assert_eq!(below(0.5238), "0.50");
        assert_eq!(below(0.01), "0.00");
        assert_eq!(below(-0.035), "-0.06");
        assert_eq!(round_up(188_833.0), "190000");
        assert_eq!(round_up(0.0546), "0.055");
        assert_eq!(round_up(12.0), "12");
        assert_eq!(round_down(188_833.0), "180000");
        assert_eq!(round_down(0.0546), "0.054");
        assert_eq!([round_up(0.0), round_down(0.0)], ["0", "0"]);
    }
}
