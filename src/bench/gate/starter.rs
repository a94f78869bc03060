//! A file of limits to begin with, derived from good results.

use super::figure::{FigurePath, ResultFigure, written};
use super::report::number;
use super::results::ResultFile;
use crate::error::{Error, Result};
use serde_json::Value;
use std::fmt::Write as _;

/// A key, and a function from its value to its default limit.
type Usual = (&'static str, fn(f64) -> String);

/// Values of one model in results of `bench`.
const OF_BENCH: [Usual; 11] = [
    ("p50_us", |_| "ratio_at_most = 1.2".into()),
    ("p99_us", |_| "ratio_at_most = 1.5".into()),
    ("throughput", |_| "ratio_at_least = 0.8".into()),
    ("load_ms", |_| "ratio_at_most = 3.0".into()),
    ("first_ms", |_| "ratio_at_most = 3.0".into()),
    ("bytes", |value| {
        format!("at_most = {}", round_up(1.1 * value))
    }),
    ("peak_rss_over_baseline_bytes", |value| {
        format!("at_most = {}", round_up(1.3 * value))
    }),
    ("energy.single_mj", |_| "ratio_at_most = 1.2".into()),
    ("offline.throughput", |_| "ratio_at_least = 0.8".into()),
    ("parts.end_to_end.p50_us", |_| "ratio_at_most = 1.2".into()),
    ("accuracy.rank1", of_rank1),
];

/// Values of one recognizer in results of `score`.
const OF_SCORE: [Usual; 2] = [
    ("rank1", of_rank1),
    ("non_finite", |_| "at_most = 0".into()),
];

/// Values of one set of probes in results of `score`.
const OF_PROBES: [Usual; 2] = [
    ("rank1", of_rank1),
    ("verification.eer", |value| {
        format!("at_most = {}", round_up(1.1 * value + 0.01))
    }),
];

/// Values of one benchmark of criterion.
const OF_CRITERION: [Usual; 2] = [
    ("median_ns", |_| "ratio_at_most = 1.2".into()),
    ("bytes", |value| {
        format!("at_most = {}", round_up(1.1 * value))
    }),
];

/// Values in other results.
const OF_OTHERS: [Usual; 2] = [
    ("silhouettes_per_second", |_| "ratio_at_least = 0.8".into()),
    ("frames_per_second", |_| "ratio_at_least = 0.8".into()),
];

/// Returns the limits of a rate of hits: at most a little lower, and not worse than the baseline's.
fn of_rank1(value: f64) -> String {
    format!("at_least = {}\nnot_worse = true", below(value))
}

/// Returns the rate minus 0.02, rounded down to hundredths.
fn below(rate: f64) -> String {
    format!("{:.2}", ((rate - 0.02) * 100.0).floor().max(0.0) / 100.0)
}

/// Rounds up to two significant digits.
fn round_up(value: f64) -> String {
    let step = 10_f64.powf(value.max(1e-9).log10().floor() - 1.0);
    let rounded = (value / step).ceil() * step;
    if step >= 1.0 {
        format!("{rounded:.0}")
    } else {
        number(rounded)
    }
}

/// Returns a file of limits, with the current values as comments.
///
/// # Errors
/// If the results have none of the values that have a default limit.
pub(crate) fn starter(results: &ResultFile) -> Result<String> {
    let command = &results.header.command;
    let mut text = format!(
        "# Limits on the results of {command}: edgegait gate LIMITS.toml RESULT [BASELINE]\n\
         # figure is the path of a value, which is divided by that of per. Limits: at_most, at_least; relative to a baseline: ratio_at_most,\n\
         # ratio_at_least, difference_at_most, difference_at_least, not_worse = true. judge = \"value\" or \"interval\".\n"
    );
    let start = text.len();
    let mut add = |prefix: &str, usual: &[Usual]| {
        for (key, limit) in usual {
            let path = format!("{prefix}{key}");
            let found = FigurePath::parse(&path).and_then(|path| {
                let places = path.places(&results.value)?;
                Ok(places
                    .first()
                    .map(|place: &ResultFigure<'_>| (place.path.clone(), place.value)))
            });
            let Ok(Some((path, value))) = found else {
                continue;
            };
            // A limit close to chance is useless.
            if *key == "verification.eer" && value > 0.35 {
                continue;
            }
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "\n[[limit]]\nfigure = {} # now {}\n{}\n",
                toml::Value::from(path),
                number(value),
                limit(value)
            );
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
    add("", &OF_OTHERS);
    if text.len() == start {
        return Err(Error::input(
            &results.path,
            format!(
                "expected results of bench, score, sweep, segment or criterion, found those of {command}"
            ),
        ));
    }
    Ok(text)
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
    fn limits_are_beyond_what_is_there() {
        assert_eq!(below(0.5238), "0.50");
        assert_eq!(below(0.01), "0.00");
        assert_eq!(round_up(188_833.0), "190000");
        assert_eq!(round_up(0.0546), "0.055");
        assert_eq!(round_up(12.0), "12");
    }
}
