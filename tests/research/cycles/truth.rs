//! The true heel strikes of the walkers of `people/` and `reallike/`, from their manifests.

use crate::people::rows;
use std::collections::HashMap;
use std::path::Path;

/// The truth of one take.
#[derive(Clone, Debug)]
pub struct Take {
    pub subject: String,
    pub take: String,
    pub frames: usize,
    /// The frames of heel strikes in order, with their phase; whole numbers are left strikes.
    strikes: Vec<(f64, f64)>,
    /// The frames of a cycle: the median of the strides of both feet.
    pub period: f64,
}

impl Take {
    /// Returns the phase at a frame, in cycles: linear between strikes, extrapolated at both ends.
    pub fn phase(&self, frame: f64) -> f64 {
        let strikes = &self.strikes;
        let (first, last) = (strikes[0], strikes[strikes.len() - 1]);
        let mean = (last.1 - first.1) / (last.0 - first.0);
        if frame <= first.0 {
            return first.1 + (frame - first.0) * mean;
        }
        let segment = strikes.windows(2).find(|pair| frame <= pair[1].0);
        segment.map_or(last.1 + (frame - last.0) * mean, |pair| {
            let slope = (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
            pair[0].1 + (frame - pair[0].0) * slope
        })
    }

    /// Returns the number of full cycles, of which 8 % may be missing in total, as `phase_cycles`
    /// counts.
    pub fn cycles(&self) -> usize {
        let span = self.phase(self.frames as f64 - 1.0) - self.phase(0.0);
        (span + 0.08).floor() as usize
    }
}

/// Returns all takes of a manifest, by person and take.
pub fn takes(manifest: &Path) -> HashMap<(String, String), Take> {
    let mut found = HashMap::new();
    for row in rows(manifest) {
        let strikes = |column: &str| -> Vec<f64> {
            let numbers = row[column].split(';').filter(|text| !text.is_empty());
            numbers
                .map(|text| text.parse().expect("a number"))
                .collect()
        };
        let (left, right) = (strikes("lhs"), strikes("rhs"));
        let mut strides: Vec<f64> = [&left, &right]
            .iter()
            .flat_map(|feet| feet.windows(2).map(|pair| pair[1] - pair[0]))
            .collect();
        if strides.is_empty() {
            strides.push(2.0 * (left[0] - right[0]).abs());
        }
        strides.sort_by(f64::total_cmp);
        let left = left.iter().map(|frame| (*frame, 0.0));
        let mut all: Vec<(f64, f64)> = left
            .chain(right.iter().map(|frame| (*frame, 0.5)))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        for at in 1..all.len() {
            let same_foot = (all[at].1 - all[at - 1].1).fract() == 0.0;
            all[at].1 = all[at - 1].1 + if same_foot { 1.0 } else { 0.5 };
        }
        let take = Take {
            subject: row["id"].clone(),
            take: row["take"].clone(),
            frames: row["frames"].parse().expect("a number"),
            strikes: all,
            period: f64::midpoint(strides[(strides.len() - 1) / 2], strides[strides.len() / 2]),
        };
        found.insert((take.subject.clone(), take.take.clone()), take);
    }
    found
}
