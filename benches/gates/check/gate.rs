//! The list of gates, and the measurement of each.

use super::figure::Figure;
use super::need::Need;
use super::report::{Limit, Line, Outcome, Report};
use super::results::{Results, assert_together};
use edgegait::error::{Error, Result};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU32;
use std::path::Path;

/// The gates of a file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gates {
    #[serde(default)]
    ratio: Vec<Ratio>,
    #[serde(default)]
    sum: Vec<Sum>,
    #[serde(default)]
    bytes: Vec<Bytes>,
}

/// A gate: one benchmark takes at least this many times as long as another, per element if both
/// count elements.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ratio {
    name: String,
    reason: String,
    needs: Option<Need>,
    slow: String,
    fast: String,
    at_least: Positive,
}

/// A gate: one benchmark takes at most this many times as long as its parts.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sum {
    name: String,
    reason: String,
    needs: Option<Need>,
    whole: String,
    /// The number of times that an iteration of the whole does an iteration of each part.
    parts: BTreeMap<String, NonZeroU32>,
    at_most: Positive,
}

/// A gate: a size in bytes, the same in every run, has a maximum.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Bytes {
    name: String,
    reason: String,
    figure: Figure,
    at_most: u32,
}

/// A finite number above 0.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "f64")]
struct Positive(f64);

impl TryFrom<f64> for Positive {
    type Error = String;

    fn try_from(number: f64) -> std::result::Result<Self, String> {
        if number.is_finite() && number > 0.0 {
            Ok(Self(number))
        } else {
            Err(format!("expected a limit above 0, found {number}"))
        }
    }
}

impl Gates {
    /// Parses a list of gates; errors name `path`.
    ///
    /// # Errors
    /// For TOML that is not such a list, duplicate names, gates without a reason, and sums without
    /// parts.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let gates: Self = toml::from_str(text).map_err(|error| Error::toml(path, text, &error))?;
        let mut seen = BTreeSet::new();
        for (name, reason) in gates.named() {
            if !seen.insert(name) {
                let problem = format!("{name}: expected each name once, found it twice");
                return Err(Error::input(path, problem));
            }
            if reason.trim().is_empty() {
                let problem = format!("{name}: expected a reason, found none");
                return Err(Error::input(path, problem));
            }
        }
        if let Some(sum) = gates.sum.iter().find(|sum| sum.parts.is_empty()) {
            let problem = format!("{}: expected at least one part, found none", sum.name);
            return Err(Error::input(path, problem));
        }
        Ok(gates)
    }

    /// Returns the names and reasons of all gates.
    fn named(&self) -> impl Iterator<Item = (&str, &str)> {
        let ratios = self.ratio.iter().map(|gate| (&gate.name, &gate.reason));
        let sums = self.sum.iter().map(|gate| (&gate.name, &gate.reason));
        let bytes = self.bytes.iter().map(|gate| (&gate.name, &gate.reason));
        let all = ratios.chain(sums).chain(bytes);
        all.map(|(name, reason)| (name.as_str(), reason.as_str()))
    }

    /// Checks each gate against the results, if the machine `has` what the gate needs.
    pub fn check(&self, results: &Results, has: impl Fn(Need) -> bool) -> Report<'_> {
        let skipped = |need: Option<Need>| Some(Ok(Outcome::Skipped(need.filter(|&n| !has(n))?)));
        let ratios = self.ratio.iter().map(|gate| {
            let outcome = skipped(gate.needs).unwrap_or_else(|| gate.outcome(results));
            Line::new(&gate.name, &gate.reason, outcome)
        });
        let sums = self.sum.iter().map(|gate| {
            let outcome = skipped(gate.needs).unwrap_or_else(|| gate.outcome(results));
            Line::new(&gate.name, &gate.reason, outcome)
        });
        let bytes = self.bytes.iter();
        let bytes = bytes.map(|gate| Line::new(&gate.name, &gate.reason, gate.outcome()));
        Report {
            lines: ratios.chain(sums).chain(bytes).collect(),
        }
    }
}

impl Ratio {
    fn outcome(&self, results: &Results) -> Result<Outcome> {
        let [slow, fast] = [&self.slow, &self.fast].map(|id| results.timing(id));
        let (slow, fast) = (slow?, fast?);
        assert_together(&[(&self.slow, slow), (&self.fast, fast)])?;
        let (slow_ns, fast_ns) = match (slow.elements, fast.elements) {
            (None, None) => (slow.median_ns, fast.median_ns),
            (Some(slow_elements), Some(fast_elements)) => (
                slow.median_ns / f64::from(slow_elements.get()),
                fast.median_ns / f64::from(fast_elements.get()),
            ),
            (Some(_), None) | (None, Some(_)) => {
                return Err(Error::Failed(format!(
                    "{} and {}: expected both or neither to count elements (criterion's Throughput)",
                    self.slow, self.fast
                )));
            }
        };
        Ok(Outcome::Number {
            measured: slow_ns / fast_ns,
            limit: Limit::AtLeast(self.at_least.0),
            decimals: 2,
        })
    }
}

impl Sum {
    fn outcome(&self, results: &Results) -> Result<Outcome> {
        let whole = results.timing(&self.whole)?;
        let mut all = vec![(self.whole.as_str(), whole)];
        let mut sum_ns = 0.0;
        for (id, count) in &self.parts {
            let part = results.timing(id)?;
            sum_ns += f64::from(count.get()) * part.median_ns;
            all.push((id, part));
        }
        assert_together(&all)?;
        Ok(Outcome::Number {
            measured: whole.median_ns / sum_ns,
            limit: Limit::AtMost(self.at_most.0),
            decimals: 2,
        })
    }
}

impl Bytes {
    fn outcome(&self) -> Result<Outcome> {
        Ok(Outcome::Number {
            measured: self.figure.bytes()?.into(),
            limit: Limit::AtMost(self.at_most.into()),
            decimals: 0,
        })
    }
}
