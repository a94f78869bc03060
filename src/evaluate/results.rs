//! What `edgegait score` finds, as the JSON that it writes.
//!
//! Two runs with the same header give the same results but for the timings, so
//! these stand apart ([`RunTime`], [`Latency`]) and can be taken out
//! ([`ScoreResults::without_timings`]). In JSON they are fields like the others.

use super::intervals::Rank1Intervals;
use super::rank1::Tally;
use super::verification::{RocPoint, TarAtFar};
use super::view_angle::AngleResult;
use crate::sequences::ViewLabel;
use serde::{Deserialize, Serialize};

pub use super::paired_results::{
    Confusion, HitsByView, PairedResult, PairedViewpoint, PersonResult,
};
pub use crate::dataset::{InputFile, ResultHeader};
pub use crate::score::RuntimeName;

/// The results of `edgegait score`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScoreResults {
    /// What made them.
    #[serde(flatten)]
    pub header: ResultHeader,
    /// Silhouettes drawn, or averaged in the dataset's GEIs.
    pub silhouettes: u64,
    /// GEIs that were shown to each recognizer.
    pub geis: u64,
    /// Share of the figures' pixels that the window cut away, 0..1; none if the
    /// dataset does not say.
    pub clipped_share: Option<f64>,
    /// One entry per recognizer, in the order given.
    pub recognizers: Vec<RecognizerResult>,
    /// How far they are apart, each from each where their probes are the same, the best first.
    #[serde(default)]
    pub paired: Vec<PairedResult>,
    /// How long it took.
    #[serde(flatten)]
    pub time: Option<RunTime>,
}

impl ScoreResults {
    /// The recognizers without the baselines, or these if there is nothing else.
    pub fn learnt(&self) -> impl DoubleEndedIterator<Item = &RecognizerResult> {
        let all_are_baselines = self.recognizers.iter().all(|result| result.baseline);
        let is_shown = move |result: &&RecognizerResult| all_are_baselines || !result.baseline;
        self.recognizers.iter().filter(is_shown)
    }

    /// The results without what differs between two equal runs.
    #[must_use]
    pub fn without_timings(mut self) -> Self {
        self.time = None;
        for recognizer in &mut self.recognizers {
            recognizer.latency = None;
        }
        self
    }
}

/// How long a run took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunTime {
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// What one recognizer achieved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecognizerResult {
    /// Its name, the model's file name as a rule.
    pub name: String,
    /// Whether it has learnt nothing, and is there for others to be compared with.
    #[serde(default)]
    pub baseline: bool,
    /// What ran it.
    pub runtime: RuntimeName,
    /// The protocol by its name: who is looked for among whom.
    pub protocol: String,
    /// People among whom it chooses; chance is 1 in so many.
    pub classes: usize,
    /// The sets of probes that `probes`, `people`, `rank1` with its intervals, `by_viewpoint` and
    /// `by_angle` are of: the clean ones, or all, pooled, where none is clean.
    #[serde(default)]
    pub of_probe_sets: Vec<String>,
    /// How often it was asked: once for each probe or, where each of the gallery's viewpoints is
    /// compared for itself, for each of these.
    pub probes: u64,
    /// People who are looked for; 0 if it is not known who was hit.
    #[serde(default)]
    pub people: u64,
    /// Share of hits, 0..1; 0 without probes.
    pub rank1: f64,
    /// Its 95 % intervals.
    #[serde(flatten)]
    pub intervals: Rank1Intervals,
    /// Probes whose output was not finite, of all sets. They are misses.
    pub non_finite: u64,
    /// Embeddings of the gallery that were not finite. They were left out of it.
    #[serde(default)]
    pub gallery_non_finite: u64,
    /// The viewpoints that it was trained at, (azimuth, elevation) in degrees;
    /// empty if unknown.
    #[serde(default)]
    pub trained_at: Vec<(f64, f64)>,
    /// Rank-1 by viewpoint, of those whose angles are known.
    pub by_viewpoint: Vec<ViewpointResult>,
    /// Rank-1 by the camera or recording of which only a name is known; empty if there are more
    /// than [`MAX_NAMED`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_named_view: Vec<NamedViewResult>,
    /// Rank-1 by the angle from training, nearest first; empty if that is unknown.
    #[serde(default)]
    pub by_angle: Vec<AngleResult>,
    /// Hits by person, of what `rank1` is of; people who are not looked for are left out.
    #[serde(default)]
    pub by_person: Vec<PersonResult>,
    /// Hits by viewpoint and person, of what `rank1` is of; not in the JSON.
    #[serde(skip)]
    pub hits_by_view: HitsByView,
    /// The protocol's sets of probes, each for itself.
    #[serde(default)]
    pub probe_sets: Vec<ProbeSetResult>,
    /// How fast it is.
    #[serde(flatten)]
    pub latency: Option<Latency>,
}

/// What a recognizer achieved on one set of probes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbeSetResult {
    /// The set, such as `BG`.
    pub name: String,
    /// Whether it is known that nothing acts on its walks.
    #[serde(default)]
    pub clean: bool,
    /// As [`RecognizerResult::probes`].
    pub probes: u64,
    /// People who are looked for.
    pub people: u64,
    /// Probes that are as near to another person as to the right one: of equals, the one that is
    /// listed first counts.
    pub tied: u64,
    /// Those whose person is not in the gallery: misses for Rank-k, left out of mAP and mINP.
    pub without_mate: u64,
    /// Those with an answer that is not finite: likewise.
    pub non_finite: u64,
    /// Rank-1, 0..1.
    pub rank1: f64,
    /// Its 95 % intervals.
    #[serde(flatten)]
    pub intervals: Rank1Intervals,
    /// Rank-5, 0..1.
    pub rank5: f64,
    /// Rank-1 to Rank-50, 0..1.
    pub cmc: Vec<f64>,
    /// Mean average precision, 0..1; none without a probe that counts.
    pub map: Option<f64>,
    /// Lower end of its 95 % interval that draws people.
    pub map_low: Option<f64>,
    /// Upper end.
    pub map_high: Option<f64>,
    /// Mean inverse negative penalty, 0..1.
    pub minp: Option<f64>,
    /// Hits by person.
    #[serde(default)]
    pub by_person: Vec<PersonResult>,
    /// The same distances as claims that are accepted or refused; none if they are more than
    /// ten million.
    pub verification: Option<VerificationResult>,
    /// Rank-1 from each viewpoint to each, if the protocol compares so.
    pub cross_view: Option<CrossViewResult>,
}

/// Whom a recognizer took one probe for: a row of `edgegait score --probes-csv`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProbeAnswer<'a> {
    /// Number of the probe among the source's sequences.
    #[serde(skip)]
    pub sequence: usize,
    /// The recognizer.
    pub recognizer: &'a str,
    /// The set of probes.
    pub probe_set: &'a str,
    /// Who is shown.
    pub subject: &'a str,
    /// In which take.
    pub take: &'a str,
    /// Of which walk of the source: where takes are made of walks, the one that it was made of.
    pub walk: &'a str,
    /// Which recorded cycle of the walk, from 0; none where the probe is a whole recording.
    pub cycle: Option<u32>,
    /// Which seeded variation of that cycle; 0 is the cycle itself.
    pub variation: u32,
    /// From which azimuth, degrees, if that is known.
    pub azimuth_deg: Option<f64>,
    /// From which elevation, degrees.
    pub elevation_deg: Option<f64>,
    /// By which camera, or in which recording, where only a name is known.
    pub view: Option<&'a str>,
    /// Azimuth of what the probe was compared with, if each viewpoint is compared for itself.
    pub gallery_azimuth_deg: Option<f64>,
    /// Elevation of it.
    pub gallery_elevation_deg: Option<f64>,
    /// Its name, where only that is known.
    pub gallery_view: Option<&'a str>,
    /// Whom the recognizer took them for; none without a finite answer.
    pub answer: Option<&'a str>,
    /// The right person's rank, from 1; none where they are not in the gallery.
    pub rank: Option<usize>,
    /// How far that person was, where the nearest embedding decides.
    pub distance: Option<f64>,
    /// How far the right person was.
    pub right_distance: Option<f64>,
    /// The class's score, where the highest one decides.
    pub score: Option<f64>,
    /// The score of the right person's class.
    pub right_score: Option<f64>,
}

/// How well a threshold of the distance tells people apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerificationResult {
    /// Pairs of one person.
    pub genuine: u64,
    /// Pairs of two people.
    pub impostors: u64,
    /// Pairs of one person whose distance was not finite: left out.
    pub non_finite_genuine: u64,
    /// Pairs of two people whose distance was not finite: left out.
    pub non_finite_impostors: u64,
    /// Equal error rate, 0..1.
    pub eer: Option<f64>,
    /// The distance at which it is reached.
    pub eer_threshold: Option<f64>,
    /// Lower end of its 95 % interval that draws people.
    pub eer_low: Option<f64>,
    /// Upper end.
    pub eer_high: Option<f64>,
    /// Area under the ROC, 0..1.
    pub auc: Option<f64>,
    /// True accept rates at fixed false accept rates.
    pub tar_at_far: Vec<TarAtFar>,
    /// The curve, at most 200 points.
    pub roc: Vec<RocPoint>,
}

/// Rank-1 from each viewpoint to each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrossViewResult {
    /// (azimuth, elevation) in degrees, or names, of rows and columns.
    pub views: Vec<ViewLabel>,
    /// `[probe view][gallery view]`, 0..1; none where nobody met.
    pub rank1: Vec<Vec<Option<f64>>>,
    /// Means over the gallery views but the identical one, percent, each cell rounded to 0.01
    /// first, as OpenGait computes them; empty if a cell is.
    pub by_probe_view_percent: Vec<f64>,
    /// Their mean.
    pub mean_percent: Option<f64>,
    /// Why there is no mean, if so.
    pub note: Option<String>,
}

/// Rank-1 at one viewpoint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewpointResult {
    /// Camera azimuth, degrees.
    pub azimuth_deg: f64,
    /// Camera elevation, degrees.
    pub elevation_deg: f64,
    /// GEIs seen from there.
    pub probes: u64,
    /// Share of hits, 0..1; 0 without probes.
    pub rank1: f64,
}

/// Rank-1 of what one camera saw, or is in one recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedViewResult {
    /// Its name.
    pub view: String,
    /// As of a viewpoint.
    pub probes: u64,
    /// Share of hits, 0..1; 0 without probes.
    pub rank1: f64,
}

/// Most named views that are listed: where each recording has a name of its own, they say nothing.
pub const MAX_NAMED: usize = 64;

impl ViewpointResult {
    /// The counts behind the rate; outputs that were not finite are in no
    /// viewpoint's count.
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

/// How long one inference takes, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Latency {
    /// Median.
    pub p50_us: f64,
    /// 90th percentile; none of fewer than 10 samples.
    pub p90_us: Option<f64>,
    /// 99th percentile; none of fewer than 100 samples.
    pub p99_us: Option<f64>,
}

impl Latency {
    /// The percentiles of samples in microseconds by nearest rank, ceil(p n): always
    /// one of the samples. None without samples.
    #[must_use]
    pub fn of(samples_us: &[f64]) -> Option<Self> {
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

/// What a recognizer is, apart from its results.
#[derive(Clone, Debug)]
pub struct Contestant {
    /// Its name.
    pub name: String,
    /// What ran it.
    pub runtime: RuntimeName,
    /// The protocol by its name.
    pub protocol: String,
    /// People among whom it chooses.
    pub classes: usize,
    /// Where it was trained, (azimuth, elevation) in degrees; empty if unknown.
    pub trained_at: Vec<(f64, f64)>,
}

impl RecognizerResult {
    /// The result of counts by viewpoint, without timings.
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
            intervals: Rank1Intervals::of(&[all], 0),
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
        }
    }

    /// The result with the interval over people, from each one's counts.
    #[must_use]
    pub fn with_subjects(mut self, subjects: &[Tally], seed: u64) -> Self {
        self.people = subjects.iter().filter(|one| one.probes > 0).count() as u64;
        self.intervals = Rank1Intervals::of(subjects, seed);
        self
    }

    /// The counts at the viewpoints of training, empty if these are unknown or were
    /// not scored.
    #[must_use]
    pub fn at_training(&self) -> Tally {
        let trained = self
            .by_viewpoint
            .iter()
            .filter(|viewpoint| self.is_trained_at(viewpoint));
        trained.map(ViewpointResult::tally).sum()
    }

    /// Whether the recognizer was trained at a viewpoint, to 0.01 degrees.
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
