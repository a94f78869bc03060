//! The results of `edgegait score`, as the JSON that it writes.
//!
//! Two runs with the same header give the same results except for the timings. These are separate
//! types ([`RunTime`], [`Latency`]), which are optional. In JSON they are fields like the others.

use super::intervals::Rank1Intervals;
use super::rank1::Tally;
use super::verification::{RocPoint, TarAtFar};
use super::view_angle::AngleResult;
use crate::dataset::sequences::ViewLabel;
use serde::{Deserialize, Serialize};

pub use super::paired_results::{
    Confusion, HitsByView, PairedResult, PairedViewpoint, PersonResult,
};
pub use crate::files::{InputFile, ResultHeader};
pub use crate::inference::RuntimeName;

/// The results of `edgegait score`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScoreResults {
    /// The command, version, seed, inputs and settings.
    #[serde(flatten)]
    pub header: ResultHeader,
    /// Number of silhouettes rendered, or averaged in the dataset's GEIs.
    pub silhouettes: u64,
    /// Number of GEIs that were shown to each recognizer.
    pub geis: u64,
    /// Share of the figures' pixels that lay outside of the images, 0..1; none if the dataset does
    /// not state it.
    pub clipped_share: Option<f64>,
    /// One entry per recognizer, in the order given.
    pub recognizers: Vec<RecognizerResult>,
    /// Differences between all pairs of recognizers with the same probes, beginning with those of
    /// the best recognizer.
    #[serde(default)]
    pub paired: Vec<PairedResult>,
    /// The run time.
    #[serde(flatten)]
    pub time: Option<RunTime>,
}

impl ScoreResults {
    /// Returns the recognizers without the baselines, or the baselines if there is nothing else.
    pub fn learnt(&self) -> impl DoubleEndedIterator<Item = &RecognizerResult> {
        let all_are_baselines = self.recognizers.iter().all(|result| result.baseline);
        let is_shown = move |result: &&RecognizerResult| all_are_baselines || !result.baseline;
        self.recognizers.iter().filter(is_shown)
    }
}

/// The run time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunTime {
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// The results of one recognizer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecognizerResult {
    /// The recognizer's name, by default the model's file name.
    pub name: String,
    /// Whether it is a baseline, which has learnt nothing.
    #[serde(default)]
    pub baseline: bool,
    /// The runtime that ran it.
    pub runtime: RuntimeName,
    /// Name of the protocol.
    pub protocol: String,
    /// Number of people to choose from; chance is 1 / `classes`.
    pub classes: usize,
    /// The headline sets of probes, which `probes`, `people`, `rank1` with its intervals,
    /// `by_viewpoint` and `by_angle` pool: the clean ones, or all where none is clean.
    #[serde(default)]
    pub of_probe_sets: Vec<String>,
    /// Number of decisions: one per probe or, where each gallery viewpoint is compared separately,
    /// one per probe and gallery viewpoint.
    pub probes: u64,
    /// Number of people with probes; 0 if hits per person are not known.
    #[serde(default)]
    pub people: u64,
    /// Share of hits, 0..1; 0 without probes.
    pub rank1: f64,
    /// The 95 % intervals of Rank-1.
    #[serde(flatten)]
    pub intervals: Rank1Intervals,
    /// Probes of all sets with a non-finite output. They count as misses.
    pub non_finite: u64,
    /// Non-finite embeddings of the gallery. They were left out.
    #[serde(default)]
    pub gallery_non_finite: u64,
    /// The training viewpoints, (azimuth, elevation) in degrees; empty if unknown.
    #[serde(default)]
    pub trained_at: Vec<(f64, f64)>,
    /// Rank-1 by viewpoint, for viewpoints with known angles.
    pub by_viewpoint: Vec<ViewpointResult>,
    /// Rank-1 by camera or recording, for those with a name only; empty if there are more than
    /// [`MAX_NAMED`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_named_view: Vec<NamedViewResult>,
    /// Rank-1 by the angle from the training viewpoints, nearest first; empty if these are unknown.
    #[serde(default)]
    pub by_angle: Vec<AngleResult>,
    /// Hits by person, on the headline probe sets; people without probes are left out.
    #[serde(default)]
    pub by_person: Vec<PersonResult>,
    /// Hits by viewpoint and person, on the headline probe sets; not in the JSON.
    #[serde(skip)]
    pub hits_by_view: HitsByView,
    /// The results on each of the protocol's sets of probes.
    #[serde(default)]
    pub probe_sets: Vec<ProbeSetResult>,
    /// The latency of inference.
    #[serde(flatten)]
    pub latency: Option<Latency>,
    /// Bytes of the model's file, if it has one.
    #[serde(default)]
    pub model_bytes: Option<u64>,
}

/// The results of a recognizer on one set of probes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbeSetResult {
    /// Name of the set, such as `BG`.
    pub name: String,
    /// Whether it is known that no confounder acts on its walks.
    #[serde(default)]
    pub clean: bool,
    /// Number of decisions, as [`RecognizerResult::probes`].
    pub probes: u64,
    /// Number of people with probes.
    pub people: u64,
    /// Probes that are as near to another person as to the right one. Ties go to the one listed
    /// first.
    pub tied: u64,
    /// Probes whose person is not in the gallery: misses for Rank-k, left out of mAP and mINP.
    pub without_mate: u64,
    /// Probes with a non-finite answer: misses for Rank-k, left out of mAP and mINP.
    pub non_finite: u64,
    /// Rank-1, 0..1.
    pub rank1: f64,
    /// The 95 % intervals of Rank-1.
    #[serde(flatten)]
    pub intervals: Rank1Intervals,
    /// Rank-5, 0..1.
    pub rank5: f64,
    /// Rank-1 to Rank-50, 0..1.
    pub cmc: Vec<f64>,
    /// Mean average precision, 0..1; none without a probe that counts.
    pub map: Option<f64>,
    /// Lower end of the 95 % interval of mAP that resamples people.
    pub map_low: Option<f64>,
    /// Upper end of the interval of mAP.
    pub map_high: Option<f64>,
    /// Mean inverse negative penalty, 0..1.
    pub minp: Option<f64>,
    /// Hits by person.
    #[serde(default)]
    pub by_person: Vec<PersonResult>,
    /// Verification with the same distances; none if there are more than ten million.
    pub verification: Option<VerificationResult>,
    /// Rank-1 by pair of viewpoints, if the protocol compares each gallery viewpoint separately.
    pub cross_view: Option<CrossViewResult>,
}

/// A recognizer's answer to one probe: a row of `edgegait score --probes-csv`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProbeAnswer<'a> {
    /// Number of the probe among the source's sequences.
    #[serde(skip)]
    pub sequence: usize,
    /// The recognizer.
    pub recognizer: &'a str,
    /// The set of probes.
    pub probe_set: &'a str,
    /// The person of the probe.
    pub subject: &'a str,
    /// The take of the probe.
    pub take: &'a str,
    /// The walk in the source, from which a made take is derived.
    pub walk: &'a str,
    /// The recorded cycle of the walk, from 0; none where the probe is a whole recording.
    pub cycle: Option<u32>,
    /// The seeded variation of that cycle; 0 is the cycle itself.
    pub variation: u32,
    /// Azimuth of the probe, degrees, if it is known.
    pub azimuth_deg: Option<f64>,
    /// Elevation of the probe, degrees, if it is known.
    pub elevation_deg: Option<f64>,
    /// Camera or recording of the probe, where only a name is known.
    pub view: Option<&'a str>,
    /// Azimuth of the gallery, degrees, if each viewpoint is compared separately.
    pub gallery_azimuth_deg: Option<f64>,
    /// Elevation of the gallery, degrees, if each viewpoint is compared separately.
    pub gallery_elevation_deg: Option<f64>,
    /// Camera or recording of the gallery, where only a name is known.
    pub gallery_view: Option<&'a str>,
    /// The person that the recognizer names; none without a finite answer.
    pub answer: Option<&'a str>,
    /// The right person's rank, from 1; none where that person is not in the gallery.
    pub rank: Option<usize>,
    /// Distance to the answer, where the nearest embedding decides.
    pub distance: Option<f64>,
    /// Distance to the right person.
    pub right_distance: Option<f64>,
    /// The answer's score, where the highest score decides.
    pub score: Option<f64>,
    /// The score of the right person's class.
    pub right_score: Option<f64>,
}

/// The results of verification, which accepts pairs by a threshold on the distance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerificationResult {
    /// Number of genuine pairs (of one person).
    pub genuine: u64,
    /// Number of impostor pairs (of two people).
    pub impostors: u64,
    /// Genuine pairs with a non-finite distance, which are left out.
    pub non_finite_genuine: u64,
    /// Impostor pairs with a non-finite distance, which are left out.
    pub non_finite_impostors: u64,
    /// Equal error rate, 0..1.
    pub eer: Option<f64>,
    /// The threshold of the equal error rate, a distance.
    pub eer_threshold: Option<f64>,
    /// Lower end of the 95 % interval of the EER that resamples people.
    pub eer_low: Option<f64>,
    /// Upper end of the interval of the EER.
    pub eer_high: Option<f64>,
    /// Area under the ROC, 0..1.
    pub auc: Option<f64>,
    /// True accept rates at fixed false accept rates.
    pub tar_at_far: Vec<TarAtFar>,
    /// The ROC, at most 200 points.
    pub roc: Vec<RocPoint>,
}

/// Rank-1 by pair of probe viewpoint and gallery viewpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrossViewResult {
    /// Labels of rows and columns: (azimuth, elevation) in degrees, or names.
    pub views: Vec<ViewLabel>,
    /// Rank-1 `[probe view][gallery view]`, 0..1; none without probes. Empty for more than 64
    /// viewpoints.
    pub rank1: Vec<Vec<Option<f64>>>,
    /// Means over the gallery views except the identical one, percent, each cell rounded to 0.01
    /// first, as OpenGait computes them. Empty if a cell is empty.
    pub by_probe_view_percent: Vec<f64>,
    /// Mean of `by_probe_view_percent`.
    pub mean_percent: Option<f64>,
    /// Rank-1 where the gallery has the probe's own viewpoint, which no other rate counts; none
    /// without such a gallery.
    #[serde(default)]
    pub same_view: Option<SameViewResult>,
    /// Why there is no mean, if there is none.
    pub note: Option<String>,
}

/// Rank-1 where gallery and probe have the same viewpoint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SameViewResult {
    /// Share of hits, 0..1.
    pub rank1: f64,
    /// The 95 % intervals of Rank-1.
    #[serde(flatten)]
    pub intervals: Rank1Intervals,
}

/// Rank-1 at one viewpoint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewpointResult {
    /// Camera azimuth, degrees.
    pub azimuth_deg: f64,
    /// Camera elevation, degrees.
    pub elevation_deg: f64,
    /// Number of GEIs seen from there.
    pub probes: u64,
    /// Share of hits, 0..1; 0 without probes.
    pub rank1: f64,
}

/// Rank-1 for one camera or recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedViewResult {
    /// Name of the camera or recording.
    pub view: String,
    /// Number of probes, as [`ViewpointResult::probes`].
    pub probes: u64,
    /// Share of hits, 0..1; 0 without probes.
    pub rank1: f64,
}

/// The maximum number of named views that are listed. Where each recording has its own name, a list
/// is of no use.
pub const MAX_NAMED: usize = 64;

impl ViewpointResult {
    /// Returns the counts behind the rate. Non-finite outputs are not counted by viewpoint.
    #[must_use]
    pub fn tally(&self) -> Tally {
        // A rate of counts below 2^52 times its denominator rounds to the count.
        let hits = (self.rank1 * self.probes as f64).round() as u64;
        Tally {
            probes: self.probes,
            hits: hits.min(self.probes),
            non_finite: 0,
        }
    }
}

/// The latency of one inference, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Latency {
    /// Median.
    pub p50_us: f64,
    /// 90th percentile; none with fewer than 10 samples.
    pub p90_us: Option<f64>,
    /// 99th percentile; none with fewer than 100 samples.
    pub p99_us: Option<f64>,
}

impl Latency {
    /// Returns the percentiles of samples in microseconds by nearest rank, ceil(p n), so that each
    /// is one of the samples. None without samples.
    #[must_use]
    pub fn from_samples(samples_us: &[f64]) -> Option<Self> {
        let mut sorted = samples_us.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let percentile = |percent: usize| -> Option<f64> {
            sorted
                .get((percent * sorted.len()).div_ceil(100).saturating_sub(1))
                .copied()
        };
        Some(Self {
            p50_us: percentile(50)?,
            p90_us: percentile(90).filter(|_| sorted.len() >= 10),
            p99_us: percentile(99).filter(|_| sorted.len() >= 100),
        })
    }
}

/// A recognizer's description, without results.
#[derive(Clone, Debug)]
pub struct Contestant {
    /// The recognizer's name.
    pub name: String,
    /// The runtime that ran it.
    pub runtime: RuntimeName,
    /// Name of the protocol.
    pub protocol: String,
    /// Number of people to choose from.
    pub classes: usize,
    /// The training viewpoints, (azimuth, elevation) in degrees; empty if unknown.
    pub trained_at: Vec<(f64, f64)>,
}

impl RecognizerResult {
    /// Creates a result from counts by viewpoint, without timings.
    #[must_use]
    pub fn new(contestant: Contestant, by_view: &[(&ViewLabel, Tally)]) -> Self {
        let all: Tally = by_view.iter().map(|(_, tally)| *tally).sum();
        let (mut by_viewpoint, mut by_named_view) = (Vec::new(), Vec::new());
        for &(view, tally) in by_view {
            let (probes, rank1) = (tally.probes, tally.rank1().unwrap_or_default());
            match view {
                &ViewLabel::Angles(azimuth_deg, elevation_deg) => {
                    by_viewpoint.push(ViewpointResult {
                        azimuth_deg,
                        elevation_deg,
                        probes,
                        rank1,
                    });
                }
                ViewLabel::Named(name) => by_named_view.push(NamedViewResult {
                    view: name.clone(),
                    probes,
                    rank1,
                }),
            }
        }
        if by_named_view.len() > MAX_NAMED {
            by_named_view.clear();
        }
        Self {
            name: contestant.name,
            baseline: false,
            runtime: contestant.runtime,
            protocol: contestant.protocol,
            classes: contestant.classes,
            of_probe_sets: Vec::new(),
            probes: all.probes,
            people: 0,
            rank1: all.rank1().unwrap_or_default(),
            intervals: Rank1Intervals::from_tallies(&[all], 0),
            non_finite: all.non_finite,
            gallery_non_finite: 0,
            trained_at: contestant.trained_at,
            by_viewpoint,
            by_named_view,
            by_angle: Vec::new(),
            by_person: Vec::new(),
            hits_by_view: HitsByView::default(),
            probe_sets: Vec::new(),
            latency: None,
            model_bytes: None,
        }
    }

    /// Returns the result with the interval over people, from the counts of each person.
    #[must_use]
    pub fn with_subjects(mut self, subjects: &[Tally], seed: u64) -> Self {
        self.people = subjects.iter().filter(|subject| subject.probes > 0).count() as u64;
        self.intervals = Rank1Intervals::from_tallies(subjects, seed);
        self
    }

    /// Returns the counts at the training viewpoints, empty if these are unknown or were not
    /// scored.
    #[must_use]
    pub fn at_training(&self) -> Tally {
        let trained = self
            .by_viewpoint
            .iter()
            .filter(|viewpoint| self.is_trained_at(viewpoint));
        trained.map(ViewpointResult::tally).sum()
    }

    /// Returns whether the recognizer was trained at a viewpoint, to 0.01 degrees.
    #[must_use]
    pub fn is_trained_at(&self, viewpoint: &ViewpointResult) -> bool {
        self.trained_at.iter().any(|&(azimuth_deg, elevation_deg)| {
            (azimuth_deg - viewpoint.azimuth_deg).abs() < 0.01
                && (elevation_deg - viewpoint.elevation_deg).abs() < 0.01
        })
    }
}

#[cfg(test)]
pub(crate) mod tests;
