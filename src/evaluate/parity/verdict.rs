//! The verdict on whether a side gives the same answers as the reference, and its reasons.

use super::{AnswerDifference, Comparison, ParitySide};
use serde::Serialize;

/// Whether sides give the same answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Verdict {
    /// Within the limits.
    Same,
    /// Beyond a limit, or a number is not finite.
    Differs,
}

/// Limits within which the answers of two sides count as the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Limits {
    /// Limit of [`AnswerDifference::greatest_relative`], for any input.
    pub relative_difference: f64,
    /// Limit of [`AnswerDifference::mean_relative`], over all inputs.
    pub mean_relative_difference: f64,
    /// Limit of the share of probes that only one side identifies correctly, 0..1. Changes between
    /// two wrong people do not count: where nobody is near, rounding decides.
    pub changed_hits: f64,
}

impl Limits {
    /// Limits where both sides compute in f32. Our choice. Rounding gives up to 3e-5 (measured on
    /// the shipped linear models and on networks of two and six convolutions). Half precision,
    /// which some drivers choose unasked, has steps of 5e-4 in each number. One weight of the
    /// shipped GEINet that is off by a tenth gives 8.7e-4. One probe in a thousand may lie between
    /// two people who are equally near.
    pub(crate) const FLOAT: Self = Self {
        relative_difference: 2e-4,
        mean_relative_difference: 2e-4,
        changed_hits: 1e-3,
    };
    /// Limits where a side is quantised. Our choice. A sound static quantisation is off by 0.02 to
    /// 0.03 in the mean (measured on networks of one and two convolutions, per tensor and per
    /// channel). Deeper networks are off by more, and by 0.2 at inputs whose numbers are beyond the
    /// calibrated range. A scale of one layer that is wrong by a quarter gives 0.1 to 0.45 in
    /// the mean. 0.1 is a signal 20 dB above the noise.
    pub(crate) const INT8: Self = Self {
        relative_difference: 0.5,
        mean_relative_difference: 0.1,
        changed_hits: 0.05,
    };

    /// Returns the default limits for two sides.
    pub(crate) const fn default_for(reference: &ParitySide, other: &ParitySide) -> Self {
        if reference.quantized || other.quantized {
            Self::INT8
        } else {
            Self::FLOAT
        }
    }
}

impl Comparison {
    /// Sets the verdict and its reasons.
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
                    "{} of {} probes are identified correctly by one side only, more than {} %",
                    ranks.lost + ranks.gained,
                    ranks.probes,
                    100.0 * self.limits.changed_hits
                ));
            }
            Some(_) => {}
            None => {
                reasons.push("probes cannot be ranked: one side has no finite embedding".into());
            }
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
        // NaN is beyond any limit.
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
