//! Chooses the frames and the markers of a recording that are used together.

use std::ops::Range;

use glam::DVec3;

use super::names::{MarkerPlace, MarkerSide, Segment, Site};
use super::set::Marks;
use crate::people::cleaning::low_pass::LowPass;

/// A marker that would leave less than this share of the frames is left out instead. Our choice.
const LEAST_SHARE: f64 = 0.8;

/// Fewest frames of a motion. Our choice: a third of a fast stride at 60 Hz.
const LEAST_FRAMES: usize = 8;

/// Complete tracks of markers over one stretch of frames, metres, Y up.
#[derive(Clone, Debug)]
pub(super) struct MarkerTracks {
    /// The frames of the recording that are used.
    pub(super) frames: Range<usize>,
    marks: Vec<(Site, MarkerSide, Vec<DVec3>)>,
}

impl MarkerTracks {
    /// Returns the track of the first marker of a place.
    pub(super) fn get(&self, site: Site, side: MarkerSide) -> Option<&[DVec3]> {
        let (.., track) = self
            .marks
            .iter()
            .find(|mark| (mark.0, mark.1) == (site, side))?;
        Some(track)
    }

    /// Returns the tracks of all markers of a segment on one side.
    pub(super) fn tracks(&self, segment: Segment, side: MarkerSide) -> Vec<&[DVec3]> {
        let of_side =
            |mark: &&(Site, MarkerSide, Vec<DVec3>)| mark.0.segment() == segment && mark.1 == side;
        self.marks
            .iter()
            .filter(of_side)
            .map(|mark| mark.2.as_slice())
            .collect()
    }

    /// Low-passes every track.
    pub(super) fn smooth(&mut self, filter: &LowPass) {
        for (.., track) in &mut self.marks {
            filter.positions(track);
        }
    }

    /// Exchanges the two sides of every pair for which `is_part` is true.
    pub(super) fn exchange_sides(&mut self, is_part: impl Fn(Site) -> bool) {
        for (site, side, _) in &mut self.marks {
            if is_part(*site) {
                *side = match side {
                    MarkerSide::Left => MarkerSide::Right,
                    MarkerSide::Right => MarkerSide::Left,
                    MarkerSide::Middle => MarkerSide::Middle,
                };
            }
        }
    }
}

/// The essential markers, in order.
const ESSENTIAL: [Site; 9] = [
    Site::Asis,
    Site::Sacrum,
    Site::Psis,
    Site::Ankle,
    Site::AnkleCentre,
    Site::Knee,
    Site::KneeCentre,
    Site::Heel,
    Site::Toe,
];

impl MarkerTracks {
    /// Chooses the longest stretch in which all essential markers are present, and the other
    /// markers that leave at least 80 % of it.
    ///
    /// # Errors
    /// Names the marker that leaves too few frames.
    pub(super) fn choose(marks: &Marks, warnings: &mut Vec<String>) -> Result<Self, String> {
        let mut present = vec![true; marks.frames];
        let mut frames = 0..marks.frames;
        let mut used: Vec<usize> = Vec::new();
        let mut left_out: Vec<&str> = Vec::new();
        let has_back = marks.has(Site::Sacrum, MarkerSide::Middle);
        for site in ESSENTIAL {
            // Posterior spines are needed only without a sacrum, and the file's joint centres only
            // without markers.
            let stands_in = match site {
                Site::Psis => has_back,
                Site::AnkleCentre => {
                    marks.has(Site::Ankle, MarkerSide::Left)
                        && marks.has(Site::Ankle, MarkerSide::Right)
                }
                Site::KneeCentre => {
                    marks.has(Site::Knee, MarkerSide::Left)
                        && marks.has(Site::Knee, MarkerSide::Right)
                }
                _ => false,
            };
            if stands_in {
                continue;
            }
            for (number, mark) in marks
                .all
                .iter()
                .enumerate()
                .filter(|(_, mark)| mark.site == site)
            {
                for (present, point) in present.iter_mut().zip(&mark.track) {
                    *present &= point.is_some();
                }
                frames = longest_run(&present);
                if frames.len() < LEAST_FRAMES {
                    return Err(format!(
                        "marker {} ({}) is seen in {} of {} frames, never long enough together with the other markers of pelvis and legs",
                        mark.name,
                        MarkerPlace(mark.site, mark.side),
                        mark.seen(),
                        marks.frames
                    ));
                }
                used.push(number);
            }
        }
        let mut others: Vec<usize> = (0..marks.all.len()).filter(|i| !used.contains(i)).collect();
        others.sort_by_key(|&number| std::cmp::Reverse(marks.all[number].seen()));
        for number in others {
            let both: Vec<bool> = present
                .iter()
                .zip(&marks.all[number].track)
                .map(|(a, b)| *a && b.is_some())
                .collect();
            let run = longest_run(&both);
            if run.len() as f64 >= LEAST_SHARE * frames.len() as f64 {
                present = both;
                frames = run;
                used.push(number);
            } else {
                left_out.push(&marks.all[number].name);
            }
        }
        if frames.len() < marks.frames {
            warnings.push(format!(
                "markers are missing: only frames {} to {} of {} are used",
                frames.start,
                frames.end - 1,
                marks.frames
            ));
        }
        if !left_out.is_empty() {
            warnings.push(format!(
                "seen in too few of these frames and left out: {}",
                left_out.join(", ")
            ));
        }
        used.sort_unstable();
        let marks = used
            .into_iter()
            .map(|number| {
                let mark = &marks.all[number];
                let track = mark.track[frames.clone()]
                    .iter()
                    .flatten()
                    .copied()
                    .collect();
                (mark.site, mark.side, track)
            })
            .collect();
        Ok(Self { frames, marks })
    }
}

/// Returns the longest run of true values.
fn longest_run(values: &[bool]) -> Range<usize> {
    let mut best = 0..0;
    let mut from = 0;
    for (index, value) in values.iter().enumerate() {
        if !value {
            from = index + 1;
        }
        if index + 1 - from > best.len() {
            best = from..index + 1;
        }
    }
    best
}
