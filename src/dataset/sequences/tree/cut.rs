//! Cuts the recordings of a tree into gait cycles.

use super::Recordings;
use crate::dataset::gait_cycles::{CycleFinder, median, whole_frames};
use crate::error::Result;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashSet};

/// Recordings cut into gait cycles.
pub struct CutRecordings {
    /// The gait cycles, and the whole recordings that have none.
    pub recordings: Recordings,
    /// The names of recordings without cycles, with the reasons.
    pub without: Vec<String>,
    /// The median duration of a cycle over recordings, frames; `None` if no recording has cycles.
    pub period_frames: Option<f64>,
}

impl Recordings {
    /// Splits each recording into gait cycles of `frames` frames, unless its length is not a
    /// multiple of `frames`.
    ///
    /// # Errors
    /// If a recording cannot be read.
    pub fn in_even_cycles(self, frames: usize) -> Result<Self> {
        let numbers = self.numbers();
        let mut cycles = vec![Vec::new(); self.tree.sequences().len()];
        let counts: Vec<Result<Option<usize>>> = numbers
            .par_iter()
            .map(|&number| self.tree.frames(number))
            .collect();
        for (&number, count) in numbers.iter().zip(counts) {
            // Other recordings lack frames without a figure.
            let count = count?.filter(|count| count.is_multiple_of(frames));
            let starts = (0..count.unwrap_or(0)).step_by(frames.max(1));
            cycles[number] = starts.map(|start| start..start + frames).collect();
        }
        let kept: HashSet<usize> = numbers.into_iter().collect();
        Ok(Self { cycles, ..self }.filter(|number, _| kept.contains(&number)))
    }

    /// Splits each recording into the gait cycles that the finder finds, one sequence each. Keeps
    /// the whole recording where it finds none. Reads every picture, on all cores; `progress` is
    /// called once a recording.
    ///
    /// # Errors
    /// If a recording cannot be read.
    pub fn in_cycles(
        self,
        finder: &CycleFinder,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<CutRecordings> {
        let numbers = self.numbers();
        let find = |&number: &usize| {
            let legs = self.tree.lower_bodies(number);
            progress()?;
            let finder = match self.tree.sequences()[number].angles_deg {
                Some((azimuth, _)) if is_from_the_side(azimuth) => finder.from_the_side(),
                _ => *finder,
            };
            Ok(legs.map(|legs| finder.find(legs)))
        };
        let found: Vec<Result<_>> = numbers.par_iter().map(find).collect::<Result<_>>()?;
        let mut cycles = vec![Vec::new(); self.tree.sequences().len()];
        let (mut no_cycle, mut periods) = (BTreeMap::new(), Vec::new());
        for (&number, found) in numbers.iter().zip(found) {
            match found? {
                Ok(found) => {
                    cycles[number] = found.cycles.iter().map(whole_frames).collect();
                    periods.push(found.period_frames);
                }
                Err(reason) => {
                    no_cycle.insert(number, reason);
                }
            }
        }
        let named = |(number, reason): (&usize, _)| format!("{}: {reason}", self.name(*number));
        let without = no_cycle.iter().map(named).collect();
        let kept: HashSet<usize> = numbers.into_iter().collect();
        let cut = Self {
            cycles,
            no_cycle,
            ..self
        };
        Ok(CutRecordings {
            recordings: cut.filter(|number, _| kept.contains(&number)),
            without,
            period_frames: median(periods),
        })
    }
}

/// Returns whether a camera at this azimuth in degrees sees a walker from the side: within 40
/// degrees. Our choice: there the outline of the legs swings once a step.
fn is_from_the_side(azimuth_deg: f64) -> bool {
    azimuth_deg.to_radians().sin().abs() > 50_f64.to_radians().sin()
}
