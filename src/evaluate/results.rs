//! What `edgegait score` finds, as the JSON that it writes.
//!
//! Two runs with the same header give the same results but for the timings, so
//! these stand apart ([`RunTime`], [`Latency`]) and can be taken out
//! ([`ScoreResults::without_timings`]). In JSON they are fields like the others.

use serde::{Deserialize, Serialize};

use super::rank::Tally;
use super::subjects::bootstrap_95;
pub use crate::dataset::{Header, InputFile};
pub use crate::score::RuntimeName;

/// The results of `edgegait score`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScoreResults {
    /// What made them.
    #[serde(flatten)]
    pub header: Header,
    /// Silhouettes drawn, or averaged in the dataset's GEIs.
    pub silhouettes: u64,
    /// GEIs that were shown to each recognizer.
    pub geis: u64,
    /// Share of the figures' pixels that the window cut away, 0..1; none if the
    /// dataset does not say.
    pub clipped_share: Option<f64>,
    /// One entry per recognizer, in the order given.
    pub recognizers: Vec<RecognizerResult>,
    /// How long it took.
    #[serde(flatten)]
    pub time: Option<RunTime>,
}

impl ScoreResults {
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
    /// What ran it.
    pub runtime: RuntimeName,
    /// How a hit is decided.
    pub protocol: Protocol,
    /// People among whom it chooses; chance is 1 in so many.
    pub classes: usize,
    /// GEIs shown to it.
    pub probes: u64,
    /// Share of hits, 0..1; 0 without probes.
    pub rank1: f64,
    /// Lower end of Wilson's 95 % interval, probes taken as independent.
    pub rank1_low: f64,
    /// Upper end.
    pub rank1_high: f64,
    /// The 95 % interval that draws people rather than probes, [low, high]; none if
    /// it is not known who was hit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rank1_by_subjects: Option<(f64, f64)>,
    /// Probes whose output was not finite. They are misses.
    pub non_finite: u64,
    /// The viewpoints that it was trained at, (azimuth, elevation) in degrees;
    /// empty if unknown.
    #[serde(default)]
    pub trained_at: Vec<(f64, f64)>,
    /// Rank-1 by viewpoint.
    pub by_viewpoint: Vec<ViewpointResult>,
    /// How fast it is.
    #[serde(flatten)]
    pub latency: Option<Latency>,
}

/// How a hit is decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Protocol {
    /// The class with the highest score is the right person.
    #[serde(rename = "closed set by class score")]
    ClassScore,
    /// The nearest embedding of the gallery is the right person's.
    #[serde(rename = "nearest gallery embedding")]
    NearestEmbedding,
    /// The nearest embedding of all other takes at the same viewpoint is the right person's.
    #[serde(rename = "leave one take out, nearest embedding")]
    LeaveOneTakeOut,
}

impl Protocol {
    /// The protocol in words, as in JSON.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::ClassScore => "closed set by class score",
            Self::NearestEmbedding => "nearest gallery embedding",
            Self::LeaveOneTakeOut => "leave one take out, nearest embedding",
        }
    }
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
    /// 90th percentile.
    pub p90_us: f64,
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
            p90_us: percentile(90)?,
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
    /// How a hit is decided.
    pub protocol: Protocol,
    /// People among whom it chooses.
    pub classes: usize,
    /// Where it was trained, (azimuth, elevation) in degrees; empty if unknown.
    pub trained_at: Vec<(f64, f64)>,
}

impl RecognizerResult {
    /// The result of counts by viewpoint ((azimuth, elevation) in degrees), without
    /// timings.
    #[must_use]
    pub fn new(contestant: Contestant, by_viewpoint: &[((f64, f64), Tally)]) -> Self {
        let all: Tally = by_viewpoint.iter().map(|(_, tally)| *tally).sum();
        let interval = all.interval();
        let viewpoint =
            |&((azimuth_deg, elevation_deg), tally): &((f64, f64), Tally)| ViewpointResult {
                azimuth_deg,
                elevation_deg,
                probes: tally.probes,
                rank1: tally.rank1().unwrap_or_default(),
            };
        Self {
            name: contestant.name,
            runtime: contestant.runtime,
            protocol: contestant.protocol,
            classes: contestant.classes,
            probes: all.probes,
            rank1: all.rank1().unwrap_or_default(),
            rank1_low: interval.low,
            rank1_high: interval.high,
            rank1_by_subjects: None,
            non_finite: all.non_finite,
            trained_at: contestant.trained_at,
            by_viewpoint: by_viewpoint.iter().map(viewpoint).collect(),
            latency: None,
        }
    }

    /// The result with the interval over people, from each one's counts.
    #[must_use]
    pub fn with_subjects(mut self, subjects: &[Tally], seed: u64) -> Self {
        self.rank1_by_subjects =
            bootstrap_95(subjects, seed).map(|interval| (interval.low, interval.high));
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
pub(crate) mod tests {
    use super::*;

    /// A result of (azimuth, elevation, hits, probes).
    pub fn result_of(viewpoints: &[(f64, f64, u64, u64)]) -> RecognizerResult {
        let counts: Vec<_> = viewpoints
            .iter()
            .map(|&(azimuth, elevation, hits, probes)| {
                (
                    (azimuth, elevation),
                    Tally {
                        probes,
                        hits,
                        non_finite: 0,
                    },
                )
            })
            .collect();
        let contestant = Contestant {
            name: "pca-svm".into(),
            runtime: RuntimeName {
                name: "rten".into(),
                version: "0.27.0".into(),
            },
            protocol: Protocol::ClassScore,
            classes: 26,
            trained_at: Vec::new(),
        };
        RecognizerResult::new(contestant, &counts)
    }

    pub fn results_of(recognizers: Vec<RecognizerResult>) -> ScoreResults {
        ScoreResults {
            header: Header::new("score", 1).with("views", "paper"),
            silhouettes: 3200,
            geis: 100,
            clipped_share: Some(0.25),
            recognizers,
            time: Some(RunTime { seconds: 1.5 }),
        }
    }

    #[test]
    fn the_json_begins_with_the_header_and_has_the_documented_fields() {
        let mut recognizer = result_of(&[(90.0, 0.0, 19, 20)]);
        recognizer.latency = Latency::of(&[4.0]);
        let json = serde_json::to_string(&results_of(vec![recognizer])).unwrap();
        let version = env!("CARGO_PKG_VERSION");
        assert!(json.starts_with(&format!(
            r#"{{"schema":1,"command":"score","version":"{version}","seed":1,"inputs":[],"settings":{{"views":"paper"}},"warnings":[],"silhouettes":3200,"#
        )));
        assert!(json.contains(r#""protocol":"closed set by class score","classes":26,"probes":20,"rank1":0.95,"rank1_low":0.7638"#), "{json}");
        assert!(json.contains(
            r#"[{"azimuth_deg":90.0,"elevation_deg":0.0,"probes":20,"rank1":0.95}],"p50_us":4.0,"p90_us":4.0,"p99_us":null}],"seconds":1.5}"#
        ), "{json}");
    }

    #[test]
    fn json_comes_back_with_and_without_timings() {
        let mut recognizer =
            result_of(&[(90.0, 0.0, 19, 20)]).with_subjects(&[Tally::default()], 1);
        recognizer.latency = Latency::of(&[4.0, 8.0]);
        recognizer.trained_at = vec![(90.0, 0.0)];
        // serde_json without `float_roundtrip` reads some floats one unit off.
        (recognizer.rank1_low, recognizer.rank1_high) = (0.75, 1.0);
        let timed = results_of(vec![recognizer]);
        for results in [timed.clone(), timed.without_timings()] {
            let json = serde_json::to_string(&results).unwrap();
            assert_eq!(
                serde_json::from_str::<ScoreResults>(&json).unwrap(),
                results
            );
        }
    }

    #[test]
    fn without_timings_two_runs_are_equal() {
        let mut slow = results_of(vec![result_of(&[(0.0, 0.0, 1, 2)])]);
        let mut fast = slow.clone();
        slow.recognizers[0].latency = Latency::of(&[9.0]);
        fast.time = Some(RunTime { seconds: 0.1 });
        let bytes = |r: ScoreResults| serde_json::to_vec(&r.without_timings()).unwrap();
        assert_eq!(bytes(slow), bytes(fast));
    }

    #[test]
    fn percentiles_are_of_nearest_rank() {
        let samples: Vec<f64> = (1..=200).rev().map(f64::from).collect();
        let latency = Latency::of(&samples).unwrap();
        assert_eq!(
            (latency.p50_us, latency.p90_us, latency.p99_us),
            (100.0, 180.0, Some(198.0))
        );
        assert_eq!(Latency::of(&samples[..99]).unwrap().p99_us, None);
        assert_eq!(Latency::of(&[]), None);
    }

    #[test]
    fn counts_come_back_from_the_rates() {
        for probes in [1, 3, 7, 260, 999_983] {
            for hits in [0, 1, probes / 3, probes - 1, probes] {
                let result = result_of(&[(0.0, 0.0, hits, probes)]);
                assert_eq!(result.by_viewpoint[0].tally().hits, hits);
            }
        }
    }

    #[test]
    fn training_viewpoints_are_summed_apart() {
        let mut result = result_of(&[(90.0, 0.0, 9, 10), (45.0, 0.0, 5, 10), (0.0, 0.0, 0, 10)]);
        assert_eq!(result.at_training().rank1(), None);
        result.trained_at = vec![(90.0, 0.0), (45.0, 0.0), (45.0, 30.0)];
        assert_eq!(result.at_training().rank1(), Some(0.7));
        assert!((result.rank1 - 14.0 / 30.0).abs() < 1e-15);
    }
}
