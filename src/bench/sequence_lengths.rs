//! The costs of sequences of several lengths, for models that take any number of frames.

use super::board::{LoadWatch, MachineState};
use super::measure::shape_and_macs;
use super::memory;
use super::results::{LeftOut, Length};
use super::task::Task;
use super::time_budget::{Cap, WorkKind};
use super::timed_model::{FirstInference, LoadedModel, TimedWork, Watched, beside};
use crate::draw::template::Template;
use crate::error::{Error, Result};
use crate::inference::Model;

/// Rejects a model whose inputs have a fixed length.
///
/// # Errors
/// If the inputs have a fixed length, which the error states.
pub(crate) fn require_any_length(model: &Model) -> Result<()> {
    let contract = model.contract();
    let found = match (contract.template, contract.frames) {
        (Template::Silhouettes, None) => return Ok(()),
        (Template::Silhouettes, Some(frames)) => format!("one of {frames} frames"),
        (template, _) => format!("one of {}", template.plural()),
    };
    Err(Error::input(
        model.path(),
        format!("expected a model of sequences of any number of frames, found {found}"),
    ))
}

/// Measures a task's model on inputs of these lengths, in ascending order, each within its share of
/// the time, and returns what was cut as well. The model is loaded again for each length, so that
/// memory that a runtime keeps does not count for the next.
///
/// # Errors
/// If the model cannot be loaded, its input cannot be drawn, or an inference fails.
pub(crate) fn measure_lengths(
    task: &Task<'_>,
    lengths: &[usize],
) -> Result<(Vec<Length>, Option<LeftOut>)> {
    let plan = &task.plan;
    let start = MachineState::read(task.root);
    let LoadedModel {
        runtime,
        model,
        recognizer,
        baseline,
        ..
    } = LoadedModel::load(task)?;
    let contract = model.contract();
    let mut ready = Some(recognizer);
    let to_come = lengths.iter().map(|&frames| WorkKind {
        what: format!("{}: length {frames}", contract.name),
        full_s: 0.0,
        weight: frames as f64,
    });
    let cap = Cap::new(task.most, to_come.collect(), task.tell);
    let mut watched = Watched::new(task.root, start, cap);
    let mut found = Vec::with_capacity(lengths.len());
    let mut cut = Vec::new();
    for (at, &frames) in lengths.iter().enumerate() {
        let recognizer = match ready.take() {
            Some(recognizer) => recognizer,
            None => runtime.load(&model)?,
        };
        let recognizer = recognizer.as_ref();
        let input = task.scene.sequence(contract, frames)?;
        memory::forget_peak();
        let others = LoadWatch::start(task.root);
        let to_come: usize = lengths[at..].iter().sum();
        let most_s = watched.cap.left_s() * frames as f64 / to_come as f64 / 2.0;
        let first = FirstInference::measure(recognizer, &input, plan, most_s)?;
        // The estimate grows linearly with the frames.
        let full_s = |other: &usize| plan.takes_s(first.call_s * *other as f64 / frames as f64, 1);
        let expected: Vec<f64> = lengths[at..].iter().map(full_s).collect();
        watched.cap.expect(&expected);
        let share = watched.cap.begin(expected[0]);
        let call = &TimedWork {
            plan,
            share: &share,
            call_s: first.call_s,
            batch: 1,
        };
        let measured = beside(recognizer, &input, call, &mut watched)?;
        let (input, macs) = shape_and_macs(&model, contract, frames);
        if let Some(less) = measured.timing.cut() {
            cut.push(format!("length {frames}: {less}"));
        }
        found.push(Length {
            frames,
            input,
            macs: macs.ok(),
            first_ms: first.first_ms,
            timing: measured.timing,
            peak_rss_bytes: first.peak_rss_bytes,
            peak_rss_over_baseline_bytes: baseline.below(first.peak_rss_bytes),
            others_busy: others.and_then(|others| others.share(task.root)),
        });
    }
    let cut = (!cut.is_empty()).then(|| LeftOut {
        what: cut,
        full_seconds: watched.cap.full_s(),
    });
    Ok((found, cut))
}
