//! Measures one model in this process, which should do nothing else.
//!
//! What is inside of a timed call: [`Recognizer::run`](crate::score::Recognizer::run) on numbers
//! that lie ready, with all its checks, until its outputs lie in vectors. Drawing the input is
//! outside, but for the end-to-end figures.

use super::accuracy::Accuracy;
use super::board::{Board, State, warnings};
use super::energy::{Count, Meter};
use super::inputs::Scene;
use super::memory;
use super::results::{Bare, Conditions, Energy, ModelResult, Offline, Parts, Timing, millijoules};
use super::windows::{Plan, Watch, Window, measure as measure_windows};
use crate::error::{Error, Result};
use crate::score::{BareOutputs, Model, Recognizer, Runtime};
use std::path::Path;
use std::time::Instant;

/// How far the means of windows may be apart before that is warned of, of their mean. Ours.
const STEADY: f64 = 0.15;

/// What is to be measured.
pub(crate) struct Task<'a> {
    /// Reads the model.
    pub open: &'a dyn Fn() -> Result<Model>,
    /// Starts the runtime.
    pub start: &'a dyn Fn() -> Result<Runtime>,
    /// Threads inside of one inference.
    pub threads: usize,
    /// Inferences of a batch.
    pub batch: usize,
    /// How long.
    pub plan: Plan,
    /// Whether to compare with a loop around nothing but the runtime.
    pub bare: bool,
    /// What is drawn.
    pub scene: Scene<'a>,
    /// Seed of the intervals of accuracy.
    pub seed: u64,
    /// Where the machine's files are.
    pub root: &'a Path,
}

/// Measures a model.
///
/// # Errors
/// If it cannot be loaded or drawn for, or an inference fails.
pub(crate) fn measure(task: &Task<'_>) -> Result<ModelResult> {
    // Drawing has threads of its own: one, so that its time is comparable with the inference's.
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let contract = (task.open)()?.contract().clone();
    let (scene, plan, batch) = (&task.scene, &task.plan, task.batch);
    let inputs = alone.install(|| scene.inputs(&contract, batch))?;
    let single = &inputs[..inputs.len() / batch];

    let mut watched = Watched::new(task.root);
    let baseline = memory::rss_bytes();
    memory::forget_peak();
    let started = Instant::now();
    let runtime = (task.start)()?.with_threads(task.threads);
    let runtime_load_ms = ms_since(started);
    let started = Instant::now();
    let model = (task.open)()?;
    let recognizer = runtime.load(&model)?;
    let load_ms = ms_since(started);
    let started = Instant::now();
    let first = recognizer.run(single, 1)?;
    let first_ms = ms_since(started);
    for _ in 0..plan.warm_up {
        recognizer.run(single, 1)?;
    }
    let peak_rss_bytes = memory::peak_rss_bytes();

    let (windows, bare) = if task.bare {
        let mut ours = || recognizer.run(single, 1).map(drop);
        let mut plain = runtime.bare(&model, single, BareOutputs::New)?;
        let mut reusing = runtime.bare(&model, single, BareOutputs::Reused)?;
        let works: [&mut dyn FnMut() -> Result<()>; 3] =
            [&mut ours, &mut || plain().map(drop), &mut || {
                reusing().map(drop)
            }];
        let [ours, plain, reusing] = measure_windows(plan, 1, works, &mut watched)?;
        let compared = Bare::of(&ours, &plain, &reusing);
        (ours, compared)
    } else {
        let windows = beside(recognizer.as_ref(), (single, 1), plan, &mut watched)?;
        (windows, None)
    };

    memory::forget_peak();
    let batches = beside(recognizer.as_ref(), (&inputs, batch), plan, &mut watched)?;
    let offline_peak = memory::peak_rss_bytes();
    let parts = alone.install(|| parts(scene, recognizer.as_ref(), plan, &mut watched))?;
    let Watched { states, meter, .. } = watched;
    let energy = meter.and_then(|meter| {
        Some(Energy {
            source: meter.source().to_owned(),
            single_mj: millijoules(&windows, 1)?,
            offline_mj: millijoules(&batches, batch)?,
        })
    });
    let (name, name_of_runtime) = (recognizer.name().to_owned(), recognizer.runtime().clone());
    let accuracy = Accuracy::of(recognizer, scene, task.seed);

    let affinity = Board::read(task.root).affinity;
    let mut found = warnings(&states, affinity.as_ref());
    let broken = accuracy
        .as_ref()
        .is_ok_and(|(found, _)| found.non_finite > 0);
    if first.non_finite > 0 || broken {
        found.push("some of its outputs are not finite numbers".into());
    }
    let one_at_a_time = timing(&windows, 1)?;
    if one_at_a_time.spread > STEADY {
        found.push(format!(
            "the means of its windows are {:.0} % apart: measure again on an idle machine",
            100.0 * one_at_a_time.spread
        ));
    }
    match &accuracy {
        // The model's name stands before each already.
        Ok((_, doubts)) => found.extend(doubts.iter().map(|doubt| {
            let named = doubt.strip_prefix(&format!("{name}: "));
            named.unwrap_or(doubt).to_owned()
        })),
        Err(error) => found.push(format!("its rank-1 could not be measured: {error}")),
    }
    found.extend(model.warning());
    let graph = model.graph();
    let frames = contract.frames_in(single.len(), 1)?;
    let input = contract.input_shape(1, frames);
    let shape: Vec<u64> = input.iter().map(|&size| size as u64).collect();
    let macs = graph.macs(&shape);
    Ok(ModelResult {
        name,
        runtime: name_of_runtime,
        threads: task.threads,
        input,
        bytes: model.bytes().len() as u64,
        params: graph.parameters,
        macs: macs.as_ref().ok().copied(),
        macs_unknown: macs.err(),
        runtime_load_ms,
        load_ms,
        first_ms,
        single: one_at_a_time,
        peak_rss_bytes,
        peak_rss_over_baseline_bytes: peak_rss_bytes
            .zip(baseline)
            .map(|(peak, baseline)| peak.saturating_sub(baseline)),
        offline: Offline {
            batch,
            timing: timing(&batches, batch)?,
            peak_rss_bytes: offline_peak,
        },
        parts,
        bare,
        energy,
        accuracy: accuracy.ok().map(|(accuracy, _)| accuracy),
        conditions: Conditions {
            hottest_c: states
                .iter()
                .filter_map(|state| state.temperature_c)
                .reduce(f64::max),
            start: states.first().cloned().unwrap_or_default(),
            end: states.last().cloned().unwrap_or_default(),
        },
        warnings: found,
    })
}

/// Inferences, called from where they cost least.
fn beside(
    recognizer: &dyn Recognizer,
    (input, batch): (&[f32], usize),
    plan: &Plan,
    watch: &mut Watched<'_>,
) -> Result<Vec<Window>> {
    let mut found = None;
    recognizer.beside(&mut || {
        let mut ours = || recognizer.run(input, batch).map(drop);
        found = Some(measure_windows(plan, batch, [&mut ours], watch));
    });
    let [windows] = found.ok_or_else(|| Error::Missing("a measurement"))??;
    Ok(windows)
}

/// Drawing alone, and with the inference; people take turns.
fn parts(
    scene: &Scene<'_>,
    recognizer: &dyn Recognizer,
    plan: &Plan,
    watch: &mut Watched<'_>,
) -> Result<Parts> {
    let contract = recognizer.contract();
    let mut at = 0;
    let mut input = Vec::new();
    let mut draw = || {
        input.clear();
        at += 1;
        scene.append_input(contract, at, &mut input)
    };
    let [preprocessing] = measure_windows(plan, 1, [&mut draw], watch)?;
    let mut both = || {
        input.clear();
        at += 1;
        scene.append_input(contract, at, &mut input)?;
        recognizer.run(&input, 1).map(drop)
    };
    let [end_to_end] = measure_windows(plan, 1, [&mut both], watch)?;
    Ok(Parts {
        preprocessing: timing(&preprocessing, 1)?,
        end_to_end: timing(&end_to_end, 1)?,
    })
}

fn timing(windows: &[Window], batch: usize) -> Result<Timing> {
    Timing::of(windows, batch).ok_or(Error::Missing("at least one window"))
}

fn ms_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

/// The machine between windows.
pub(super) struct Watched<'a> {
    root: &'a Path,
    pub(super) states: Vec<State>,
    pub(super) meter: Option<Meter>,
    count: Option<Count>,
}

impl<'a> Watched<'a> {
    pub(super) fn new(root: &'a Path) -> Self {
        Self {
            root,
            states: vec![State::read(root)],
            meter: Meter::find(root),
            count: None,
        }
    }
}

impl Watch for Watched<'_> {
    fn begin(&mut self) {
        self.count = self.meter.as_ref().map(Meter::start);
    }

    fn end(&mut self) -> Option<f64> {
        let energy_j = match (&self.meter, self.count.take()) {
            (Some(meter), Some(count)) => meter.stop(count),
            _ => None,
        };
        self.states.push(State::read(self.root));
        energy_j
    }
}
