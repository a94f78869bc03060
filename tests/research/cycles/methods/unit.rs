//! Tests of the methods on numbers that can be worked out by hand.

use super::*;

/// Lower-body pixels of 28 frames whose left and right steps differ: a peak every 6 frames, a cycle
/// every 12.
const COUNTS: [u8; 28] = [
    5, 7, 9, 7, 5, 3, 5, 7, 10, 7, 5, 3, 5, 7, 9, 7, 5, 3, 5, 7, 10, 7, 5, 3, 5, 7, 9, 7,
];

const METHODS: [CycleMethod; 6] = [
    CycleMethod::Peaks(Signal::Pixels),
    CycleMethod::Peaks(Signal::Width),
    CycleMethod::Minima(Signal::Pixels),
    CycleMethod::Minima(Signal::Width),
    CycleMethod::Autocorrelation(Signal::Pixels),
    CycleMethod::Autocorrelation(Signal::Width),
];

fn counted(pixels: f32) -> Outline {
    Outline { pixels, width: 0.0 }
}

fn counts() -> impl Iterator<Item = Option<Outline>> + Clone {
    let counts = COUNTS.into_iter();
    counts.map(|count| Some(counted(count.into())))
}

fn by(
    method: CycleMethod,
    frames: impl IntoIterator<Item = Option<Outline>>,
) -> Result<FoundCycles, NoCycle> {
    // A step takes six frames at 10 a second, and a cycle 1.2 seconds.
    method.find(10.0, frames)
}

fn bounds(found: &FoundCycles) -> Vec<[f64; 2]> {
    let cycles = found.cycles.iter();
    cycles.map(|cycle| [cycle.start, cycle.end]).collect()
}

#[test]
fn every_second_peak_bounds_a_cycle() {
    // Peaks are at 2, 8, 14, 20, 26. Successive ones would give 6, half the period.
    let found = by(CycleMethod::Peaks(Signal::Pixels), counts()).expect("cycles");
    assert_eq!(bounds(&found), [[2.0, 14.0], [14.0, 26.0]]);
    assert_eq!((found.period_frames, found.regular), (12.0, 1.0));
}

#[test]
fn the_period_is_the_mean_of_two_medians_over_every_second_minimum() {
    // Minima 5, 11, 17, 23: medians 12 (5 to 17) and 12 (11 to 23).
    let found = by(CycleMethod::Minima(Signal::Pixels), counts()).expect("cycles");
    assert_eq!(found.period_frames, 12.0);
    assert_eq!(bounds(&found), [[5.0, 17.0]]);
}

#[test]
fn the_autocorrelation_agrees_with_the_peaks() {
    let method = CycleMethod::Autocorrelation(Signal::Pixels);
    let found = by(method, counts()).expect("cycles");
    assert!((found.period_frames - 12.0).abs() < 0.15, "{found:?}");
    let [[start, middle], [_, end]] = bounds(&found)[..] else {
        panic!("{found:?}");
    };
    for (place, expected) in [(start, 2.0), (middle, 14.0), (end, 26.0)] {
        assert!((place - expected).abs() < 0.3, "{place}");
    }
}

#[test]
fn peaks_that_are_flat_or_lean_lie_between_frames() {
    // A flat top of two frames, and one whose neighbours are 8 and 6 around 9.
    let values = [5, 7, 9, 9, 7, 5, 3, 5, 8, 9, 6, 3, 5, 7, 9, 9, 7, 5_u8];
    let frames = values.map(|count| Some(counted(count.into())));
    let found = by(CycleMethod::Peaks(Signal::Pixels), frames).expect("cycles");
    assert_eq!(bounds(&found), [[2.5, 14.5]]);
    // 9 + 0.5 (8 - 6) / (8 - 18 + 6) = 8.75, and the cycle from there on is not complete.
    let frames = values[6..].iter().chain(&values[6..]).chain(&values[6..]);
    let frames = frames.map(|&count| Some(counted(count.into())));
    let found = by(CycleMethod::Peaks(Signal::Pixels), frames).expect("cycles");
    assert_eq!(found.cycles[0].start, 2.75);
}

#[test]
fn gaps_are_bridged_and_mostly_empty_recordings_refused() {
    // The frames on the flanks are missing; straight lines restore them.
    let gaps = counts().enumerate();
    let gaps = gaps.map(|(at, frame)| frame.filter(|_| ![4, 10, 13, 16, 22].contains(&at)));
    let found = by(CycleMethod::Peaks(Signal::Pixels), gaps).expect("cycles");
    assert_eq!(bounds(&found), [[2.0, 14.0], [14.0, 26.0]]);
    let rare = counts().enumerate();
    let rare = rare.map(|(at, frame)| frame.filter(|_| at % 3 == 0));
    for method in METHODS {
        assert_eq!(by(method, rare.clone()), Err(NoCycle::Absent), "{method:?}");
    }
}

#[test]
fn what_is_no_walk_is_said_to_be_none_by_each_method() {
    let still = Some(Outline {
        pixels: 900.0,
        width: 40.0,
    });
    for method in METHODS {
        assert_eq!(by(method, []), Err(NoCycle::TooShort { frames: 0 }));
        assert_eq!(by(method, [still]), Err(NoCycle::TooShort { frames: 1 }));
        assert_eq!(by(method, [None; 60]), Err(NoCycle::Absent));
        let standing = by(method, [still; 60]);
        assert!(
            matches!(standing, Err(NoCycle::Standing { swing }) if swing < 1e-6),
            "{method:?}: {standing:?}"
        );
        // One step and a half.
        let short = by(method, counts().take(9));
        assert!(short.is_err(), "{method:?}: {short:?}");
        let nothing = Some(Outline {
            pixels: f32::NAN,
            width: f32::INFINITY,
        });
        assert_eq!(
            by(method, [nothing; 60]),
            Err(NoCycle::Absent),
            "{method:?}"
        );
        // A single step up.
        let once = (0..60_u8).map(|at| {
            let size = if at < 30 { 40.0 } else { 60.0 };
            Some(Outline {
                pixels: 20.0 * size,
                width: size,
            })
        });
        let once = by(method, once);
        assert!(once.is_err(), "{method:?}: {once:?}");
    }
}
