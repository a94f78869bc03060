//! The answers of recognizers to sequences.

use super::{Distance, Outputs, Recognizer};
use crate::dataset::sequences::{Form, SequenceSource, ShownCounts};
use crate::draw::template::Template;
use crate::error::{Error, InferenceError, Result};

/// The maximum number of values in a batch: 4 MB. Sequences of silhouettes are given one at a
/// time, and those of small networks one to each thread: each is already a batch of frames, for
/// which a large network needs 700 MB and a second, which is lost if the run is interrupted.
const MAX_NUMBERS: usize = 1 << 20;
/// The maximum number of templates in a batch.
const MAX_BATCH: usize = 512;
/// The maximum number of values in all answers of one recognizer: 1 GB.
const MAX_KEPT: usize = 1 << 28;

/// The answers of one recognizer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Answers {
    /// Embeddings, `[answer][number]`.
    pub embeddings: Vec<f32>,
    /// Numbers in one embedding.
    pub dims: usize,
    /// Parts of an embedding, compared separately.
    pub parts: usize,
    /// Class scores, `[answer][class]`; empty if the model has none.
    pub scores: Vec<f32>,
    /// Scores in one answer.
    pub classes: usize,
    /// The number of each sequence's answer, if it has one.
    rows: Vec<Option<u32>>,
}

impl Answers {
    /// Returns the embedding of a sequence; empty if the recognizer was not given it.
    #[must_use]
    pub(crate) fn embedding(&self, sequence: usize) -> &[f32] {
        self.row(sequence, &self.embeddings, self.dims)
    }

    /// Returns the class scores of a sequence; empty if there are none.
    #[must_use]
    pub(crate) fn scores(&self, sequence: usize) -> &[f32] {
        self.row(sequence, &self.scores, self.classes)
    }

    fn row<'a>(&self, sequence: usize, numbers: &'a [f32], width: usize) -> &'a [f32] {
        let row = self.rows.get(sequence).copied().flatten();
        let begin = row.map(|row| row as usize * width);
        begin
            .and_then(|begin| numbers.get(begin..begin + width))
            .unwrap_or_default()
    }
}

/// A recognizer, and the sequences that it is shown.
#[derive(Clone, Copy)]
pub(crate) struct RecognizerNeeds<'a> {
    pub recognizer: &'a dyn Recognizer,
    /// Whether it needs a sequence.
    pub needs: &'a dyn Fn(usize) -> bool,
}

/// A recognizer with its answers so far and its pending inputs.
struct Listener<'a> {
    recognizer: &'a dyn Recognizer,
    needs: &'a dyn Fn(usize) -> bool,
    answers: Answers,
    waiting: Vec<usize>,
    input: Vec<f32>,
    /// The end of each waiting sequence in the input.
    ends: Vec<usize>,
}

impl Listener<'_> {
    fn take(&mut self, sequence: usize, bytes: &[u8], seen_from: Option<(f64, f64)>) -> Result<()> {
        let at_once = match self.recognizer.contract().template {
            Template::Silhouettes => rayon::current_num_threads(),
            _ => MAX_BATCH,
        };
        let most = self.recognizer.at_once().clamp(1, at_once);
        if self.waiting.len() == most || self.input.len() + bytes.len() > MAX_NUMBERS {
            self.answer()?;
        }
        let contract = self.recognizer.contract();
        contract.feed(bytes, &mut self.input);
        contract.feed_view(seen_from, &mut self.input)?;
        self.waiting.push(sequence);
        self.ends.push(self.input.len());
        Ok(())
    }

    fn answer(&mut self) -> Result<()> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        let waiting = std::mem::take(&mut self.waiting);
        if self.recognizer.contract().template == Template::Silhouettes {
            let begins = std::iter::once(0).chain(self.ends.iter().copied());
            let each = begins.zip(self.ends.iter().copied());
            let inputs: Vec<&[f32]> = each.map(|(begin, end)| &self.input[begin..end]).collect();
            let outputs = at_the_same_time(self.recognizer, &inputs);
            for (outputs, sequence) in outputs.into_iter().zip(waiting) {
                self.keep(outputs?, &[sequence])?;
            }
        } else {
            let outputs = self.recognizer.run(&self.input, waiting.len())?;
            self.keep(outputs, &waiting)?;
        }
        self.input.clear();
        self.ends.clear();
        Ok(())
    }

    /// Keeps the answers to these sequences.
    fn keep(&mut self, outputs: Outputs, sequences: &[usize]) -> Result<()> {
        let Outputs {
            embedding,
            embedding_dims,
            embedding_parts,
            scores,
            classes,
            ..
        } = outputs;
        let contract = self.recognizer.contract();
        let viewpoints = contract.training.viewpoints.len();
        if contract.distance == Distance::View && embedding_parts != viewpoints {
            return Err(InferenceError::Output {
                model: self.recognizer.name().to_owned(),
                output: "embedding".into(),
                expected: format!("{viewpoints} parts, one for each of training.viewpoints"),
                found: format!("{embedding_parts}"),
            }
            .into());
        }
        let answers = &mut self.answers;
        let answered = answers
            .embeddings
            .len()
            .checked_div(answers.dims)
            .unwrap_or(0);
        if answered > 0 && answers.dims != embedding_dims {
            return Err(InferenceError::Lengths {
                model: self.recognizer.name().to_owned(),
                before: answers.dims,
                found: embedding_dims,
            }
            .into());
        }
        if answers.embeddings.len() + embedding.len() > MAX_KEPT {
            return Err(InferenceError::TooManyNumbers {
                model: self.recognizer.name().to_owned(),
                most: MAX_KEPT,
            }
            .into());
        }
        for (row, &sequence) in sequences.iter().enumerate() {
            answers.rows[sequence] = u32::try_from(answered + row).ok();
        }
        (answers.dims, answers.parts) = (embedding_dims, embedding_parts);
        answers.embeddings.extend(embedding);
        answers.classes = classes;
        answers.scores.extend(scores.into_iter().flatten());
        Ok(())
    }
}

/// Runs a recognizer on each input, on a thread for each.
fn at_the_same_time(recognizer: &dyn Recognizer, inputs: &[&[f32]]) -> Vec<Result<Outputs>> {
    if let [input] = inputs {
        return vec![recognizer.run(input, 1)];
    }
    std::thread::scope(|scope| {
        let start = |&input| {
            std::thread::Builder::new().spawn_scoped(scope, move || recognizer.run(input, 1))
        };
        let started: Vec<_> = inputs.iter().map(start).collect();
        let ended = started.into_iter().map(|thread| match thread {
            Ok(thread) => match thread.join() {
                Ok(outputs) => outputs,
                Err(panic) => std::panic::resume_unwind(panic),
            },
            Err(error) => Err(Error::Threads(error)),
        });
        ended.collect()
    })
}

/// Gives the sequences of these ascending numbers to all recognizers, in one form; each recognizer
/// gets those that it needs. Calls `seen` for each of them.
///
/// # Errors
/// If a sequence cannot be rendered or read, or a recognizer fails; the error of `seen`.
pub(crate) fn ask(
    recognizers: &[RecognizerNeeds<'_>],
    source: &SequenceSource<'_>,
    wanted: &[usize],
    form: &Form,
    seen: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
) -> Result<(Vec<Answers>, ShownCounts)> {
    let mut listeners: Vec<Listener<'_>> = recognizers
        .iter()
        .map(|&RecognizerNeeds { recognizer, needs }| Listener {
            recognizer,
            needs,
            answers: Answers {
                rows: vec![None; source.sequences().list.len()],
                ..Answers::default()
            },
            waiting: Vec::new(),
            input: Vec::new(),
            ends: Vec::new(),
        })
        .collect();
    let shown = source.show(wanted, form, &mut |sequence, bytes| {
        seen(sequence, bytes)?;
        let seen_from = source.sequences().view_label(sequence).angles_deg();
        listeners
            .iter_mut()
            .filter(|listener| (listener.needs)(sequence))
            .try_for_each(|listener| listener.take(sequence, bytes, seen_from))
    })?;
    let done = |mut listener: Listener<'_>| listener.answer().map(|()| listener.answers);
    let answers = listeners.into_iter().map(done).collect::<Result<_>>()?;
    Ok((answers, shown))
}
