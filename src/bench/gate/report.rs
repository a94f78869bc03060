//! The report of all limits, and its text form.

use super::estimate::Estimate;
use super::judge::GateOutcome;
use crate::files::ResultHeader;
use crate::files::text_table::Column::Left;
use crate::files::text_table::Table;
use crate::report::grouped;
use serde::Serialize;
use std::fmt;

/// The outcome of one bound on one value.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct GateLine {
    /// The name of the limit; by default the path of the value.
    pub name: String,
    /// The path of the value.
    pub figure: String,
    /// What the value is divided by.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per: Option<String>,
    /// Why the limit is there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The limit, in words.
    pub limit: String,
    /// The outcome of the limit.
    pub outcome: GateOutcome,
    /// Why it is undecided.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// The value.
    pub found: Estimate,
    /// The baseline's value, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline: Option<Estimate>,
    /// The value divided by the baseline's, for bounds relative to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio: Option<Estimate>,
    /// The value minus the baseline's, for bounds relative to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference: Option<Estimate>,
}

/// The outcome of all limits.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct GateReport {
    /// The command, version, inputs and warnings.
    #[serde(flatten)]
    pub header: ResultHeader,
    /// The worst outcome: missed if any limit is, else undecided if any is.
    pub outcome: GateOutcome,
    /// One line for each bound on each value.
    pub limits: Vec<GateLine>,
}

impl GateReport {
    pub(super) fn new(header: ResultHeader, limits: Vec<GateLine>) -> Self {
        let worst = limits.iter().map(|line| line.outcome).max();
        Self {
            header,
            // Without any limit, nothing is decided.
            outcome: worst.unwrap_or(GateOutcome::CannotTell),
            limits,
        }
    }

    pub(super) fn count(&self, outcome: GateOutcome) -> usize {
        self.limits
            .iter()
            .filter(|line| line.outcome == outcome)
            .count()
    }

    /// Returns a summary such as `1 of 5 limits missed, 1 undecided`.
    pub(super) fn summary(&self) -> String {
        let all = self.limits.len();
        let [missed, unsure] =
            [GateOutcome::Missed, GateOutcome::CannotTell].map(|outcome| self.count(outcome));
        let limits = if all == 1 { "limit" } else { "limits" };
        match (missed, unsure) {
            _ if all == 0 => "no limit is left to judge".into(),
            (0, 0) if all == 1 => "the limit holds".into(),
            (0, 0) => format!("all {all} limits hold"),
            (0, unsure) if unsure == all && all == 1 => "the limit is undecided".into(),
            (0, unsure) if unsure == all => format!("all {all} limits are undecided"),
            (0, unsure) => format!("{unsure} of {all} {limits} undecided, the others hold"),
            (missed, 0) => format!("{missed} of {all} {limits} missed"),
            (missed, unsure) => {
                format!("{missed} of {all} {limits} missed, {unsure} undecided")
            }
        }
    }
}

impl GateLine {
    /// Returns why the limit is undecided, and why it is there.
    pub(super) fn remarks(&self) -> impl Iterator<Item = &str> {
        let both = [&self.why, &self.reason].into_iter();
        both.flatten().map(String::as_str)
    }

    /// Returns the value with its interval.
    pub(super) fn found_text(&self) -> String {
        text_of(self.found)
    }

    /// Returns the baseline's value and, for a relative bound, the ratio or the difference; empty
    /// without a baseline.
    pub(super) fn beside_text(&self) -> String {
        let Some(baseline) = self.baseline else {
            return String::new();
        };
        let between = match (self.ratio, self.difference) {
            (Some(ratio), _) if self.limit.contains("times") => {
                format!(", {} times", text_of(ratio))
            }
            (_, Some(difference)) => {
                let sign = if difference.value > 0.0 { "+" } else { "" };
                format!(", {sign}{}", text_of(difference))
            }
            _ => String::new(),
        };
        format!("{}{between}", number(baseline.value))
    }
}

/// Formats a value with its interval, if it has one.
fn text_of(estimate: Estimate) -> String {
    let Estimate { value, low, high } = estimate;
    if low == high {
        return number(value);
    }
    let end = |end: f64| {
        if end.is_finite() {
            number(end)
        } else {
            "unknown".into()
        }
    };
    format!("{} ({} to {})", number(value), end(low), end(high))
}

/// Formats a number with four significant digits; whole numbers in full.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        return "?".into();
    }
    if size >= 999.5 || value.fract() == 0.0 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative; saturates"
        )]
        let whole = size.round() as u64;
        let sign = if value < 0.0 { "-" } else { "" };
        return format!("{sign}{}", grouped(whole, ","));
    }
    let before = if size < 1e-12 {
        0.0
    } else {
        size.log10().floor()
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 1 and 15"
    )]
    let decimals = (3.0 - before).clamp(1.0, 15.0) as usize;
    let text = format!("{value:.decimals$}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

impl fmt::Display for GateReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new(&[Left(0)]).with_gap(2);
        table.row(["", "figure", "found", "limit", "baseline"]);
        for line in &self.limits {
            let cells = [line.found_text(), line.limit.clone(), line.beside_text()];
            table.row(
                [line.outcome.name().to_owned(), line.name.clone()]
                    .into_iter()
                    .chain(cells),
            );
            if let Some(why) = &line.why {
                table.note(format!("             {why}"));
            }
            if line.outcome == GateOutcome::Missed
                && let Some(reason) = &line.reason
            {
                table.note(format!("             {reason}"));
            }
        }
        writeln!(f, "{table}{}", self.summary())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_that_count() {
        for (value, text) in [
            (0.0, "0"),
            (270.283, "270.3"),
            (0.523_81, "0.5238"),
            (0.000_012_346, "0.00001235"),
            (1234.56, "1,235"),
            (188_833.0, "188,833"),
            (-0.028_5, "-0.0285"),
            (-12.0, "-12"),
            (9.9996, "10"),
            (f64::INFINITY, "?"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
