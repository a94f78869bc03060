//! The file of limits.

use super::figure::{FigurePath, ResultFigure};
use super::freshness::Freshness;
use super::need::MachineNeed;
use crate::error::{Error, FilePlace, Result};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt;
use std::num::NonZeroU32;
use std::path::Path;
use toml::Spanned;

/// The maximum size of a file of limits in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// All limits of a file, at least one.
#[derive(Clone, Debug)]
pub(crate) struct GateLimits {
    pub limits: Vec<GateLimit>,
    /// Which of criterion's results are refused.
    pub criterion: Option<Freshness>,
}

/// A limit: what must hold for one or more values.
#[derive(Clone, Debug)]
pub(crate) struct GateLimit {
    /// The name to show; by default the path of the value.
    pub name: Option<String>,
    /// Why the limit is there.
    pub reason: Option<String>,
    /// Path of the values.
    pub figure: FigurePath,
    /// What the values are divided by, the sum of these; none if empty.
    pub per: Vec<LimitDivisor>,
    /// What the limit needs of the machine.
    pub needs: Option<MachineNeed>,
    /// Line of the file with the path.
    pub line: usize,
    /// The bounds, at least one.
    pub bounds: Vec<Bound>,
    /// Whether the value or the interval decides, if the file states it.
    pub judge: Option<Judge>,
}

/// A value of the same results that counts a number of times.
#[derive(Clone, Debug)]
pub(crate) struct LimitDivisor {
    pub figure: FigurePath,
    /// The path as written.
    pub text: String,
    pub times: u32,
}

/// One bound of a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bound {
    AtMost(f64),
    AtLeast(f64),
    /// A bound on the value divided by the baseline's.
    RatioAtMost(f64),
    RatioAtLeast(f64),
    /// A bound on the value minus the baseline's.
    DifferenceAtMost(f64),
    DifferenceAtLeast(f64),
    /// Not worse than the baseline's by more than the interval of their difference.
    NotWorse,
}

/// Whether the value or its interval decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Judge {
    /// The value decides.
    Value,
    /// The whole interval decides. With parts on both sides the limit is undecided.
    Interval,
}

impl Bound {
    /// Returns whether the bound is relative to a baseline.
    pub(crate) fn is_relative(self) -> bool {
        !matches!(self, Self::AtMost(_) | Self::AtLeast(_))
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtMost(limit) => write!(f, "at most {limit}"),
            Self::AtLeast(limit) => write!(f, "at least {limit}"),
            Self::RatioAtMost(limit) => write!(f, "at most {limit} times the baseline"),
            Self::RatioAtLeast(limit) => write!(f, "at least {limit} times the baseline"),
            Self::DifferenceAtMost(limit) => write!(f, "at most the baseline {limit:+}"),
            Self::DifferenceAtLeast(limit) => write!(f, "at least the baseline {limit:+}"),
            Self::NotWorse => f.write_str("not worse than the baseline"),
        }
    }
}

/// A constructor of a bound from its number.
type Make = fn(f64) -> Bound;

/// The file as written in TOML.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenLimits {
    judge: Option<Judge>,
    criterion: Option<Freshness>,
    #[serde(default)]
    limit: Vec<WrittenLimit>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenLimit {
    figure: Spanned<String>,
    per: Option<WrittenDivisor>,
    needs: Option<MachineNeed>,
    name: Option<String>,
    reason: Option<String>,
    at_most: Option<f64>,
    at_least: Option<f64>,
    ratio_at_most: Option<f64>,
    ratio_at_least: Option<f64>,
    difference_at_most: Option<f64>,
    difference_at_least: Option<f64>,
    #[serde(default)]
    not_worse: bool,
    judge: Option<Judge>,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected a figure, or a table of figures and the number of times that each counts"
)]
enum WrittenDivisor {
    One(String),
    Sum(BTreeMap<String, NonZeroU32>),
}

impl GateLimits {
    /// Reads a file of limits.
    ///
    /// # Errors
    /// If it cannot be read, or as [`Self::parse`].
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let io = |error| Error::io(path, error);
        let length = std::fs::metadata(path).map_err(io)?.len();
        if length > MAX_BYTES {
            let problem = format!("expected limits of at most {MAX_BYTES} bytes, found {length}");
            return Err(Error::input(path, problem));
        }
        Self::parse(path, &crate::files::read_to_string(path)?)
    }

    /// Reads limits from TOML; `path` is for messages.
    ///
    /// # Errors
    /// With the line, if the text is not such TOML, a path is invalid, or a limit has no bound.
    pub(crate) fn parse(path: &Path, text: &str) -> Result<Self> {
        if text.trim_start().starts_with('{') {
            let problem =
                "expected limits (TOML), found JSON: name the limits first, then the results";
            return Err(Error::input(path, problem));
        }
        let written: WrittenLimits =
            toml::from_str(text).map_err(|error| Error::toml(path, text, &error))?;
        if written.limit.is_empty() {
            let problem = "expected at least one [[limit]], found none";
            return Err(Error::input(path, problem));
        }
        let limits = written.limit.into_iter().map(|written| {
            let start = written.figure.span().start;
            let before = &text.as_bytes()[..start.min(text.len())];
            let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
            written
                .limit(line)
                .map_err(|problem| Error::at(path, FilePlace::Line(line), problem))
        });
        let mut limits = limits.collect::<Result<Vec<_>>>()?;
        for limit in &mut limits {
            limit.judge = limit.judge.or(written.judge);
        }
        Ok(Self {
            limits,
            criterion: written.criterion,
        })
    }
}

impl GateLimit {
    /// Returns the values of the limit and what they are divided by.
    pub(super) fn places<'a>(
        &self,
        results: &'a Value,
    ) -> std::result::Result<Vec<ResultFigure<'a>>, String> {
        let mut all = self.figure.places(results)?;
        for part in &self.per {
            all.extend(part.figure.places(results)?);
        }
        Ok(all)
    }

    /// Returns what the values are divided by, if they are.
    pub(super) fn per_text(&self) -> Option<String> {
        let parts = self.per.iter().map(|part| match part.times {
            1 => part.text.clone(),
            times => format!("{times} x {}", part.text),
        });
        let parts: Vec<String> = parts.collect();
        (!parts.is_empty()).then(|| parts.join(" + "))
    }
}

impl WrittenLimit {
    fn limit(self, line: usize) -> std::result::Result<GateLimit, String> {
        let figure = FigurePath::parse(self.figure.get_ref())?;
        let parts = match self.per {
            None => BTreeMap::new(),
            Some(WrittenDivisor::One(text)) => [(text, NonZeroU32::MIN)].into(),
            Some(WrittenDivisor::Sum(parts)) if parts.is_empty() => {
                return Err("per: expected at least one figure, found none".into());
            }
            Some(WrittenDivisor::Sum(parts)) => parts,
        };
        let parts = parts.into_iter().map(|(text, times)| {
            Ok(LimitDivisor {
                figure: FigurePath::parse(&text)?,
                text,
                times: times.get(),
            })
        });
        let per: Vec<LimitDivisor> = parts.collect::<std::result::Result<_, String>>()?;
        let numbers: [(&str, Option<f64>, Make); 6] = [
            ("at_most", self.at_most, Bound::AtMost),
            ("at_least", self.at_least, Bound::AtLeast),
            ("ratio_at_most", self.ratio_at_most, Bound::RatioAtMost),
            ("ratio_at_least", self.ratio_at_least, Bound::RatioAtLeast),
            (
                "difference_at_most",
                self.difference_at_most,
                Bound::DifferenceAtMost,
            ),
            (
                "difference_at_least",
                self.difference_at_least,
                Bound::DifferenceAtLeast,
            ),
        ];
        let mut bounds = Vec::new();
        for (key, number, bound) in numbers {
            let Some(number) = number else { continue };
            let is_ratio =
                key.starts_with("ratio") || !per.is_empty() && !key.starts_with("difference");
            if !number.is_finite() || is_ratio && number <= 0.0 {
                let expected = if is_ratio {
                    "a number above 0"
                } else {
                    "a finite number"
                };
                return Err(format!("{key}: expected {expected}, found {number}"));
            }
            bounds.push(bound(number));
        }
        if let (Some(most), Some(least)) = (self.at_most, self.at_least)
            && most < least
        {
            return Err(format!(
                "expected at_least below at_most, found {least} and {most}"
            ));
        }
        bounds.extend(self.not_worse.then_some(Bound::NotWorse));
        if bounds.is_empty() {
            let keys: Vec<&str> = numbers.iter().map(|(key, ..)| *key).collect();
            return Err(format!(
                "{}: expected a limit, found none: add {} or not_worse = true",
                self.figure.get_ref(),
                keys.join(", ")
            ));
        }
        Ok(GateLimit {
            name: self.name,
            reason: self.reason,
            figure,
            per,
            needs: self.needs,
            line,
            bounds,
            judge: self.judge,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<GateLimits> {
        GateLimits::parse(Path::new("limits.toml"), text)
    }

    #[test]
    fn a_limit_may_have_several_bounds() {
        let text = "# why\n[[limit]]\nfigure = \"seconds\"\nat_most = 3\nratio_at_most = 1.5\n\
                    not_worse = true\njudge = \"value\"\n[[limit]]\nfigure = \"models[a].bytes\"\nat_least = -1e3\n";
        let [first, second] = &parsed(text).expect("limits").limits[..] else {
            panic!("two limits");
        };
        assert_eq!(
            first.bounds,
            [Bound::AtMost(3.0), Bound::RatioAtMost(1.5), Bound::NotWorse]
        );
        assert_eq!((first.judge, first.line), (Some(Judge::Value), 3));
        assert_eq!(
            (&second.bounds[..], second.line),
            (&[Bound::AtLeast(-1e3)][..], 9)
        );
        let is_relative = |limit: &GateLimit| limit.bounds.iter().any(|bound| bound.is_relative());
        assert!(is_relative(first) && !is_relative(second));
    }

    #[test]
    fn a_value_is_divided_by_one_or_by_a_sum() {
        let text = "judge = \"value\"\n[[limit]]\nfigure = \"a\"\nper = \"b\"\nat_most = 2\n\
                    [[limit]]\nfigure = \"a\"\nat_most = 2\njudge = \"interval\"\nper = { b = 1, \"c.d\" = 3 }\n";
        let [one, sum] = &parsed(text).expect("limits").limits[..] else {
            panic!("two limits");
        };
        assert_eq!(one.per_text().as_deref(), Some("b"));
        assert_eq!(one.judge, Some(Judge::Value), "that of the file");
        assert_eq!(sum.per_text().as_deref(), Some("b + 3 x c.d"));
        assert_eq!(sum.judge, Some(Judge::Interval));
    }

    #[test]
    fn what_is_no_limit_is_refused_with_its_line() {
        for (text, words) in [
            ("", "limits.toml: expected at least one [[limit]]"),
            ("[[limits]]\n", "limits.toml:1: unknown field `limits`"),
            (
                "\n[[limit]]\nfigure = \"a\"\n",
                "limits.toml:3: a: expected a limit, found none",
            ),
            (
                "[[limit]]\nfigure = \"a[\"\nat_most = 1\n",
                "limits.toml:2: \"a[\": expected a name",
            ),
            (
                "[[limit]]\nfigure = \"a\"\nratio_at_most = 0\n",
                "limits.toml:2: ratio_at_most: expected a number above 0, found 0",
            ),
            (
                "[[limit]]\nfigure = \"a\"\nper = \"b\"\nat_least = -8\n",
                "limits.toml:2: at_least: expected a number above 0, found -8",
            ),
            (
                "[[limit]]\nfigure = \"a\"\nper = \"b\"\nat_least = nan\n",
                "limits.toml:2: at_least: expected a number above 0, found NaN",
            ),
            (
                "[[limit]]\nfigure = \"a\"\nper = {}\nat_most = 1\n",
                "limits.toml:2: per: expected at least one figure, found none",
            ),
            (
                "[[limit]]\nfigure = \"a\"\nper = { b = 0 }\nat_most = 1\n",
                "limits.toml:3: expected a figure, or a table of figures",
            ),
            (
                "[[limit]]\nfigure = \"a\"\nper = \"b[\"\nat_most = 1\n",
                "limits.toml:2: \"b[\": expected a name",
            ),
            (
                "[[limit]]\nfigure = \"a\"\nat_most = 1\nneeds = \"sse\"\n",
                "limits.toml:4: unknown variant `sse`",
            ),
            (
                "[criterion]\nhours = 3\n[[limit]]\nfigure = \"a\"\nat_most = 1\n",
                "limits.toml:2: unknown field `hours`",
            ),
            (
                "[[limit]]\nfigure = \"a\"\nat_most = nan\n",
                "limits.toml:2: at_most: expected a finite number, found NaN",
            ),
            (
                "[[limit]]\nfigure = \"a\"\nat_mots = 1\n",
                "limits.toml:3: unknown field `at_mots`",
            ),
            (
                "[[limit]]\nfigure = \"a\"\nat_most = 1\nat_least = 2\n",
                "limits.toml:2: expected at_least below at_most, found 2 and 1",
            ),
            (
                "{\"schema\": 1}",
                "limits.toml: expected limits (TOML), found JSON",
            ),
            ("[[limit]]\nfigure = 3\n", "limits.toml:2: invalid type"),
            (
                "[[limit]]\nfigure = \"a\"\nat_most = 1\njudge = \"me\"\n",
                "limits.toml:4: unknown variant `me`",
            ),
        ] {
            let said = parsed(text).expect_err(text).to_string();
            assert!(said.starts_with(words), "{said}");
        }
    }
}
