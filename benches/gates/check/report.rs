//! The table of the gates' outcomes.

use super::need::Need;
use edgegait::error::{Error, Result};
use std::fmt;

/// The outcomes of all gates.
#[derive(Debug)]
pub struct Report<'a> {
    /// The lines of ratios, sums and bytes, each in the list's order.
    pub lines: Vec<Line<'a>>,
}

/// The line of a gate, with its outcome.
#[derive(Debug)]
pub struct Line<'a> {
    name: &'a str,
    reason: &'a str,
    outcome: Outcome,
}

/// The outcome of a gate.
#[derive(Debug)]
pub enum Outcome {
    /// A measured number and its limit.
    Number {
        /// A ratio of times, or a size in bytes.
        measured: f64,
        /// The limit of the number.
        limit: Limit,
        /// The number of significant decimals.
        decimals: usize,
    },
    /// The machine lacks what the gate needs.
    Skipped(Need),
    /// The number is unknown, for this reason.
    Unknown(Error),
}

/// The limit of a number.
#[derive(Clone, Copy, Debug)]
pub enum Limit {
    /// The number must be at least this.
    AtLeast(f64),
    /// The number must be at most this.
    AtMost(f64),
}

impl Limit {
    /// Returns by how much `measured` meets the limit, in percent of the limit; negative if it
    /// misses it, 0 if it equals it (even for a limit of 0).
    fn margin_percent(self, measured: f64) -> f64 {
        let (margin, limit) = match self {
            Self::AtLeast(limit) => (measured - limit, limit),
            Self::AtMost(limit) => (limit - measured, limit),
        };
        if margin == 0.0 {
            0.0
        } else {
            100.0 * margin / limit
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&match self {
            Self::AtLeast(limit) => format!(">= {limit}"),
            Self::AtMost(limit) => format!("<= {limit}"),
        })
    }
}

impl<'a> Line<'a> {
    /// Makes a line; an error becomes an unknown outcome.
    pub fn new(name: &'a str, reason: &'a str, outcome: Result<Outcome>) -> Self {
        Self {
            name,
            reason,
            outcome: outcome.unwrap_or_else(Outcome::Unknown),
        }
    }

    /// Returns whether the limit is missed, or the number unknown.
    fn is_missed(&self) -> bool {
        match &self.outcome {
            Outcome::Number {
                measured, limit, ..
            } => limit.margin_percent(*measured) < 0.0,
            Outcome::Skipped(_) => false,
            Outcome::Unknown(_) => true,
        }
    }
}

impl Report<'_> {
    /// Returns whether no gate is missed or unknown; skipped gates are neither.
    pub fn passes(&self) -> bool {
        !self.lines.iter().any(Line::is_missed)
    }
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.lines.iter().map(|line| line.name.chars().count());
        let width = names.max().unwrap_or(0);
        writeln!(f, "{:width$}  measured     limit  margin", "")?;
        for line in &self.lines {
            write!(f, "{:width$}  ", line.name)?;
            match &line.outcome {
                Outcome::Number {
                    measured,
                    limit,
                    decimals,
                } => {
                    let margin = limit.margin_percent(*measured);
                    write!(f, "{measured:>8.decimals$}{limit:>10}{margin:>+6.0} %")?;
                    if line.is_missed() {
                        write!(f, "  MISSED\n    {}", line.reason)?;
                    }
                }
                Outcome::Skipped(need) => write!(f, "skipped: this machine has no {need}")?,
                Outcome::Unknown(error) => write!(f, "UNKNOWN\n    {error}")?,
            }
            writeln!(f)?;
        }
        let missed = self.lines.iter().filter(|line| line.is_missed()).count();
        writeln!(
            f,
            "{missed} of {} gates missed or unknown",
            self.lines.len()
        )
    }
}
