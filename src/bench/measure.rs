//! Measures one model in this process, which should do nothing else.
//!
//! A timed call is [`Recognizer::run`](crate::inference::Recognizer::run) on an input in memory, with
//! all its checks, until its outputs are in vectors. Drawing the input is not timed, except in the
//! end-to-end times.

use super::accuracy::Accuracy;
use super::batch::{Sized, batch};
use super::board::{Board, LOAD_WARNED_OF, LoadWatch, MachineState, warnings};
use super::conditions::MachineConditions;
use super::energy::Meter;
use super::inputs::DrawnInputs;
use super::memory;
use super::results::{AnswerParts, BareLoops, Energy, LeftOut, ModelResult, Offline, millijoules};
use super::task::Task;
use super::time_budget::{Cap, WorkKind};
use super::timed_model::{
    FirstInference, LoadedModel, MeasuredWindows, TimedWork, Watched, beside, seconds_of, timed,
};
use super::timing::Timing;
use super::windows::TimingPlan;
use crate::error::Result;
use crate::evaluate::contest::Entrant;
use crate::inference::BareOutputs;
use crate::inference::{Contract, Model, OperatorTime, Recognizer, Runtime};
use rayon::ThreadPool;

/// The largest spread of the means of windows, relative to the median, without a warning. Our
/// choice.
const STEADY: f64 = 0.15;

/// The warning if the time of each operator is requested from the embedded runtime.
const NO_OPERATORS: &str =
    "the time of each operator is unknown: the embedded runtime does not report it";

/// The number of inferences in a profile by operator. Our choice.
const PROFILED: usize = 20;

/// Returns the name of the work on batches of this size.
fn of_batches(task: &Task<'_>, size: usize) -> String {
    match task.batches {
        [_] => "batches".to_owned(),
        _ => format!("batches of {size}"),
    }
}

/// Returns the kinds of work with a model in order, each with its weight in sharing the time if there is too
/// little for all. The weights are our choice: a user first asks how long one inference takes.
fn kinds(task: &Task<'_>, model: &str) -> Vec<WorkKind> {
    let kind = |what: &str, weight| WorkKind {
        what: format!("{model}: {what}"),
        full_s: 0.0,
        weight,
    };
    let batches = task.batches.iter();
    let batches = batches.map(|&size| kind(&of_batches(task, size), 4.0));
    let parts = [kind("drawing", 1.0), kind("drawing and inference", 2.0)];
    std::iter::once(kind("one at a time", 12.0))
        .chain(batches)
        .chain(parts)
        .chain(task.with_accuracy.then(|| kind("rank-1", 3.0)))
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
    let scene = &task.scene;
    let mut single = Vec::new();
    let mut draw = || {
        single = alone.install(|| scene.inputs(&contract, 1))?;
        Ok(())
    };
    let draw_s = seconds_of(&mut draw)?;

    let start = MachineState::read(task.root);
    let others = LoadWatch::start(task.root);
    let loaded = LoadedModel::load(task)?;
    let cap = Cap::new(task.most, kinds(task, &contract.name), task.tell);
    let mut watched = Watched::new(task.root, start, cap);
    let most_s = watched.cap.left_s() / 3.0;
    let first = FirstInference::measure(loaded.recognizer.as_ref(), &single, &task.plan, most_s)?;

    let entrants = [Entrant {
        recognizer: loaded.recognizer,
        settings: scene.settings,
        model_bytes: None,
    }];
    let mut measured = MeasuredModel {
        task,
        runtime: loaded.runtime,
        model: loaded.model,
        entrants,
        contract,
        alone,
        single,
        draw_s,
        first,
        pictures: 0,
    };
    let pictures = measured.pictures();
    measured.pictures = *pictures.as_ref().unwrap_or(&0);
    let (one, bare) = measured.one_at_a_time(&mut watched)?;
    let call_s = one.timing.times.p50_us * 1e-6;
    watched.cap.expect(&measured.expected(call_s));
    let (batches, cut) = measured.batches(call_s, &mut watched)?;
    let parts = measured.parts(call_s, &mut watched)?;
    let accuracy = pictures.and_then(|_| measured.accuracy(call_s, &parts, &mut watched));
    let others_busy = others.and_then(|others| others.share(task.root));
    let Watched {
        states, meter, cap, ..
    } = watched;
    let energy = meter.and_then(|meter| energy(&meter, &one, &batches));
    let operators = measured.operators(cap.left_s() / call_s)?;

    let mut found = warnings(&states, Board::read(task.root).affinity.as_ref());
    found.extend(measured.doubts(&one.timing, &accuracy));
    found.extend(others_busy.and_then(busy));
    let lacks_operators = task.with_operators && operators.is_none();
    found.extend(lacks_operators.then(|| NO_OPERATORS.into()));
    found.extend(measured.model.own_warnings());
    let offline = batches.into_iter().map(MeasuredBatch::offline);
    let offline: Vec<Offline> = offline.collect();
    let mut left_out = shortened(task, &one.timing, &offline, &parts);
    left_out.extend(cut.into_iter().chain(measured.less_rank1(&accuracy)));
    let mut offline = offline.into_iter();
    let (model, first, recognizer) = (&measured.model, &measured.first, measured.recognizer());
    let frames = measured.contract.frames_in(measured.single.len(), 1)?;
    let (input, macs) = shape_and_macs(model, &measured.contract, frames);
    Ok(ModelResult {
        name: recognizer.name().to_owned(),
        runtime: recognizer.runtime().clone(),
        threads: task.threads,
        input,
        bytes: model.bytes().len() as u64,
        params: model.graph().parameters,
        macs: macs.as_ref().ok().copied(),
        macs_unknown: macs.err(),
        runtime_load_ms: loaded.runtime_load_ms,
        load_ms: loaded.load_ms,
        first_ms: first.first_ms,
        single: one.timing,
        peak_rss_bytes: first.peak_rss_bytes,
        peak_rss_over_baseline_bytes: loaded.baseline.below(first.peak_rss_bytes),
        offline: offline.next(),
        batches: offline.collect(),
        operators: operators.unwrap_or_default(),
        parts,
        bare,
        energy,
        accuracy: accuracy.ok().flatten(),
        lengths: Vec::new(),
        max_seconds: task.most.map(|most| most.as_secs_f64()),
        seconds: Some(cap.taken_s()),
        cut: (!left_out.is_empty()).then(|| LeftOut {
            what: left_out,
            full_seconds: cap.full_s(),
        }),
        conditions: MachineConditions::from_states(&states),
        others_busy,
        warnings: found,
    })
}

/// A loaded model after its first inference, and what its measurement needs.
struct MeasuredModel<'a> {
    task: &'a Task<'a>,
    runtime: Runtime,
    model: Model,
    /// The model as the only entrant of a contest.
    entrants: [Entrant; 1],
    contract: Contract,
    /// The thread that draws.
    alone: ThreadPool,
    /// One input.
    single: Vec<f32>,
    /// The time in which it was drawn, seconds.
    draw_s: f64,
    first: FirstInference,
    /// The number of images that measuring rank-1 takes; 0 if it is not measured.
    pictures: usize,
}

/// The measurement of one size of batches.
struct MeasuredBatch {
    asked: usize,
    size: usize,
    measured: MeasuredWindows,
    peak_rss_bytes: Option<u64>,
}

impl MeasuredBatch {
    fn offline(self) -> Offline {
        Offline {
            batch: self.size,
            batch_planned: Some(self.asked),
            timing: self.measured.timing,
            peak_rss_bytes: self.peak_rss_bytes,
        }
    }
}

impl MeasuredModel<'_> {
    fn recognizer(&self) -> &dyn Recognizer {
        self.entrants[0].recognizer.as_ref()
    }

    /// Returns the number of images that measuring rank-1 takes.
    fn pictures(&self) -> Result<usize> {
        let scene = &self.task.scene;
        match self.task.with_accuracy {
            true => Accuracy::pictures(&self.entrants, scene, scene.views),
            false => Ok(0),
        }
    }

    /// Returns the estimated time of measuring rank-1, seconds.
    fn rank1_s(&self, call_s: f64, draw_s: f64) -> f64 {
        // Images are drawn by all threads and recognized one after the other.
        self.pictures as f64 * (call_s + draw_s / rayon::current_num_threads() as f64)
    }

    /// Returns the estimated times of all work after single inferences, seconds.
    fn expected(&self, call_s: f64) -> Vec<f64> {
        let plan = &self.task.plan;
        let batches = self.task.batches.iter();
        let batches = batches.map(|&size| plan.takes_s(size as f64 * call_s, size));
        let others = [
            plan.takes_s(self.draw_s, 1),
            plan.takes_s(self.draw_s + call_s, 1),
            self.rank1_s(call_s, self.draw_s),
        ];
        batches.chain(others).collect()
    }

    /// Times single inferences, beside loops around the runtime alone if the task asks for these.
    fn one_at_a_time(
        &self,
        watched: &mut Watched<'_>,
    ) -> Result<(MeasuredWindows, Option<BareLoops>)> {
        let (recognizer, single, plan) = (self.recognizer(), &self.single, &self.task.plan);
        let call_s = self.first.call_s;
        let kinds = if self.task.bare { 3.0 } else { 1.0 };
        let full_s = kinds * plan.takes_s(call_s, 1);
        let expected = [&[full_s], &self.expected(call_s)[..]].concat();
        watched.cap.expect(&expected);
        let call = &TimedWork {
            plan,
            share: &watched.cap.begin(full_s),
            call_s,
            batch: 1,
        };
        if !self.task.bare {
            return Ok((beside(recognizer, single, call, watched)?, None));
        }
        let bare = |outputs| self.runtime.bare(&self.model, single, outputs);
        let mut ours = || recognizer.run(single, 1).map(drop);
        let mut plain = bare(BareOutputs::New)?;
        let mut reusing = bare(BareOutputs::Reused)?;
        let works: [&mut dyn FnMut() -> Result<()>; 3] =
            [&mut ours, &mut || plain().map(drop), &mut || {
                reusing().map(drop)
            }];
        let [ours, plain, reusing] = timed(call, works, watched)?;
        let compared = BareLoops::compare(&ours.windows, &plain.windows, &reusing.windows);
        Ok((ours, compared))
    }

    /// Times batches, and returns how they are smaller than requested.
    fn batches(
        &self,
        call_s: f64,
        watched: &mut Watched<'_>,
    ) -> Result<(Vec<MeasuredBatch>, Vec<String>)> {
        let (recognizer, plan) = (self.recognizer(), &self.task.plan);
        let (scene, contract) = (&self.task.scene, &self.contract);
        let draw = |count| self.alone.install(|| scene.inputs(contract, count));
        let (mut batches, mut cut) = (Vec::new(), Vec::new());
        for (asked, full_s) in self.task.batches.iter().copied().zip(self.expected(call_s)) {
            let share = &watched.cap.begin(full_s);
            let work = TimedWork {
                plan,
                share,
                call_s,
                batch: asked,
            };
            let size = batch(recognizer, &draw, &self.first, &work)?;
            cut.extend(size.less_than(asked));
            if let Sized::Of(size, _) = size {
                memory::forget_peak();
                let input = draw(size)?;
                let call_s = seconds_of(&mut || recognizer.run(&input, size).map(drop))?;
                let call = &TimedWork {
                    call_s,
                    batch: size,
                    ..work
                };
                batches.push(MeasuredBatch {
                    asked,
                    size,
                    measured: beside(recognizer, &input, call, watched)?,
                    peak_rss_bytes: memory::peak_rss_bytes(),
                });
            }
        }
        Ok((batches, cut))
    }

    /// Times drawing alone, then drawing and inference; the walks take turns.
    fn parts(&self, call_s: f64, watched: &mut Watched<'_>) -> Result<AnswerParts> {
        let (scene, plan, recognizer) = (&self.task.scene, &self.task.plan, self.recognizer());
        self.alone
            .install(|| parts(scene, plan, recognizer, call_s, watched))
    }

    /// Measures rank-1 within its share of the time, if the task asks for it.
    fn accuracy(
        &self,
        call_s: f64,
        parts: &AnswerParts,
        watched: &mut Watched<'_>,
    ) -> Result<Option<Accuracy>> {
        if !self.task.with_accuracy {
            return Ok(None);
        }
        let full_s = self.rank1_s(call_s, parts.preprocessing.times.p50_us * 1e-6);
        let share = watched.cap.begin(full_s);
        let most = (full_s > share.most_s).then(|| share_of(self.pictures, share.most_s / full_s));
        let (entrants, scene, seed) = (&self.entrants, &self.task.scene, self.task.seed);
        let all = rayon::ThreadPoolBuilder::new().build()?;
        all.install(|| Accuracy::within(entrants, scene, seed, most))
    }

    /// Returns the time of each operator, if the task asks for them and the runtime reports them.
    /// Measures as many inferences as there is time for; the first does not count.
    fn operators(&self, most: f64) -> Result<Option<Vec<OperatorTime>>> {
        if !self.task.with_operators {
            return Ok(None);
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 2 and 20"
        )]
        let runs = most.clamp(2.0, PROFILED as f64) as usize;
        self.runtime.operator_times(&self.model, &self.single, runs)
    }

    /// Describes what is less than planned of rank-1.
    fn less_rank1(&self, accuracy: &Result<Option<Accuracy>>) -> Option<String> {
        let found = accuracy.as_ref().ok().filter(|_| self.task.with_accuracy)?;
        Accuracy::less(found.as_ref(), self.task.scene.views.list.len())
    }

    /// Returns warnings about answers, and about the spread of times.
    fn doubts(&self, single: &Timing, accuracy: &Result<Option<Accuracy>>) -> Vec<String> {
        let mut found = Vec::new();
        let measured = accuracy.as_ref().ok().and_then(Option::as_ref);
        if self.first.non_finite > 0 || measured.is_some_and(|it| it.non_finite > 0) {
            found.push("some outputs are not finite numbers".into());
        }
        if single.spread > STEADY {
            found.push(format!(
                "the means of the windows differ by {:.0} %: measure again on an idle machine",
                100.0 * single.spread
            ));
        }
        match accuracy {
            Ok(accuracy) => found.extend(accuracy.iter().flat_map(|it| &it.warnings).cloned()),
            Err(error) => found.push(format!("rank-1 could not be measured: {error}")),
        }
        found
    }
}

/// Returns the energy of single inferences and of the largest batch; none if the meter measured
/// none.
fn energy(meter: &Meter, one: &MeasuredWindows, batches: &[MeasuredBatch]) -> Option<Energy> {
    let largest = batches.iter().max_by_key(|batch| batch.size);
    Some(Energy {
        source: meter.source().to_owned(),
        single_mj: millijoules(&one.windows, 1)?,
        offline_mj: largest.and_then(|batch| millijoules(&batch.measured.windows, batch.size)),
    })
}

/// Returns a warning if other processes had a large share of the processors.
fn busy(share: f64) -> Option<String> {
    let percent = 100.0 * share;
    (share > LOAD_WARNED_OF).then(|| {
        format!("other processes kept {percent:.0} % of the processors busy while it was measured")
    })
}

/// Describes the timings that were cut short.
fn shortened(
    task: &Task<'_>,
    single: &Timing,
    batches: &[Offline],
    parts: &AnswerParts,
) -> Vec<String> {
    let named = |what: &str| what.to_owned();
    let batches = batches.iter();
    let timings = std::iter::once((named("one at a time"), single))
        .chain(batches.map(|it| (of_batches(task, it.batch), &it.timing)))
        .chain([
            (named("drawing"), &parts.preprocessing),
            (named("drawing and inference"), &parts.end_to_end),
        ]);
    let cut = timings.filter_map(|(what, timing)| Some(format!("{what}: {}", timing.cut()?)));
    cut.collect()
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
