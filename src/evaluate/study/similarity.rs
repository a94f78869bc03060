//! The similarity of real silhouettes to each other and to their synthetic twins', frame by frame.

use super::example::{Example, RealAndSynthetic, SIZE, StudySetting};
use super::likeness::{Alignment, BoxPlot, Likeness, PHASES, aligned, lacking, likeness, mean};
use edgegait_core::silhouette::Silhouette;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;

/// The number of phases of a cycle that overlays show.
const OVERLAID: usize = 8;

/// The Jaccard indices of pairs of cycles.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SimilarityGroup {
    /// The number of pairs of cycles.
    pub pairs: usize,
    /// The indices of all frames at each frame's own phase.
    pub unaligned: BoxPlot,
    /// The indices at the phase shift that makes a cycle's frames most similar.
    pub by_phase: BoxPlot,
    /// The indices after shifting and scaling as well.
    pub fitted: BoxPlot,
    /// The share of pairs whose phase shift is nearer to half a cycle than to none.
    pub half_a_cycle: f64,
    /// The mean magnitude of the phase shift, as the distance to none or half a cycle.
    pub phase: f64,
    /// The mean scale of frames.
    pub scale: f64,
    /// The mean shift of frames to the right, pixels.
    pub across: f64,
    /// The mean shift of frames down, pixels.
    pub down: f64,
    /// The indices aligned by phase, for each person.
    pub people: Vec<(String, BoxPlot)>,
}

/// The real and synthetic frames of a person's cycle, at even phases.
#[derive(Clone, Debug)]
pub(crate) struct Overlay {
    /// The person.
    pub person: String,
    /// The pairs of real and synthetic frames.
    pub frames: Vec<(Silhouette, Silhouette)>,
}

/// The similarities from one viewpoint, with one kind of masks and one framing.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Similarity {
    /// The view's name.
    pub view: String,
    /// The name of the masks.
    pub masks: &'static str,
    /// The name of the framing.
    pub framing: &'static str,
    /// The pairs of two cycles of one take.
    pub same_take: Option<SimilarityGroup>,
    /// The pairs of two cycles of two takes of one person.
    pub other_take: Option<SimilarityGroup>,
    /// The pairs of a real cycle and the twin's cycle that is nearest in time.
    pub synthetic: Option<SimilarityGroup>,
    /// The pixels that only the real silhouette has in each row, and those that only the twin's
    /// has, aligned by phase, as shares of the union. All shares add up to 1 minus the index.
    pub rows: Vec<(f64, f64)>,
    /// One cycle of each person.
    #[serde(skip)]
    pub overlays: Vec<Overlay>,
}

/// The similarity of a pair of cycles.
struct CyclePair {
    person: usize,
    likeness: Likeness,
}

/// Returns the number of the twin's cycle that is nearest in time to a real one, of the same take
/// or else of the same person.
pub(crate) fn nearest(real: &Example, synthetic: &[Example]) -> Option<usize> {
    let own = synthetic.iter().enumerate();
    let own = own.filter(|(_, twin)| twin.person == real.person);
    let distance = |twin: &Example| {
        let apart = (twin.middle_s() - real.middle_s()).abs();
        // Another take's cycles are the last resort.
        (twin.take != real.take, apart)
    };
    own.min_by(|a, b| {
        let (a, b) = (distance(a.1), distance(b.1));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    })
    .map(|(number, _)| number)
}

/// Returns the frames of a real cycle at the phases of its twin at the same times.
pub(crate) fn by_time(real: &Example, twin: &Example) -> Vec<(f64, Silhouette)> {
    let (from, to) = twin.span_s;
    let count = real.frames.len() as f64;
    let second = |number: usize| {
        let share = (number as f64 + 0.5) / count;
        real.span_s.0 + share * (real.span_s.1 - real.span_s.0)
    };
    let phase = |number| ((second(number) - from) / (to - from)).rem_euclid(1.0);
    let frames = real.frames.iter().enumerate();
    frames
        .map(|(number, (_, frame))| (phase(number), *frame))
        .collect()
}

impl Similarity {
    /// Returns the names of the groups that are not empty, and the groups.
    pub(crate) fn groups(&self) -> impl Iterator<Item = (&'static str, &SimilarityGroup)> {
        let all = [
            ("R-R, one take", &self.same_take),
            ("R-R, two takes", &self.other_take),
            ("R-S", &self.synthetic),
        ];
        let known = all.into_iter();
        known.filter_map(|(name, group)| group.as_ref().map(|group| (name, group)))
    }

    /// Compares all cycles on all cores; `names` are the names of the people.
    pub(crate) fn compare(
        setting: StudySetting<'_>,
        both: RealAndSynthetic<'_>,
        names: &[String],
    ) -> Self {
        let StudySetting {
            view,
            masks,
            framing,
        } = setting;
        let RealAndSynthetic { real, synthetic } = both;
        let cycles: Vec<Vec<Silhouette>> = real
            .par_iter()
            .map(|example| example.at_phases(PHASES))
            .collect();
        let mut pairs = [Vec::new(), Vec::new()];
        for (a, one) in real.iter().enumerate() {
            for (b, other) in real.iter().enumerate().skip(a + 1) {
                if one.person == other.person {
                    pairs[usize::from(one.take != other.take)].push((a, b));
                }
            }
        }
        let [same_take, other_take] = pairs.map(|pairs| {
            let compare = |&(a, b): &(usize, usize)| CyclePair {
                person: real[a].person,
                likeness: likeness(&real[a].frames, &cycles[b]),
            };
            SimilarityGroup::from_pairs(&pairs.par_iter().map(compare).collect::<Vec<_>>(), names)
        });
        let twins: Vec<(&Example, usize)> = real
            .iter()
            .filter_map(|example| nearest(example, synthetic).map(|twin| (example, twin)))
            .collect();
        let compared: Vec<(CyclePair, Vec<(f64, f64)>)> = twins
            .par_iter()
            .map(|&(one, twin)| compared(one, &synthetic[twin]))
            .collect();
        let mut rows = vec![(0.0, 0.0); SIZE.rows()];
        for (sum, row) in compared.iter().flat_map(|(_, own)| rows_of(own)) {
            rows[sum].0 += row.0 / compared.len() as f64;
            rows[sum].1 += row.1 / compared.len() as f64;
        }
        let pairs: Vec<CyclePair> = compared.into_iter().map(|(pair, _)| pair).collect();
        let mut overlays: Vec<Overlay> = Vec::new();
        for ((one, twin), pair) in twins.iter().zip(&pairs) {
            let name = &names[one.person];
            if overlays.iter().all(|known| known.person != *name) {
                overlays.push(Overlay {
                    person: name.clone(),
                    frames: overlaid(one, &synthetic[*twin], pair.likeness.fit),
                });
            }
        }
        Self {
            view: view.to_owned(),
            masks,
            framing,
            same_take,
            other_take,
            synthetic: SimilarityGroup::from_pairs(&pairs, names),
            rows,
            overlays,
        }
    }
}

fn rows_of(rows: &[(f64, f64)]) -> impl Iterator<Item = (usize, (f64, f64))> + '_ {
    rows.iter().copied().enumerate()
}

/// Compares a real cycle with its twin's; also returns the pixels that only one has, by rows.
fn compared(real: &Example, twin: &Example) -> (CyclePair, Vec<(f64, f64)>) {
    let cycle = twin.at_phases(PHASES);
    let frames = by_time(real, twin);
    let found = likeness(&frames, &cycle);
    let mut rows = vec![(0.0, 0.0); SIZE.rows()];
    for (phase, frame) in &frames {
        let own = &cycle[place(*phase, found.fit)];
        for (row, lacking) in rows_of(&lacking(frame, own)) {
            rows[row].0 += lacking.0 / frames.len() as f64;
            rows[row].1 += lacking.1 / frames.len() as f64;
        }
    }
    let pair = CyclePair {
        person: real.person,
        likeness: found,
    };
    (pair, rows)
}

/// Returns the number of the silhouette, of [`PHASES`], that matches a frame at this phase.
fn place(phase: f64, fit: Alignment) -> usize {
    let phase = (phase + fit.phase).rem_euclid(1.0);
    (phase * PHASES as f64).round() as usize % PHASES
}

fn overlaid(real: &Example, twin: &Example, fit: Alignment) -> Vec<(Silhouette, Silhouette)> {
    let cycle = twin.at_phases(PHASES);
    let frames = by_time(real, twin);
    let count = OVERLAID.min(frames.len());
    let shown = (0..count).map(|at| &frames[at * frames.len() / count]);
    shown
        .map(|(phase, frame)| (*frame, cycle[place(*phase, fit)]))
        .collect()
}

impl SimilarityGroup {
    fn from_pairs(pairs: &[CyclePair], names: &[String]) -> Option<Self> {
        let all = |of: fn(&Likeness) -> &Vec<f64>| {
            let values = pairs.iter().flat_map(|pair| of(&pair.likeness));
            BoxPlot::from_values(values.copied().collect())
        };
        let over = |of: &dyn Fn(Alignment) -> f64| {
            mean(
                &pairs
                    .iter()
                    .map(|pair| of(pair.likeness.fit))
                    .collect::<Vec<_>>(),
            )
        };
        let mut people: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for pair in pairs {
            let own = people.entry(pair.person).or_default();
            own.extend(&pair.likeness.by_phase);
        }
        let people = people.into_iter().filter_map(|(person, values)| {
            BoxPlot::from_values(values).map(|plot| (names[person].clone(), plot))
        });
        Some(Self {
            pairs: pairs.len(),
            unaligned: all(|likeness| &likeness.unaligned)?,
            by_phase: all(|likeness| &likeness.by_phase)?,
            fitted: all(|likeness| &likeness.fitted)?,
            half_a_cycle: over(&|fit| f64::from(u8::from(fit.phase.abs() > 0.25))),
            phase: over(&|fit| fit.phase.abs().min(0.5 - fit.phase.abs())),
            scale: over(&|fit| fit.scale),
            across: over(&|fit| f64::from(fit.across)),
            down: over(&|fit| f64::from(fit.down)),
            people: people.collect(),
        })
    }
}

/// Returns the mean Jaccard index of real cycles and their twins', aligned by phase; `None` if
/// there are none.
pub(crate) fn mean_likeness(real: &[Example], synthetic: &[Example]) -> Option<f64> {
    let one = |one: &Example| {
        let twin = &synthetic[nearest(one, synthetic)?];
        let (_, found) = aligned(&by_time(one, twin), &twin.at_phases(PHASES));
        Some(mean(&found))
    };
    let found: Vec<f64> = real.par_iter().filter_map(one).collect();
    (!found.is_empty()).then(|| mean(&found))
}
