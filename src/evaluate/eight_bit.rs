//! Agreement between a recognizer and its copy with 8-bit weights.

use super::rank1::{ProbeOutcome, Tally, closed_set};
use crate::dataset::sequences::{Form, SequenceSource};
use crate::error::Result;
use crate::inference::Recognizer;
use crate::inference::answers::{RecognizerNeeds, ask};
use edgegait_core::linear::LinearRecognizer;
use serde::{Deserialize, Serialize};

/// A comparison of the answers of both recognizers to the same GEIs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Agreement {
    /// Number of GEIs that both were shown.
    pub probes: u64,
    /// Number of GEIs for which both gave the highest score to the same class.
    pub equal_answers: u64,
    /// Share of hits of the original, 0..1; none if none of the people is a class.
    pub rank1: Option<f64>,
    /// Share of hits of the quantised copy.
    pub rank1_int8: Option<f64>,
    /// The greatest absolute difference between the two in the score of a class.
    pub greatest_difference: f64,
    /// Mean absolute difference in the score of a class.
    pub mean_difference: f64,
    /// Mean lead of the original's highest score over the next one, as a scale for the differences.
    pub mean_lead: f64,
}

/// Sums over GEIs.
#[derive(Default)]
struct GeiSums {
    equal: u64,
    ranks: [Tally; 2],
    greatest: f64,
    differences: f64,
    leads: f64,
}

impl Agreement {
    /// Shows all sequences of a source to both recognizers.
    ///
    /// # Errors
    /// If a sequence cannot be shown, or the original fails.
    pub(crate) fn measure(
        recognizer: &dyn Recognizer,
        quantized: &LinearRecognizer<'_>,
        source: &SequenceSource<'_>,
        form: &Form,
    ) -> Result<Self> {
        let sequences = source.sequences();
        let all: Vec<usize> = (0..sequences.list.len()).collect();
        let mut found = vec![Vec::new(); all.len()];
        let mut seen = |sequence: usize, bytes: &[u8]| {
            let scores = (0..quantized.classes()).filter_map(|class| quantized.score(class, bytes));
            found[sequence] = scores.collect();
            Ok(())
        };
        let asked = RecognizerNeeds {
            recognizer,
            needs: &|_| true,
        };
        let (answers, _) = ask(&[asked], source, &all, form, &mut seen)?;
        let classes = &recognizer.contract().classes;
        let mut sums = GeiSums::default();
        for (&sequence, found) in all.iter().zip(&found) {
            let person = &sequences.subjects[sequences.subject(sequence)];
            let truth = classes.iter().position(|class| class == person);
            let original = answers.iter().flat_map(|answers| answers.scores(sequence));
            sums.add(&original.copied().collect::<Vec<f32>>(), found, truth);
        }
        let probes = all.len() as u64;
        let scores = (probes * quantized.classes() as u64).max(1) as f64;
        Ok(Self {
            probes,
            equal_answers: sums.equal,
            rank1: sums.ranks[0].rank1(),
            rank1_int8: sums.ranks[1].rank1(),
            greatest_difference: sums.greatest,
            mean_difference: sums.differences / scores,
            mean_lead: sums.leads / probes.max(1) as f64,
        })
    }
}

impl GeiSums {
    fn add(&mut self, original: &[f32], quantized: &[f32], truth: Option<usize>) {
        let (best, lead) = best(original);
        self.equal += u64::from(closed_set(quantized, best) == ProbeOutcome::Hit);
        self.leads += lead;
        if let Some(truth) = truth {
            self.ranks[0].add(closed_set(original, truth));
            self.ranks[1].add(closed_set(quantized, truth));
        }
        for (a, b) in original.iter().zip(quantized) {
            let difference = (f64::from(*a) - f64::from(*b)).abs();
            self.greatest = self.greatest.max(difference);
            self.differences += difference;
        }
    }
}

/// Returns the class with the highest score (ties go to the first) and its lead over the next one.
fn best(scores: &[f32]) -> (usize, f64) {
    let mut order: Vec<usize> = (0..scores.len()).collect();
    order.sort_by(|&a, &b| scores[b].total_cmp(&scores[a]));
    match *order.as_slice() {
        [first, next, ..] => (first, f64::from(scores[first]) - f64::from(scores[next])),
        _ => (0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_hits_leads_and_differences_are_counted() {
        let mut sums = GeiSums::default();
        // The original is right twice and leads by 2, 1 and 0; the other one once.
        sums.add(&[5.0, 3.0, 1.0], &[5.5, 3.0, 1.0], Some(0));
        sums.add(&[0.0, 1.0, -1.0], &[2.0, 1.0, -1.25], Some(1));
        sums.add(&[4.0, 4.0, 1.0], &[4.0, 4.0, 1.0], Some(2));
        assert_eq!((sums.equal, sums.greatest, sums.leads), (2, 2.0, 3.0));
        assert_eq!(sums.differences, 0.5 + 2.0 + 0.25);
        assert_eq!(
            sums.ranks.map(|tally| (tally.hits, tally.probes)),
            [(2, 3), (1, 3)]
        );
        // A person without a class has no rank.
        sums.add(&[1.0, 0.0], &[1.0, 0.0], None);
        assert_eq!((sums.equal, sums.ranks[0].probes), (3, 3));
    }
}
