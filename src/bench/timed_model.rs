//! Timing a loaded model within its share of the time.

use super::board::MachineState;
use super::energy::{EnergyCount, Meter};
use super::memory;
use super::task::Task;
use super::time_budget::{Cap, TimeShare};
use super::timing::{Timing, WorkExtent};
use super::windows::{MeasuredWindow, TimedCall, TimingPlan, Watch, measure as measure_windows};
use crate::error::{Error, Result};
use crate::inference::{Model, Recognizer, Runtime};
use std::path::Path;
use std::time::Instant;

/// A loaded model, with the costs of loading it.
pub(super) struct LoadedModel {
    pub runtime: Runtime,
    pub model: Model,
    pub recognizer: Box<dyn Recognizer>,
    pub runtime_load_ms: f64,
    pub load_ms: f64,
    pub baseline: MemoryBaseline,
}

impl LoadedModel {
    /// Loads a task's model.
    pub(super) fn load(task: &Task<'_>) -> Result<Self> {
        let baseline = MemoryBaseline(memory::rss_bytes());
        memory::forget_peak();
        let started = Instant::now();
        let runtime = (task.start)()?.with_threads(task.threads);
        let runtime_load_ms = ms_since(started);
        let started = Instant::now();
        let model = (task.open)()?;
        let recognizer = runtime.load(&model)?;
        Ok(Self {
            runtime,
            model,
            recognizer,
            runtime_load_ms,
            load_ms: ms_since(started),
            baseline,
        })
    }
}

/// The memory that the process had before the runtime was started, bytes.
#[derive(Clone, Copy)]
pub(super) struct MemoryBaseline(Option<u64>);

impl MemoryBaseline {
    /// Returns by how much a peak exceeds the baseline.
    pub(super) fn below(self, peak: Option<u64>) -> Option<u64> {
        let both = peak.zip(self.0);
        both.map(|(peak, baseline)| peak.saturating_sub(baseline))
    }
}

/// The first inference and the warm-up, which is shorter for slow models.
pub(super) struct FirstInference {
    pub first_ms: f64,
    pub non_finite: usize,
    /// The shortest of these calls, seconds.
    pub call_s: f64,
    pub peak_rss_bytes: Option<u64>,
}

impl FirstInference {
    pub(super) fn measure(
        recognizer: &dyn Recognizer,
        input: &[f32],
        plan: &TimingPlan,
        most_s: f64,
    ) -> Result<Self> {
        let started = Instant::now();
        let outputs = recognizer.run(input, 1)?;
        let first_ms = ms_since(started);
        let mut call_s = first_ms * 1e-3;
        for _ in 0..plan.within(most_s, call_s, 1).warm_up {
            call_s = call_s.min(seconds_of(&mut || recognizer.run(input, 1).map(drop))?);
        }
        Ok(Self {
            first_ms,
            non_finite: outputs.non_finite,
            call_s,
            peak_rss_bytes: memory::peak_rss_bytes(),
        })
    }
}

/// The timing of one kind of work: the plan, its share of the time, and the size of a call.
#[derive(Clone, Copy)]
pub(super) struct TimedWork<'a> {
    pub plan: &'a TimingPlan,
    pub share: &'a TimeShare,
    /// The time of one call, seconds.
    pub call_s: f64,
    /// The number of inferences in one call.
    pub batch: usize,
}

/// Measured windows and their summary.
pub(super) struct MeasuredWindows {
    pub windows: Vec<MeasuredWindow>,
    pub timing: Timing,
}

/// Measures as much of a plan as fits its share of the time.
pub(super) fn timed<const N: usize>(
    call: &TimedWork<'_>,
    works: [TimedCall<'_>; N],
    watch: &mut Watched<'_>,
) -> Result<[MeasuredWindows; N]> {
    let &TimedWork {
        plan,
        share,
        call_s,
        batch,
    } = call;
    let made = plan.within(share.left_s() / N as f64, call_s, batch);
    let all = measure_windows(&made, share.until, batch, works, watch)?;
    let mut found = Vec::with_capacity(N);
    for windows in all {
        let mut timing =
            Timing::from_windows(&windows, batch).ok_or(Error::Missing("at least one window"))?;
        timing.extent = Some(WorkExtent::from_windows(plan, &made, &windows, batch));
        found.push(MeasuredWindows { windows, timing });
    }
    found
        .try_into()
        .map_err(|_| Error::Missing("each kind of work"))
}

/// Times inferences, called from the thread where they cost least.
pub(super) fn beside(
    recognizer: &dyn Recognizer,
    input: &[f32],
    call: &TimedWork<'_>,
    watch: &mut Watched<'_>,
) -> Result<MeasuredWindows> {
    let mut found = None;
    recognizer.beside(&mut || {
        let mut ours = || recognizer.run(input, call.batch).map(drop);
        found = Some(timed(call, [&mut ours], watch));
    });
    let [measured] = found.ok_or_else(|| Error::Missing("a measurement"))??;
    Ok(measured)
}

fn ms_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

/// Returns the time of one call, seconds.
pub(super) fn seconds_of(work: TimedCall<'_>) -> Result<f64> {
    let started = Instant::now();
    work()?;
    Ok(started.elapsed().as_secs_f64())
}

/// The states of the machine between windows, and the remaining time.
pub(super) struct Watched<'a> {
    root: &'a Path,
    pub(super) states: Vec<MachineState>,
    pub(super) meter: Option<Meter>,
    count: Option<EnergyCount>,
    pub(super) cap: Cap<'a>,
}

impl<'a> Watched<'a> {
    pub(super) fn new(root: &'a Path, start: MachineState, cap: Cap<'a>) -> Self {
        Self {
            root,
            states: vec![start],
            meter: Meter::find(root),
            count: None,
            cap,
        }
    }
}

impl Watch for Watched<'_> {
    fn begin(&mut self) -> Result<()> {
        self.count = self.meter.as_ref().map(Meter::start).transpose()?;
        Ok(())
    }

    fn end(&mut self) -> Option<f64> {
        let energy_j = match (&self.meter, self.count.take()) {
            (Some(meter), Some(count)) => meter.stop(count),
            _ => None,
        };
        self.states.push(MachineState::read(self.root));
        self.cap.tell();
        energy_j
    }
}
