//! A recognizer's results, summed over its probes.

use super::bootstrap::{interval_95, verification_95};
use super::cross_view::CrossView;
use super::identification::Ranking;
use super::intervals::Rank1Intervals;
use super::paired_results::Confused;
use super::paired_results::{HitsByView, PersonResult};
use super::protocol::{Decision, GalleryViews};
use super::rank1::Tally;
use super::results::{
    Contestant, CrossViewResult, ProbeAnswer, ProbeSetResult, RecognizerResult, SameViewResult,
    VerificationResult,
};
use super::trial::{ProbeComparison, Trial};
use super::verification::{Pairs, Verification};
use super::view_angle::by_angle;
use crate::dataset::sequences::Sequences;
use crate::error::{EvaluateError, Result};
use crate::inference::Recognizer;
use crate::inference::answers::Answers;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashSet};

/// The maximum number of distances that are kept for verification: 400 MB.
const MAX_PAIRS: u64 = 10_000_000;

/// The maximum number of comparisons of a probe and a gallery that are kept at a time.
const MAX_MET: usize = 1 << 16;
/// The maximum number of viewpoints of which all pairs are listed.
const MAX_LISTED: usize = 64;

/// Sums over one set of probes.
struct ProbeSums {
    /// Tallies `[viewpoint][person]`.
    by_view: Vec<Vec<Tally>>,
    by_person: Vec<Ranking>,
    confused: Confused,
    tied: u64,
    pairs: Vec<Pairs>,
    cells: Option<CrossView>,
    /// Tallies of each person where the gallery has the probe's own viewpoint, if viewpoints are
    /// compared separately.
    same_view: Vec<Tally>,
}

/// Returns a recognizer's results. `seed` is the seed for resampling people, and `tell` is called
/// for each answer that counts.
///
/// # Errors
/// If the gallery has no finite embedding, or no probe can be compared.
pub(super) fn judge(
    recognizer: &dyn Recognizer,
    trial: &Trial<'_>,
    answers: &Answers,
    seed: u64,
    tell: &mut dyn FnMut(ProbeAnswer<'_>) -> Result<()>,
) -> Result<RecognizerResult> {
    let (trial, gallery_non_finite) = with_finite_gallery(recognizer, trial, answers)?;
    let sequences = trial.sequences;
    let keep_pairs = trial.comparisons() <= MAX_PAIRS;
    let [mut all, mut clean] = [(); 2].map(|()| PooledSums::none(sequences));
    let mut probe_sets = Vec::new();
    for (set, takes) in trial.protocol.probes.iter().zip(&trial.roles.probes) {
        let probes: Vec<usize> = { trial.probes() }
            .filter(|&sequence| takes[sequences.list[sequence].take])
            .collect();
        if probes.is_empty() {
            continue;
        }
        let mut told = |probe: usize, meeting: &ProbeComparison| {
            tell(trial.answered(recognizer, &set.name, probe, meeting))
        };
        let sums = sums(recognizer, &trial, answers, &probes, keep_pairs, &mut told)?;
        all.add(&sums);
        if set.clean {
            clean.add(&sums);
        }
        probe_sets.push(ProbeSetResult {
            clean: set.clean,
            ..result_of(&set.name, &trial, sums, seed)
        });
    }
    if probe_sets.iter().all(|set| set.probes == 0) {
        return Err(EvaluateError::NothingCompared {
            protocol: trial.protocol.name.clone(),
            at: match trial.protocol.gallery_views {
                GalleryViews::Each => "different viewpoints",
                _ => "viewpoints that are compared",
            },
        }
        .into());
    }
    // Confounded probes must not be pooled into the headline numbers.
    let has_clean = probe_sets.iter().any(|set| set.clean && set.probes > 0);
    let pooled = if has_clean { clean } else { all };
    let mut result = pooled.result(recognizer, &trial, seed);
    let leading = probe_sets.iter().filter(|set| set.clean || !has_clean);
    result.of_probe_sets = leading.map(|set| set.name.clone()).collect();
    result.baseline = recognizer.is_baseline();
    result.non_finite = probe_sets.iter().map(|set| set.non_finite).sum();
    result.gallery_non_finite = gallery_non_finite;
    result.probe_sets = probe_sets;
    Ok(result)
}

/// Returns a trial without the sequences of the gallery whose embeddings are not finite, and their
/// number.
fn with_finite_gallery<'a>(
    recognizer: &dyn Recognizer,
    trial: &Trial<'a>,
    answers: &Answers,
) -> Result<(Trial<'a>, u64)> {
    let mut trial = Trial {
        classes: trial.classes.clone(),
        gallery: trial.gallery.clone(),
        ..*trial
    };
    let enrolled = |trial: &Trial<'_>| trial.gallery.iter().map(Vec::len).sum::<usize>();
    let all = enrolled(&trial);
    for gallery in &mut trial.gallery {
        let is_finite = |number: &f32| number.is_finite();
        gallery.retain(|&sequence| answers.embedding(sequence).iter().all(is_finite));
    }
    let left = enrolled(&trial);
    if trial.classes.is_none() && left == 0 {
        return Err(EvaluateError::NoFiniteGallery(recognizer.name().to_owned()).into());
    }
    Ok((trial, (all - left) as u64))
}

/// Sums over several sets of probes.
struct PooledSums {
    /// By viewpoint and person.
    by_view: Vec<Vec<Tally>>,
    confused: Confused,
}

impl PooledSums {
    fn none(sequences: &Sequences) -> Self {
        let people = sequences.subjects.len();
        Self {
            by_view: vec![vec![Tally::default(); people]; sequences.views.len()],
            confused: vec![BTreeMap::new(); people],
        }
    }

    /// Adds one set of probes.
    fn add(&mut self, more: &ProbeSums) {
        let tallies = self.by_view.iter_mut().flatten();
        for (sum, tally) in tallies.zip(more.by_view.iter().flatten()) {
            *sum += *tally;
        }
        for (sums, more) in self.confused.iter_mut().zip(&more.confused) {
            for (other, count) in more {
                *sums.entry(other.clone()).or_default() += count;
            }
        }
    }

    /// Returns the results that follow from these sums.
    fn result(self, recognizer: &dyn Recognizer, trial: &Trial<'_>, seed: u64) -> RecognizerResult {
        let Self { by_view, confused } = self;
        let sequences = trial.sequences;
        let contestant = contestant(recognizer, trial);
        let tallies: Vec<_> = sequences
            .views
            .iter()
            .zip(&by_view)
            .map(|(view, people)| (view, people.iter().copied().sum::<Tally>()))
            .filter(|(_, tally)| tally.probes > 0)
            .collect();
        let views = sequences.views.iter().zip(&by_view);
        let (angles, of_angles): (Vec<_>, Vec<_>) = views
            .filter_map(|(view, people)| Some((view.angles_deg()?, people.clone())))
            .unzip();
        let by_angle = by_angle(&contestant.trained_at, &angles, &of_angles, seed);
        let of_person = |person: usize| by_view.iter().map(|people| people[person]).sum();
        let by_person: Vec<Tally> = (0..sequences.subjects.len()).map(of_person).collect();
        let mut result =
            RecognizerResult::new(contestant, &tallies).with_subjects(&by_person, seed);
        result.by_angle = by_angle;
        result.by_person = PersonResult::list(&sequences.subjects, &by_person, &confused);
        result.hits_by_view = HitsByView {
            views: sequences.views.clone(),
            tallies: by_view,
        };
        result
    }
}

/// Returns who is judged, and among whom.
fn contestant(recognizer: &dyn Recognizer, trial: &Trial<'_>) -> Contestant {
    let contract = recognizer.contract();
    let (decision, gallery_views) = (trial.protocol.decision, trial.protocol.gallery_views);
    let takes = trial.sequences.takes.iter().zip(&trial.roles.gallery);
    let enrolled = takes.filter(|(_, is_enrolled)| **is_enrolled);
    Contestant {
        name: recognizer.name().to_owned(),
        runtime: recognizer.runtime().clone(),
        protocol: trial.protocol.name.clone(),
        classes: match decision {
            Decision::ClassScore => contract.classes.len(),
            Decision::NearestEmbedding => {
                let people: HashSet<usize> = enrolled.map(|(take, _)| take.subject).collect();
                people.len()
            }
        },
        // Where embeddings of two viewpoints are compared, neither is "where it was trained".
        trained_at: match (decision, gallery_views) {
            (Decision::NearestEmbedding, GalleryViews::Each | GalleryViews::All) => Vec::new(),
            _ => contract
                .training
                .viewpoints
                .iter()
                .map(|&[azimuth, elevation]| (azimuth, elevation))
                .collect(),
        },
    }
}

/// Compares all probes of a set with the gallery.
fn sums(
    recognizer: &dyn Recognizer,
    trial: &Trial<'_>,
    answers: &Answers,
    probes: &[usize],
    keep_pairs: bool,
    tell: &mut dyn FnMut(usize, &ProbeComparison) -> Result<()>,
) -> Result<ProbeSums> {
    let sequences = trial.sequences;
    let (views, people) = (sequences.views.len(), sequences.subjects.len());
    let mut sums = ProbeSums {
        by_view: vec![vec![Tally::default(); people]; views],
        by_person: vec![Ranking::default(); people],
        confused: vec![BTreeMap::new(); people],
        tied: 0,
        pairs: vec![Pairs::default(); if keep_pairs { people } else { 0 }],
        cells: (trial.protocol.gallery_views == GalleryViews::Each).then(|| CrossView::new(views)),
        same_view: vec![Tally::default(); people],
    };
    // In chunks, so that distances are not kept twice.
    let galleries = if sums.cells.is_some() { views } else { 1 };
    for probes in probes.chunks((MAX_MET / galleries).max(1)) {
        let met: Vec<Vec<ProbeComparison>> = probes
            .par_iter()
            .map(|&probe| trial.meet(recognizer, answers, probe, keep_pairs))
            .collect();
        for (&probe, meetings) in probes.iter().zip(met) {
            let (person, view) = (sequences.subject(probe), sequences.list[probe].view);
            for mut meeting in meetings {
                if let (Some(cells), Some(gallery_view)) = (&mut sums.cells, meeting.gallery_view) {
                    cells.add(view, gallery_view, meeting.outcome());
                    if gallery_view == view {
                        sums.same_view[person].add(meeting.outcome());
                        continue;
                    }
                }
                tell(probe, &meeting)?;
                sums.by_view[view][person].add(meeting.outcome());
                sums.by_person[person].add(meeting.ranked);
                if let Some(other) = trial.taken_for(recognizer, &meeting) {
                    let confused = &mut sums.confused[person];
                    // Mostly there is an entry already.
                    match confused.get_mut(other) {
                        Some(count) => *count += 1,
                        None => drop(confused.insert(other.to_owned(), 1)),
                    }
                }
                sums.tied += u64::from(meeting.is_tied);
                if let Some(pairs) = sums.pairs.get_mut(person) {
                    pairs.genuine.append(&mut meeting.pairs.genuine);
                    pairs.impostor.append(&mut meeting.pairs.impostor);
                }
            }
        }
    }
    Ok(sums)
}

fn result_of(name: &str, trial: &Trial<'_>, sums: ProbeSums, seed: u64) -> ProbeSetResult {
    let mut all = Ranking::default();
    sums.by_person.iter().for_each(|ranking| all += ranking);
    let tally = all.tally(1);
    let of_people: Vec<Tally> = sums
        .by_person
        .iter()
        .map(|interval| interval.tally(1))
        .collect();
    let probed: Vec<Ranking> = sums
        .by_person
        .iter()
        .filter(|ranking| ranking.probes() > 0)
        .cloned()
        .collect();
    let map = interval_95(&probed, seed, Ranking::map);
    ProbeSetResult {
        name: name.to_owned(),
        clean: false,
        probes: all.probes(),
        people: probed.len() as u64,
        tied: sums.tied,
        without_mate: all.without_mate(),
        non_finite: all.non_finite(),
        rank1: tally.rank1().unwrap_or_default(),
        intervals: Rank1Intervals::from_tallies(&of_people, seed),
        rank5: all.rank_k(5).unwrap_or_default(),
        cmc: all.cmc().unwrap_or_default(),
        map: all.map(),
        map_low: map.map(|interval| interval.low),
        map_high: map.map(|interval| interval.high),
        minp: all.minp(),
        by_person: PersonResult::list(&trial.sequences.subjects, &of_people, &sums.confused),
        verification: verification(&sums.pairs, seed),
        cross_view: sums.cells.map(|cells| CrossViewResult {
            same_view: same_view(&sums.same_view, seed),
            ..cross_view(&cells, trial.sequences)
        }),
    }
}

fn verification(pairs: &[Pairs], seed: u64) -> Option<VerificationResult> {
    if pairs.is_empty() {
        return None;
    }
    let all =
        |of: fn(&Pairs) -> &Vec<f64>| -> Vec<f64> { pairs.iter().flat_map(of).copied().collect() };
    let curve =
        Verification::from_distances(&all(|pairs| &pairs.genuine), &all(|pairs| &pairs.impostor));
    let (non_finite_genuine, non_finite_impostors) = curve.non_finite();
    let eer = curve.eer();
    let over_people = verification_95(pairs, seed, |curve| curve.eer().map(|eer| eer.rate));
    Some(VerificationResult {
        genuine: curve.genuine(),
        impostors: curve.impostors(),
        non_finite_genuine,
        non_finite_impostors,
        eer: eer.map(|eer| eer.rate),
        eer_threshold: eer.map(|eer| eer.threshold),
        eer_low: over_people.map(|interval| interval.low),
        eer_high: over_people.map(|interval| interval.high),
        auc: curve.auc(),
        tar_at_far: curve.tars(),
        roc: curve.roc(),
    })
}

fn cross_view(cells: &CrossView, sequences: &Sequences) -> CrossViewResult {
    let views = sequences.views.len();
    let row = |probe_view: usize| {
        let cell = |gallery_view: usize| cells.cell(probe_view, gallery_view).rank1();
        (0..views).map(cell).collect()
    };
    let means = cells.means();
    CrossViewResult {
        views: sequences.views.clone(),
        rank1: (0..views)
            .take_while(|_| views <= MAX_LISTED)
            .map(row)
            .collect(),
        note: means.as_ref().err().map(ToString::to_string),
        mean_percent: means.as_ref().ok().map(|means| means.mean),
        same_view: None,
        by_probe_view_percent: means.map(|means| means.by_probe_view).unwrap_or_default(),
    }
}

/// Returns Rank-1 from the tallies of each person where gallery and probe have the same viewpoint.
fn same_view(people: &[Tally], seed: u64) -> Option<SameViewResult> {
    let rank1 = people.iter().copied().sum::<Tally>().rank1()?;
    Some(SameViewResult {
        rank1,
        intervals: Rank1Intervals::from_tallies(people, seed),
    })
}
