//! How long a silhouette takes.

use crate::error::Result;
use crate::sweep::{Job, Settings, Swept, View, sweep};
use edgegait_core::pack::Pack;
use std::time::{Duration, Instant};

/// Shortest measurement: what is faster is repeated.
const SHORTEST: Duration = Duration::from_millis(20);

/// What is timed: a cycle of a pack's first walk.
pub(super) struct Timed<'a> {
    /// The pack.
    pub pack: Pack<'a>,
    /// How it is drawn.
    pub settings: Settings,
}

/// The least time of a complete silhouette over so many rounds, ns, for each case: the pose is shared by the
/// views; projection, framing, rasteriser and accumulation are its own. One thread; in
/// every round each case has its turn, so that what slows the machine slows all of them.
///
/// # Errors
/// When a figure cannot be drawn.
pub(super) fn least_ns(
    cases: &[Timed<'_>],
    views: &[View],
    rounds: usize,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<f64>> {
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut least = vec![f64::INFINITY; cases.len()];
    for _ in 0..rounds {
        for (case, least) in cases.iter().zip(&mut least) {
            *least = least.min(alone.install(|| once(case, views))?);
            progress();
        }
    }
    Ok(least)
}

/// The mean time of a silhouette, ns.
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
