//! Whether a side answers as the reference, and why not.

use super::{AnswerDifference, Comparison, ParitySide};
use serde::Serialize;

/// Whether sides answer the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Verdict {
    /// Within the limits.
    Same,
    /// Beyond one of them, or a number is not finite.
    Differs,
}

/// How far apart two sides may be and count as the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Limits {
    /// Of any input: [`AnswerDifference::greatest_relative`].
    pub relative_difference: f64,
    /// Of all inputs: [`AnswerDifference::mean_relative`].
    pub mean_relative_difference: f64,
    /// Share of probes that one side alone takes for the right person, 0..1. Whom the wrong answers
    /// name does not count: where nobody is near, rounding chooses.
    pub changed_hits: f64,
}

impl Limits {
    /// Where both sides compute in f32. Ours: rounding leaves up to 3e-5 (measured on the shipped linear
    /// models and on networks of two and six convolutions), half precision, which drivers choose
    /// without being asked, has steps of 5e-4 in each number, and one weight of the shipped GEINet that is off by a tenth makes 8.7e-4.
    /// One probe in a thousand may lie between two people who are equally near.
    pub(crate) const FLOAT: Self = Self {
        relative_difference: 2e-4,
        mean_relative_difference: 2e-4,
        changed_hits: 1e-3,
    };
    /// Where a side is quantised. Ours: a sound static quantisation is off by 0.02 to 0.03 in the mean
    /// (measured on networks of one and two convolutions, per tensor and per channel), deeper ones by
    /// more, and by 0.2 at inputs whose numbers are beyond what calibration saw. One layer's scale
    /// that is wrong by a quarter makes 0.1 to 0.45 in the mean. 0.1 is a signal 20 dB above the noise.
    pub(crate) const INT8: Self = Self {
        relative_difference: 0.5,
        mean_relative_difference: 0.1,
        changed_hits: 0.05,
    };

    /// The usual ones of these sides.
    pub(crate) const fn of(reference: &ParitySide, other: &ParitySide) -> Self {
        if reference.quantized || other.quantized {
            Self::INT8
        } else {
            Self::FLOAT
        }
    }
}

impl Comparison {
    /// Decides, and says why.
    pub(super) fn judge(&mut self, sides: [&ParitySide; 2]) {
        let mut reasons = Vec::new();
        for side in sides.iter().filter(|side| side.non_finite > 0) {
            reasons.push(format!(
                "{}: {} of {} numbers are NaN or infinite",
                side.label(),
                side.non_finite,
                side.numbers
            ));
        }
        let differences = [("embeddings", &self.embedding), ("scores", &self.scores)];
        for (what, difference) in differences {
            if let Some(difference) = difference {
                reasons.extend(self.limits.reasons(what, difference));
            }
        }
        match &self.ranks {
            Some(ranks) if ranks.changed_hits() > self.limits.changed_hits => {
                reasons.push(format!(
                    "{} of {} probes are taken for the right person by one side only, more than {} %",
                    ranks.lost + ranks.gained,
                    ranks.probes,
                    100.0 * self.limits.changed_hits
                ));
            }
            Some(_) => {}
            None => reasons.push("nobody can be ranked on a side: no embedding is finite".into()),
        }
        self.verdict = if reasons.is_empty() {
            Verdict::Same
        } else {
            Verdict::Differs
        };
        self.reasons = reasons;
    }
}

impl Limits {
    fn reasons(&self, what: &str, difference: &AnswerDifference) -> Vec<String> {
        let cases = [
            (
                "greatest",
                difference.greatest_relative,
                self.relative_difference,
            ),
            (
                "mean",
                difference.mean_relative,
                self.mean_relative_difference,
            ),
        ];
        // What is no number is beyond any limit.
        let beyond = cases
            .into_iter()
            .filter(|(_, found, limit)| found.is_nan() || found > limit);
        beyond
            .map(|(which, found, limit)| {
                format!(
                    "the {which} relative difference of {what} is {found:.3e}, more than {limit}"
                )
            })
            .collect()
    }
}
