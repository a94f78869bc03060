//! Measures one model in this process, which should do nothing else.
//!
//! A timed call is [`Recognizer::run`](crate::inference::Recognizer::run) on an input in memory, with
//! all its checks, until its outputs are in vectors. Drawing the input is not timed, except in the
//! end-to-end times.

use super::accuracy::Accuracy;
use super::batch::{Sized, batch};
use super::board::{Board, LOAD_WARNED_OF, LoadWatch, MachineState, warnings};
use super::conditions::MachineConditions;
use super::inputs::DrawnInputs;
use super::memory;
use super::results::{AnswerParts, BareLoops, Energy, LeftOut, ModelResult, Offline, millijoules};
use super::task::Task;
use super::time_budget::{Cap, WorkKind};
use super::timed_model::{
    FirstInference, LoadedModel, TimedWork, Watched, beside, seconds_of, timed,
};
use super::windows::TimingPlan;
use crate::error::Result;
use crate::evaluate::contest::Entrant;
use crate::inference::BareOutputs;
use crate::inference::{Contract, Model, Recognizer};

/// The largest spread of the means of windows, relative to the median, without a warning. Our
/// choice.
const STEADY: f64 = 0.15;

/// The number of inferences in a profile by operator. Our choice.
const PROFILED: usize = 20;

/// Returns the kinds of work in order, each with its weight in sharing the time if there is too
/// little for all. The weights are our choice: a user first asks how long one inference takes.
fn kinds(task: &Task<'_>) -> Vec<(String, f64)> {
    let batches = task.batches.iter();
    let of_batch = |size: &usize| match task.batches {
        [_] => "batches".to_owned(),
        _ => format!("batches of {size}"),
    };
    let batches = batches.map(|size| (of_batch(size), 4.0));
    let parts = [("drawing", 1.0), ("drawing and inference", 2.0)];
    let rank1 = task.with_accuracy.then_some(("rank-1", 3.0));
    let named = |(what, weight): (&str, f64)| (what.to_owned(), weight);
    std::iter::once(named(("one at a time", 12.0)))
        .chain(batches)
        .chain(parts.into_iter().chain(rank1).map(named))
        .collect()
}

/// Measures a model as the task specifies.
///
/// # Errors
/// If the model cannot be loaded, its input cannot be drawn, or an inference fails.
pub(crate) fn measure(task: &Task<'_>) -> Result<ModelResult> {
    // Drawing runs on one thread of its own, so that its time is comparable with the inference's.
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let contract = (task.open)()?.contract().clone();
    let (scene, plan) = (&task.scene, &task.plan);
    let mut single = Vec::new();
    let draw_s = seconds_of(&mut || {
        alone.install(|| {
            single = scene.inputs(&contract, 1)?;
            Ok(())
        })
    })?;

    let start = MachineState::read(task.root);
    let others = LoadWatch::start(task.root);
    let loaded = LoadedModel::of(task)?;
    let to_come = kinds(task).into_iter().map(|(what, weight)| WorkKind {
        what: format!("{}: {what}", contract.name),
        full_s: 0.0,
        weight,
    });
    let cap = Cap::new(task.most, to_come.collect(), task.tell);
    let mut watched = Watched::new(task.root, start, cap);
    let most_s = watched.cap.left_s() / 3.0;
    let first = FirstInference::of(loaded.recognizer.as_ref(), &single, plan, most_s)?;

    let peak_rss_over_baseline_bytes = loaded.baseline.below(first.peak_rss_bytes);
    let entrants = [Entrant {
        recognizer: loaded.recognizer,
        settings: scene.settings,
    }];
    let recognizer = entrants[0].recognizer.as_ref();
    let pictures = task
        .with_accuracy
        .then(|| Accuracy::pictures(&entrants, scene, scene.views));
    let pictures = pictures.transpose();
    let rank1_s = |call_s: f64, draw_s: f64| {
        let pictures = pictures.as_ref().copied().ok().flatten().unwrap_or(0);
        // Images are drawn by all threads and recognized one after the other.
        pictures as f64 * (call_s + draw_s / rayon::current_num_threads() as f64)
    };
    let expected = |call_s: f64| -> Vec<f64> {
        let batches = task.batches.iter();
        let batches = batches.map(|&size| plan.takes_s(size as f64 * call_s, size));
        let others = [
            plan.takes_s(draw_s, 1),
            plan.takes_s(draw_s + call_s, 1),
            rank1_s(call_s, draw_s),
        ];
        batches.chain(others).collect()
    };
    let kinds = if task.bare { 3.0 } else { 1.0 };
    let full_s = kinds * plan.takes_s(first.call_s, 1);
    watched
        .cap
        .expect(&[&[full_s], &expected(first.call_s)[..]].concat());
    let share = watched.cap.begin(full_s);
    let (one, bare) = if task.bare {
        let mut ours = || recognizer.run(&single, 1).map(drop);
        let mut plain = loaded
            .runtime
            .bare(&loaded.model, &single, BareOutputs::New)?;
        let mut reusing = loaded
            .runtime
            .bare(&loaded.model, &single, BareOutputs::Reused)?;
        let works: [&mut dyn FnMut() -> Result<()>; 3] =
            [&mut ours, &mut || plain().map(drop), &mut || {
                reusing().map(drop)
            }];
        let [ours, plain, reusing] = timed(
            &TimedWork {
                plan,
                share: &share,
                call_s: first.call_s,
                batch: 1,
            },
            works,
            &mut watched,
        )?;
        let compared = BareLoops::of(&ours.windows, &plain.windows, &reusing.windows);
        (ours, compared)
    } else {
        let call = &TimedWork {
            plan,
            share: &share,
            call_s: first.call_s,
            batch: 1,
        };
        (beside(recognizer, &single, call, &mut watched)?, None)
    };
    let call_s = one.timing.times.p50_us * 1e-6;
    watched.cap.expect(&expected(call_s));

    let mut cut = Vec::new();
    let mut batches = Vec::new();
    for (asked, full_s) in task.batches.iter().copied().zip(expected(call_s)) {
        let share = watched.cap.begin(full_s);
        let size = {
            let draw = |count| alone.install(|| scene.inputs(&contract, count));
            batch(
                recognizer,
                &draw,
                &first,
                &TimedWork {
                    plan,
                    share: &share,
                    call_s,
                    batch: asked,
                },
            )?
        };
        cut.extend(size.less_than(asked));
        if let Sized::Of(size, _) = size {
            memory::forget_peak();
            let input = alone.install(|| scene.inputs(&contract, size))?;
            let call_s = seconds_of(&mut || recognizer.run(&input, size).map(drop))?;
            let call = &TimedWork {
                plan,
                share: &share,
                call_s,
                batch: size,
            };
            let measured = beside(recognizer, &input, call, &mut watched)?;
            batches.push((asked, size, measured, memory::peak_rss_bytes()));
        }
    }
    let parts = alone.install(|| parts(scene, plan, recognizer, call_s, &mut watched))?;
    let accuracy = match pictures {
        Err(error) => Err(error),
        Ok(None) => Ok(None),
        Ok(Some(all)) => {
            let full_s = rank1_s(call_s, parts.preprocessing.times.p50_us * 1e-6);
            let share = watched.cap.begin(full_s);
            let most = (full_s > share.most_s).then(|| share_of(all, share.most_s / full_s));
            Accuracy::within(&entrants, &task.scene, task.seed, most)
        }
    };
    let others_busy = others.and_then(|others| others.share(task.root));
    let Watched {
        states, meter, cap, ..
    } = watched;
    let largest = batches.iter().max_by_key(|(_, size, ..)| *size);
    let energy = meter.and_then(|meter| {
        Some(Energy {
            source: meter.source().to_owned(),
            single_mj: millijoules(&one.windows, 1)?,
            offline_mj: largest
                .and_then(|(_, size, measured, _)| millijoules(&measured.windows, *size)),
        })
    });
    let mut batches = batches
        .into_iter()
        .map(|(asked, size, measured, peak_rss_bytes)| Offline {
            batch: size,
            batch_planned: Some(asked),
            timing: measured.timing,
            peak_rss_bytes,
        });
    let offline = batches.next();
    let batches: Vec<Offline> = batches.collect();
    let name = recognizer.name().to_owned();

    let affinity = Board::read(task.root).affinity;
    let mut found = warnings(&states, affinity.as_ref());
    let broken = accuracy
        .as_ref()
        .is_ok_and(|found| found.as_ref().is_some_and(|(it, _)| it.non_finite > 0));
    if first.non_finite > 0 || broken {
        found.push("some outputs are not finite numbers".into());
    }
    let single_timing = one.timing;
    if single_timing.spread > STEADY {
        found.push(format!(
            "the means of the windows differ by {:.0} %: measure again on an idle machine",
            100.0 * single_timing.spread
        ));
    }
    match &accuracy {
        Ok(accuracy) => found.extend(accuracy.iter().flat_map(|(_, doubts)| doubts).cloned()),
        Err(error) => found.push(format!("rank-1 could not be measured: {error}")),
    }
    if let Some(share) = others_busy.filter(|share| *share > LOAD_WARNED_OF) {
        found.push(format!(
            "other processes kept {:.0} % of the processors busy while it was measured",
            100.0 * share
        ));
    }
    let operators = match task.with_operators {
        true => {
            // As many inferences as there is time for; the first does not count.
            let most = (cap.left_s() / call_s).clamp(2.0, PROFILED as f64);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "between 2 and 20"
            )]
            let runs = most as usize;
            loaded
                .runtime
                .operator_times(&loaded.model, &single, runs)?
        }
        false => None,
    };
    if task.with_operators && operators.is_none() {
        found.push(
            "the time of each operator is unknown: the embedded runtime does not report it".into(),
        );
    }
    found.extend(loaded.model.own_warnings());
    let graph = loaded.model.graph();
    let of_batch = |it: &'_ Offline| match task.batches {
        [_] => "batches".to_owned(),
        _ => format!("batches of {}", it.batch),
    };
    let named = |what: &str| what.to_owned();
    let timings = std::iter::once((named("one at a time"), &single_timing))
        .chain(
            offline
                .iter()
                .chain(&batches)
                .map(|it| (of_batch(it), &it.timing)),
        )
        .chain([
            (named("drawing"), &parts.preprocessing),
            (named("drawing and inference"), &parts.end_to_end),
        ]);
    cut.extend(match &accuracy {
        Ok(found) if task.with_accuracy => {
            Accuracy::less(found.as_ref().map(|(it, _)| it), scene.views.list.len())
        }
        _ => None,
    });
    let less = timings.filter_map(|(what, timing)| {
        let cut = timing.cut()?;
        Some(format!("{what}: {cut}"))
    });
    let cut = [less.collect(), cut].concat();
    let (input, macs) = shape_and_macs(
        &loaded.model,
        &contract,
        contract.frames_in(single.len(), 1)?,
    );
    Ok(ModelResult {
        name,
        runtime: recognizer.runtime().clone(),
        threads: task.threads,
        input,
        bytes: loaded.model.bytes().len() as u64,
        params: graph.parameters,
        macs: macs.as_ref().ok().copied(),
        macs_unknown: macs.err(),
        runtime_load_ms: loaded.runtime_load_ms,
        load_ms: loaded.load_ms,
        first_ms: first.first_ms,
        single: single_timing,
        peak_rss_bytes: first.peak_rss_bytes,
        peak_rss_over_baseline_bytes,
        offline,
        batches,
        operators: operators.unwrap_or_default(),
        parts,
        bare,
        energy,
        accuracy: accuracy.ok().flatten().map(|(accuracy, _)| accuracy),
        lengths: Vec::new(),
        max_seconds: task.most.map(|most| most.as_secs_f64()),
        seconds: Some(cap.taken_s()),
        cut: (!cut.is_empty()).then(|| LeftOut {
            what: cut,
            full_seconds: cap.full_s(),
        }),
        conditions: MachineConditions::of(&states),
        others_busy,
        warnings: found,
    })
}

/// Returns the shape of an input of `frames` frames, and its multiply-accumulates.
pub(super) fn shape_and_macs(
    model: &Model,
    contract: &Contract,
    frames: usize,
) -> (Vec<usize>, std::result::Result<u64, String>) {
    let input = contract.input_shape(1, frames);
    let shape: Vec<u64> = input.iter().map(|&size| size as u64).collect();
    (input, model.graph().macs(&shape))
}

/// Returns this share of a number of images, rounded down.
fn share_of(pictures: usize, share: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from none to all of them"
    )]
    let some = (pictures as f64 * share) as usize;
    some
}

/// Times drawing alone, then drawing and inference; the walks take turns.
fn parts(
    scene: &DrawnInputs<'_>,
    plan: &TimingPlan,
    recognizer: &dyn Recognizer,
    call_s: f64,
    watch: &mut Watched<'_>,
) -> Result<AnswerParts> {
    let contract = recognizer.contract();
    let mut at = 0;
    let mut input = Vec::new();
    let mut draw = || {
        input.clear();
        at += 1;
        scene.append_input(contract, at, &mut input)
    };
    let draw_s = seconds_of(&mut draw)?;
    let share = watch.cap.begin(plan.takes_s(draw_s, 1));
    let [preprocessing] = timed(
        &TimedWork {
            plan,
            share: &share,
            call_s: draw_s,
            batch: 1,
        },
        [&mut draw],
        watch,
    )?;
    let mut both = || {
        input.clear();
        at += 1;
        scene.append_input(contract, at, &mut input)?;
        recognizer.run(&input, 1).map(drop)
    };
    let both_s = draw_s + call_s;
    let share = watch.cap.begin(plan.takes_s(both_s, 1));
    let [end_to_end] = timed(
        &TimedWork {
            plan,
            share: &share,
            call_s: both_s,
            batch: 1,
        },
        [&mut both],
        watch,
    )?;
    Ok(AnswerParts {
        preprocessing: preprocessing.timing,
        end_to_end: end_to_end.timing,
    })
}
