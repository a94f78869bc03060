//! Tests of values that follow from windows, computed by hand.

use super::*;
use crate::bench::results::BenchResults;
use crate::bench::video_pipeline::laps::{Laps, PathStage};
use std::time::Duration;

/// Two windows: 100 frames in 2 s, 80 in 2 s, with 180 ms of decoding.
fn measured() -> MeasuredPath {
    let mut ms = 0;
    let mut clock = || {
        ms += 1;
        Duration::from_millis(ms)
    };
    let mut laps = Laps::new(&mut clock);
    // 180 times 1 ms of decoding; the other stages do not matter.
    for _ in 0..180 {
        laps.lap(PathStage::Decode);
        laps.lap(PathStage::Segment);
        laps.lap(PathStage::Framing);
        laps.lap(PathStage::Cycle);
        laps.close();
    }
    laps.lap(PathStage::Template);
    laps.lap(PathStage::Network);
    let stages = laps.stages().expect("all");
    let window = |frames: u64, energy_j| PathWindow {
        seconds: 2.0,
        frames,
        answers: 2,
        frames_per_second: frames as f64 / 2.0,
        energy_j,
    };
    MeasuredPath {
        windows: vec![window(100, Some(0.5)), window(80, Some(0.4))],
        answer: stages.network,
        stages,
        waited: (30, 12),
        answers: 4,
        non_finite: 0,
        again: 3,
    }
}

#[test]
fn rates_are_frames_over_seconds() {
    let rates = PathRates::from_measured(&measured(), 25.0).expect("windows");
    assert_eq!((rates.seconds, rates.frames), (4.0, 180));
    assert_eq!(
        (rates.frames_per_second, rates.times_real_time),
        (45.0, 1.8)
    );
    let windows = (
        rates.first_per_second,
        rates.last_per_second,
        rates.slowest_per_second,
    );
    assert_eq!(windows, (50.0, 40.0, 40.0));
    // 4 s less 0.18 s.
    assert!((rates.without_decoding_per_second - 180.0 / 3.82).abs() < 1e-9);
    assert_eq!(
        rates.doubts(),
        ["the last window has 20 % fewer frames a second than the first"]
    );
    let slow = PathRates::from_measured(&measured(), 60.0).expect("windows");
    assert_eq!(
        slow.doubts()[0],
        "processing does not keep up with the video: 45.0 frames a second are 0.75 of its rate"
    );
}

#[test]
fn answers_and_energy_are_shared_out() {
    let mut measured = measured();
    let answers = PathAnswers::from_measured(&measured).expect("answers");
    assert_eq!((answers.count, answers.per_second), (4, 1.0));
    assert_eq!(
        (answers.waited_frames_mean, answers.waited_frames_most),
        (7.5, 12)
    );
    let energy = |measured: &MeasuredPath| {
        let energy = PathEnergy::from_windows("a sensor", &measured.windows);
        energy.map(|energy| energy.frame_mj)
    };
    // 0.9 J of 180 frames.
    assert!((energy(&measured).expect("metered") - 5.0).abs() < 1e-9);
    measured.windows[1].energy_j = None;
    assert_eq!(energy(&measured), None);
}

#[test]
fn results_of_versions_without_videos_are_read() {
    let old = r#"{"schema":1,"command":"bench","version":"0.1.0","seed":1,"inputs":[],"settings":{},
        "warnings":[],"date":"2026-11-21T20:38:00Z","board":{"architecture":"aarch64","cpus":[],
        "features":[]},"models":[]}"#;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("old.json");
    std::fs::write(&path, old).expect("written");
    let found = BenchResults::read(&path).expect("read");
    assert!(found.paths.is_empty());
    assert!(
        !serde_json::to_string(&found)
            .expect("JSON")
            .contains("paths")
    );
}
