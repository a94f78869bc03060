//! The errors of detected cycles.

use super::truth::Take;
use edgegait::dataset::gait_cycles::{FoundCycles, NoCycle};
use std::f64::consts::TAU;
use std::fmt;

/// The results of one method for the takes of one view.
#[derive(Default)]
pub struct Tally {
    pub takes: usize,
    /// Takes in which cycles were found.
    pub found: usize,
    /// Takes whose period is half or twice the true one, within 15 %.
    pub octaves: usize,
    /// Relative errors of the periods of the other takes.
    periods: Vec<f64>,
    /// The number of detected cycles with a period within 15 %, and of true cycles.
    pub cycles: (usize, usize),
    /// The true phase of each boundary of takes whose period is right, in steps, and the frames of
    /// a step.
    boundaries: Vec<(f64, f64)>,
}

/// The errors of one row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Shares of takes, 0..1.
    pub found: f64,
    pub octaves: f64,
    /// The median and the 95th percentile of the relative error.
    pub period: [f64; 2],
    /// The median and the 95th percentile of the boundary error, in frames and in cycles.
    pub boundary_frames: [f64; 2],
    pub boundary_cycles: [f64; 2],
    pub cycles: f64,
}

impl Tally {
    pub fn add(&mut self, take: &Take, found: &Result<FoundCycles, NoCycle>) {
        self.takes += 1;
        self.cycles.1 += take.cycles();
        let Ok(found) = found else { return };
        self.found += 1;
        let ratio = found.period_frames / take.period;
        if [0.5, 2.0]
            .iter()
            .any(|octave| (ratio / octave - 1.0).abs() < 0.15)
        {
            self.octaves += 1;
            return;
        }
        self.periods.push((ratio - 1.0).abs());
        if (ratio - 1.0).abs() > 0.15 {
            return;
        }
        for cycle in &found.cycles {
            let ratio = cycle.period_frames() / take.period;
            self.cycles.0 += usize::from((ratio - 1.0).abs() <= 0.15);
            for place in [cycle.start, cycle.end] {
                self.boundaries
                    .push((2.0 * take.phase(place), take.period / 2.0));
            }
        }
    }

    pub fn errors(&self) -> Errors {
        // Subtract the best constant, the circular mean.
        let (sin, cos) = self
            .boundaries
            .iter()
            .fold((0.0, 0.0), |(sin, cos), (phase, _)| {
                (sin + (TAU * phase).sin(), cos + (TAU * phase).cos())
            });
        let constant = f64::atan2(sin, cos) / TAU;
        let off = |phase: f64| (phase - constant - (phase - constant).round()).abs();
        let share = |count: usize| count as f64 / self.takes as f64;
        let frames = self
            .boundaries
            .iter()
            .map(|&(phase, step)| off(phase) * step);
        let cycles = self.boundaries.iter().map(|&(phase, _)| off(phase) / 2.0);
        Errors {
            found: share(self.found),
            octaves: share(self.octaves),
            period: percentiles(self.periods.clone()),
            boundary_frames: percentiles(frames.collect()),
            boundary_cycles: percentiles(cycles.collect()),
            cycles: self.cycles.0 as f64 / self.cycles.1 as f64,
        }
    }
}

/// Returns the median and the 95th percentile, by nearest rank.
fn percentiles(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [0.5, 0.95].map(|part| {
        let rank = (part * values.len() as f64).ceil() as usize;
        values
            .get(rank.saturating_sub(1))
            .copied()
            .unwrap_or(f64::NAN)
    })
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |pair: [f64; 2]| format!("{:.1} / {:.1}", 100.0 * pair[0], 100.0 * pair[1]);
        let [middle, most] = self.boundary_frames;
        write!(
            f,
            "{:.1} | {} | {:.1} | {middle:.2} / {most:.2} | {} | {:.1}",
            100.0 * self.found,
            percent(self.period),
            100.0 * self.octaves,
            percent(self.boundary_cycles),
            100.0 * self.cycles
        )
    }
}
