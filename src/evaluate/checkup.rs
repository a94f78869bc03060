//! A check that a model works: its answers to a few inputs, and their problems.

use super::parity::{AnswerDifference, Limits, VectorPair};
use crate::error::Result;
use crate::inference::Recognizer;
use crate::inference::RuntimeName;
use serde::Serialize;
use std::time::Instant;

/// The answers of a model on one runtime, and their problems.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Checkup {
    /// The runtime that ran the model.
    pub runtime: RuntimeName,
    /// Number of inputs that the model was shown.
    pub inputs: usize,
    /// Milliseconds of the fastest single input.
    pub ms: f64,
    /// Numbers of an embedding.
    pub embedding_dims: usize,
    /// Parts of an embedding.
    pub embedding_parts: usize,
    /// Number of class scores; 0 if there are none.
    pub classes: usize,
    /// The problems found, in words.
    pub problems: Vec<String>,
    /// The embeddings, one per input.
    #[serde(skip)]
    pub embeddings: Vec<Vec<f32>>,
}

impl Checkup {
    /// Shows a recognizer at least two inputs of one length, one by one and as one batch.
    ///
    /// # Errors
    /// If the recognizer fails.
    pub(crate) fn run(recognizer: &dyn Recognizer, inputs: &[Vec<f32>]) -> Result<Self> {
        let (mut ms, mut embeddings, mut non_finite) = (f64::INFINITY, Vec::new(), 0);
        let (mut dims, mut parts, mut classes) = (0, 1, 0);
        for input in inputs {
            let started = Instant::now();
            let outputs = recognizer.run(input, 1)?;
            ms = ms.min(1e3 * started.elapsed().as_secs_f64());
            (dims, parts, classes) = (
                outputs.embedding_dims,
                outputs.embedding_parts,
                outputs.classes,
            );
            non_finite += outputs.non_finite;
            embeddings.push(outputs.embedding);
        }
        let mut problems = Vec::new();
        if non_finite > 0 {
            problems.push(format!("{non_finite} of its numbers are not finite"));
        } else {
            let is_constant = embeddings.windows(2).all(|two| two[0] == two[1]);
            if is_constant {
                problems.push(
                    "it gives the same answer to every input: does it expect another input range?"
                        .into(),
                );
            }
            let again = recognizer.run(&inputs[0], 1)?;
            let is_steady = again.embedding == embeddings[0];
            if !is_steady {
                problems.push(
                    "its answers to one input are not the same twice: was it exported in training mode, or does it \
                     use random numbers?"
                        .into(),
                );
            }
            let together = recognizer.run(&inputs.concat(), inputs.len())?;
            let together = together.embedding.chunks(dims.max(1));
            let pairs = embeddings.iter().zip(together);
            let pairs: Vec<_> = pairs
                .map(|(alone, other)| VectorPair::new(alone, other))
                .collect();
            let apart =
                AnswerDifference::measure(&pairs).map_or(0.0, |(found, _)| found.greatest_relative);
            if apart > Limits::FLOAT.relative_difference && is_steady {
                problems.push(format!(
                    "its answer to an input depends on the other inputs of the batch (relative difference {apart:.1e}): was it \
                     exported in training mode, or is it quantised dynamically?"
                ));
            }
        }
        Ok(Self {
            runtime: recognizer.runtime().clone(),
            inputs: inputs.len(),
            ms,
            embedding_dims: dims,
            embedding_parts: parts,
            classes,
            problems,
            embeddings,
        })
    }

    /// Returns the greatest difference between the answers of two runtimes, relative to their
    /// spread around their mean; none if they cannot be compared.
    pub(crate) fn apart(&self, other: &Self) -> Option<f64> {
        if self.embedding_dims != other.embedding_dims {
            return None;
        }
        let pairs = self.embeddings.iter().zip(&other.embeddings);
        let pairs: Vec<_> = pairs
            .map(|(own, other)| VectorPair::new(own, other))
            .collect();
        let (found, _) = AnswerDifference::measure(&pairs)?;
        found
            .greatest_relative
            .is_finite()
            .then_some(found.greatest_relative)
    }

    /// Returns whether the numbers of every answer are not negative and sum to 1, as after a
    /// softmax.
    pub(crate) fn is_softmax(&self) -> bool {
        let is_shares = |answer: &Vec<f32>| {
            let sum: f32 = answer.iter().sum();
            answer.len() > 1 && answer.iter().all(|share| *share >= 0.0) && (sum - 1.0).abs() < 1e-3
        };
        self.embeddings.iter().all(is_shares)
    }

    /// Returns whether a difference between two runtimes is within the limits.
    pub(crate) fn is_alike(apart: f64, is_quantized: bool) -> bool {
        let limits = if is_quantized {
            Limits::INT8
        } else {
            Limits::FLOAT
        };
        apart <= limits.relative_difference
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::Contract;
    use crate::inference::testing::MadeUp;
    use std::sync::atomic::{AtomicU32, Ordering};

    fn inputs() -> Vec<Vec<f32>> {
        [0.0, 0.25, 0.75].map(|pixel| vec![pixel; 1500]).to_vec()
    }

    fn checkup(answer: fn(&[f32]) -> Vec<f32>) -> Checkup {
        let recognizer = MadeUp::embedding(Contract::default(), answer);
        Checkup::run(&recognizer, &inputs()).expect("it answers")
    }

    #[test]
    fn a_model_that_answers_to_its_input_has_no_problem() {
        let found = checkup(|gei| vec![gei[0], 1.0]);
        assert_eq!(found.problems, [""; 0]);
        assert_eq!(
            (found.inputs, found.embedding_dims, found.embedding_parts),
            (3, 2, 1)
        );
        assert_eq!(found.apart(&found), Some(0.0));
        let other = checkup(|gei| vec![gei[0] * 1.01, 1.0]);
        let apart = found.apart(&other).expect("of one length");
        assert!(apart > 1e-3 && !Checkup::is_alike(apart, false) && Checkup::is_alike(apart, true));
        assert_eq!(found.apart(&checkup(|gei| vec![gei[0]])), None);
    }

    #[test]
    fn what_speaks_against_a_model_is_said() {
        let said = |answer: fn(&[f32]) -> Vec<f32>| checkup(answer).problems.join("; ");
        assert!(said(|_| vec![1.0, 2.0]).contains("the same answer to every input"));
        assert!(said(|gei| vec![gei[0] / 0.0, 1.0]).contains("are not finite"));
        static CALLS: AtomicU32 = AtomicU32::new(0);
        let twice = checkup(|gei| {
            let call = CALLS.fetch_add(1, Ordering::Relaxed);
            vec![gei[0] + call as f32, 1.0]
        });
        let said = twice.problems.join("; ");
        assert!(said.contains("same twice"), "{said}");
        let softmax = checkup(|gei| vec![0.75 - 0.25 * gei[0], 0.25 + 0.25 * gei[0]]);
        assert!(softmax.is_softmax());
        assert!(!checkup(|gei| vec![gei[0], 1.0]).is_softmax());
    }
}
