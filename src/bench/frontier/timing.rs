//! Measures the time of a silhouette.

use crate::draw::sweep::{Job, Settings, Swept, View, sweep};
use crate::error::Result;
use edgegait_core::pack::Pack;
use std::time::{Duration, Instant};

/// The shortest measurement; faster work is repeated.
const SHORTEST: Duration = Duration::from_millis(20);

/// A case to time: a cycle of a pack's first walk.
pub(super) struct Timed<'a> {
    /// The pack.
    pub pack: Pack<'a>,
    /// The settings for drawing.
    pub settings: Settings,
}

/// Returns for each case the least time of a complete silhouette over `rounds` rounds, ns. The
/// views share the pose; each silhouette has its own projection, framing, rasterising and
/// accumulation. Runs on one thread and measures each case once in every round, so that a slow
/// phase of the machine affects all of them.
///
/// # Errors
/// If a figure cannot be drawn.
pub(super) fn least_ns(
    cases: &[Timed<'_>],
    views: &[View],
    rounds: usize,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Vec<f64>> {
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut least = vec![f64::INFINITY; cases.len()];
    for _ in 0..rounds {
        for (case, least) in cases.iter().zip(&mut least) {
            *least = least.min(alone.install(|| once(case, views))?);
            progress()?;
        }
    }
    Ok(least)
}

/// Returns the mean time of a silhouette, ns.
fn once(case: &Timed<'_>, views: &[View]) -> Result<f64> {
    let jobs = [Job::plain(0, 0)];
    let started = Instant::now();
    let mut geis = 0.0;
    while started.elapsed() < SHORTEST {
        let count = |_: Job<'_>, swept: Swept| Ok(swept.templates.len());
        sweep(&case.pack, &jobs, views, case.settings, count, |_, made| {
            geis += made as f64;
            Ok(())
        })?;
    }
    let silhouettes = geis * f64::from(case.settings.frames_per_cycle);
    Ok(started.elapsed().as_secs_f64() * 1e9 / silhouettes)
}
