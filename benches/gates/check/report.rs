//! What came of each gate, as a table.

use super::need::Need;
use edgegait::error::{Error, Result};
use std::fmt;

/// All gates, checked.
#[derive(Debug)]
pub struct Report<'a> {
    /// Ratios, sums and bytes, each in the list's order.
    pub lines: Vec<Line<'a>>,
}

/// One gate, checked.
#[derive(Debug)]
pub struct Line<'a> {
    name: &'a str,
    reason: &'a str,
    outcome: Outcome,
}

/// What came of a gate.
#[derive(Debug)]
pub enum Outcome {
    /// A number, and where it has to be.
    Number {
        /// A quotient of times, or bytes.
        measured: f64,
        /// Where it has to be.
        limit: Limit,
        /// How many of its decimals say something.
        decimals: usize,
    },
    /// The machine lacks what the gate needs.
    Skipped(Need),
    /// It cannot be told.
    Unknown(Error),
}

/// Where a number has to be.
#[derive(Clone, Copy, Debug)]
pub enum Limit {
    /// There, or above.
    AtLeast(f64),
    /// There, or below.
    AtMost(f64),
}

impl Limit {
    /// How far `measured` is on the right side, percent of the limit; negative on the wrong
    /// side. Nothing, where nothing may be, is at its limit.
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
    /// An error is an outcome that cannot be told.
    pub fn new(name: &'a str, reason: &'a str, outcome: Result<Outcome>) -> Self {
        Self {
            name,
            reason,
            outcome: outcome.unwrap_or_else(Outcome::Unknown),
        }
    }

    /// Whether the number is on the wrong side of its limit, or cannot be told.
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
    /// Whether no gate is missed or unknown; skipped ones are neither.
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
