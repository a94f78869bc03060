use super::*;

/// Returns a result from (azimuth, elevation, hits, probes).
pub(crate) fn result_of(viewpoints: &[(f64, f64, u64, u64)]) -> RecognizerResult {
    let labels = viewpoints
        .iter()
        .map(|&(azimuth, elevation, ..)| ViewLabel::Angles(azimuth, elevation));
    let labels: Vec<ViewLabel> = labels.collect();
    let counts: Vec<_> = viewpoints
        .iter()
        .zip(&labels)
        .map(|(&(_, _, hits, probes), label)| {
            (
                label,
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
            ..RuntimeName::default()
        },
        protocol: "closed-set".into(),
        classes: 26,
        trained_at: Vec::new(),
    };
    RecognizerResult::new(contestant, &counts)
}

/// Returns a set of 26 probes of 26 people, `hits` of them right.
pub(crate) fn set(name: &str, clean: bool, hits: u32) -> ProbeSetResult {
    let rank1 = f64::from(hits) / 26.0;
    ProbeSetResult {
        name: name.into(),
        clean,
        probes: 26,
        people: 26,
        tied: 0,
        without_mate: 0,
        non_finite: 0,
        rank1,
        intervals: Rank1Intervals {
            rank1_wilson_high: 1.0,
            ..Rank1Intervals::default()
        },
        rank5: 1.0,
        cmc: vec![rank1, 1.0],
        map: None,
        map_low: None,
        map_high: None,
        minp: None,
        by_person: Vec::new(),
        verification: None,
        cross_view: None,
    }
}

pub(crate) fn results_of(recognizers: Vec<RecognizerResult>) -> ScoreResults {
    ScoreResults {
        header: ResultHeader::new("score", 1).with("views", "paper"),
        silhouettes: 3200,
        geis: 100,
        clipped_share: Some(0.25),
        recognizers,
        paired: Vec::new(),
        time: Some(RunTime { seconds: 1.5 }),
    }
}

#[test]
fn the_json_begins_with_the_header_and_has_the_documented_fields() {
    let mut recognizer = result_of(&[(90.0, 0.0, 19, 20)]);
    recognizer.latency = Latency::from_samples(&[4.0]);
    let json = serde_json::to_string(&results_of(vec![recognizer])).unwrap();
    let version = env!("CARGO_PKG_VERSION");
    assert!(json.starts_with(&format!(
        r#"{{"schema":1,"command":"score","version":"{version}","seed":1,"inputs":[],"settings":{{"views":"paper"}},"warnings":[],"silhouettes":3200,"#
    )));
    assert!(json.contains(r#""protocol":"closed-set","classes":26,"of_probe_sets":[],"probes":20,"people":0,"rank1":0.95,"rank1_low":null,"rank1_high":null,"rank1_wilson_low":0.7638"#), "{json}");
    assert!(json.contains(
        r#"[{"azimuth_deg":90.0,"elevation_deg":0.0,"probes":20,"rank1":0.95}],"by_angle":[],"by_person":[],"probe_sets":[],"p50_us":4.0,"p90_us":null,"p99_us":null,"model_bytes":null}],"paired":[],"seconds":1.5}"#
    ), "{json}");
}

#[test]
fn json_comes_back_with_and_without_timings() {
    let mut recognizer = result_of(&[(90.0, 0.0, 19, 20)]).with_subjects(&[Tally::default()], 1);
    recognizer.latency = Latency::from_samples(&[4.0, 8.0]);
    recognizer.trained_at = vec![(90.0, 0.0)];
    // serde_json without `float_roundtrip` reads some floats one unit off.
    recognizer.intervals = Rank1Intervals {
        rank1_low: Some(0.5),
        rank1_high: Some(0.75),
        rank1_wilson_low: 0.75,
        rank1_wilson_high: 1.0,
    };
    let timed = results_of(vec![recognizer]);
    let mut untimed = timed.clone();
    untimed.time = None;
    untimed.recognizers[0].latency = None;
    for results in [timed, untimed] {
        let json = serde_json::to_string(&results).unwrap();
        assert_eq!(
            serde_json::from_str::<ScoreResults>(&json).unwrap(),
            results
        );
    }
}

#[test]
fn percentiles_are_of_nearest_rank() {
    let samples: Vec<f64> = (1..=200).rev().map(f64::from).collect();
    let latency = Latency::from_samples(&samples).unwrap();
    assert_eq!(
        (latency.p50_us, latency.p90_us, latency.p99_us),
        (100.0, Some(180.0), Some(198.0))
    );
    assert_eq!(Latency::from_samples(&samples[..99]).unwrap().p99_us, None);
    // With 10 samples, the 9th.
    assert_eq!(
        Latency::from_samples(&samples[..10]).unwrap().p90_us,
        Some(199.0)
    );
    assert_eq!(Latency::from_samples(&samples[..9]).unwrap().p90_us, None);
    assert_eq!(Latency::from_samples(&[]), None);
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
