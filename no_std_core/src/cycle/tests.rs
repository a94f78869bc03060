//! Tests with waves whose cycles are known, and with signals that are not walks.

extern crate std;

use super::*;
use core::f64::consts::TAU;
use std::string::ToString;
use std::vec;
use std::vec::Vec;

/// Returns the legs from the side at a time in seconds, with a cycle of `cycle_s` seconds: the
/// spread swings with the step, is larger when one of the legs is ahead, and has side peaks. It is
/// known to a 200th of the height.
fn side(time_s: f64, cycle_s: f64) -> LowerBody {
    let phase = TAU * time_s / cycle_s;
    let spread = 20.0 + 9.0 * (2.0 * phase).cos() + 2.5 * phase.cos() + 2.0 * (4.0 * phase).cos();
    LowerBody {
        spread: (spread.round() / 200.0) as f32,
        sway: (0.01 * (2.0 * phase).cos()) as f32,
    }
}

/// Returns the legs from 18 degrees beside the front: the feet are apart when one leg is ahead, and
/// cross when the other one is.
fn oblique(time_s: f64, cycle_s: f64) -> LowerBody {
    let phase = TAU * time_s / cycle_s;
    LowerBody {
        spread: (0.05 + 0.022 * phase.cos() + 0.006 * (2.0 * phase).cos()) as f32,
        sway: (0.009 * (phase + 0.4).cos()) as f32,
    }
}

/// Returns the legs from in front: the trunk sways over the standing foot.
fn front(time_s: f64, cycle_s: f64) -> LowerBody {
    let phase = TAU * time_s / cycle_s;
    LowerBody {
        spread: (0.045 + 0.002 * (2.0 * phase).cos()) as f32,
        sway: (0.01 * phase.sin()) as f32,
    }
}

/// Returns the cycles in frames, and the gait at the end.
fn found(
    rate_hz: f32,
    frames: impl IntoIterator<Item = Option<LowerBody>>,
) -> (Vec<DetectedCycle>, Result<Walking, NoCycle>) {
    let mut detector = CycleDetector::new(rate_hz).expect("a frame rate");
    let mut cycles = Vec::new();
    for frame in frames {
        cycles.extend(detector.push(frame));
    }
    let mut rest = detector.finish();
    cycles.extend(&mut rest);
    assert!(
        cycles.windows(2).all(|pair| pair[0].end <= pair[1].start),
        "{cycles:?}"
    );
    (cycles, rest.detector().walking())
}

/// Returns the frames of a walk of this many seconds.
fn walk(rate_hz: f32, cycle_s: f64, seconds: f64) -> impl Iterator<Item = Option<LowerBody>> {
    let frames = (f64::from(rate_hz) * seconds) as u32;
    (0..frames).map(move |frame| Some(side(f64::from(frame) / f64::from(rate_hz), cycle_s)))
}

/// Returns legs with this spread, whose trunk does not sway.
fn spread(spread: f64) -> LowerBody {
    LowerBody {
        spread: spread as f32,
        sway: 0.0,
    }
}

/// Returns a number from -1 to 1 for each frame: a linear congruential generator's high bits
/// (Knuth).
fn noise(frame: u32) -> f64 {
    let mut state = u64::from(frame) ^ 0x9e37_79b9_7f4a_7c15;
    for _ in 0..3 {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        state ^= state >> 33;
    }
    f64::from((state >> 40) as u32) / f64::from(1 << 23) - 1.0
}

/// Asserts that the boundaries of all cycles are where a step is widest, every half cycle, to
/// `close` frames, and that at least `fewest` cycles were found.
#[track_caller]
fn assert_cycles(cycles: &[DetectedCycle], cycle_frames: f64, (fewest, close): (usize, f64)) {
    assert!(cycles.len() >= fewest, "{}: {cycles:?}", cycles.len());
    for cycle in cycles {
        let off = cycle.period_frames() - cycle_frames;
        assert!(off.abs() < 2.0 * close, "{cycle:?}");
        let steps = cycle.start / (cycle_frames / 2.0);
        let off = (steps - steps.round()) * cycle_frames / 2.0;
        assert!(off.abs() < close, "{cycle:?}: {off}");
    }
}

#[test]
fn a_walk_has_its_cycles_at_any_frame_rate_and_cadence() {
    for rate_hz in [
        10.0, 15.0, 24.0, 25.0, 29.97, 30.0, 33.0, 50.0, 60.0, 90.0, 120.0,
    ] {
        for cadence in [72.0, 90.0, 112.0, 140.0, 180.0, 215.0] {
            let cycle_s = 120.0 / cadence;
            let (cycles, end) = found(rate_hz, walk(rate_hz, cycle_s, 8.0));
            let frames = cycle_s * f64::from(rate_hz);
            let whole = (8.0 / cycle_s) as usize;
            // A hundredth of a second, and a tenth of a frame.
            let close = 0.01 * f64::from(rate_hz) + 0.1;
            assert_cycles(&cycles, frames, (whole - 1, close));
            let period = f64::from(end.expect("a walk").period_frames);
            // With three frames a step, its side peaks alias.
            let close = if frames < 8.0 { 0.03 } else { 0.02 };
            let off = (period / frames - 1.0).abs();
            assert!(off < close, "{rate_hz} {cadence} {period}");
        }
    }
}

#[test]
fn the_paper_s_peaks_are_found_between_the_frames_that_show_them() {
    // Sarkar's lower-body pixels with left and right steps of 9 and 10 (peaks 2, 8, 14, 20, 26):
    // every second peak bounds a cycle. Ten frames a second.
    let counts = [
        5, 7, 9, 7, 5, 3, 5, 7, 10, 7, 5, 3, 5, 7, 9, 7, 5, 3, 5, 7, 10, 7, 5, 3, 5, 7, 9, 7_u8,
    ];
    let frames = counts.map(|count| Some(spread(f64::from(count) / 60.0)));
    let (cycles, _) = found(10.0, frames);
    let [first, second] = cycles[..] else {
        panic!("{cycles:?}");
    };
    for (place, expected) in [
        (first.start, 2.0),
        (first.end, 14.0),
        (second.start, 14.0),
        (second.end, 26.0),
    ] {
        assert!(
            (place - expected).abs() < 0.15,
            "{place}, expected {expected}"
        );
    }
}

#[test]
fn from_each_side_the_cycle_is_found_and_neither_its_half_nor_its_double() {
    for cadence in [80.0, 95.0, 110.0, 125.0, 140.0] {
        for rate_hz in [25.0, 30.0, 60.0] {
            let cycle_s = 120.0 / cadence;
            for legs in [side, oblique, front] {
                let frames = (0..(10.0 * rate_hz) as u32)
                    .map(|frame| Some(legs(f64::from(frame) / f64::from(rate_hz), cycle_s)));
                let (cycles, end) = found(rate_hz, frames);
                let frames = cycle_s * f64::from(rate_hz);
                let off = f64::from(end.expect("a walk").period_frames) / frames - 1.0;
                assert!(off.abs() < 0.05, "{cadence} {rate_hz}: {off}");
                let fewest = (10.0 / cycle_s) as usize - 2;
                assert!(cycles.len() >= fewest, "{cadence} {rate_hz}: {cycles:?}");
                let mut periods: Vec<f64> =
                    cycles.iter().map(DetectedCycle::period_frames).collect();
                periods.sort_by(f64::total_cmp);
                let off = periods[periods.len() / 2] / frames - 1.0;
                assert!(off.abs() < 0.02, "{cadence} {rate_hz}: {off}");
            }
        }
    }
}

#[test]
fn slower_steps_are_not_read_by_their_harmonic() {
    for cadence in [24.0, 40.0, 50.0, 60.0] {
        for rate_hz in [10.0, 25.0, 30.0, 60.0] {
            // A side peak at twice the frequency of the steps, more than half as high.
            let legs = |frame: u32| {
                let phase = TAU * f64::from(frame) / f64::from(rate_hz) * cadence / 60.0;
                Some(spread(
                    0.1 + 0.03 * phase.cos() + 0.017 * (2.0 * phase).cos(),
                ))
            };
            let (cycles, end) = found(rate_hz, (0..(20.0 * rate_hz) as u32).map(legs));
            assert_eq!(cycles, [], "{cadence} {rate_hz}");
            let Err(NoCycle::Slower { steps_per_minute }) = end else {
                panic!("{cadence} {rate_hz}: {end:?}");
            };
            // The window holds 3.4 seconds: one and a third of the slowest waves, whose number is a guess.
            let off = f64::from(steps_per_minute) - cadence;
            let most = if cadence < 30.0 { 14.0 } else { 6.0 };
            assert!(off.abs() < most, "{cadence} {rate_hz}: {steps_per_minute}");
        }
    }
}

#[test]
fn a_cycle_is_reported_one_cycle_after_it_ended() {
    let mut detector = CycleDetector::new(30.0).expect("a frame rate");
    let mut reported = 0;
    for (number, frame) in walk(30.0, 1.0, 20.0).enumerate() {
        if let Some(cycle) = detector.push(frame) {
            // Two steps and 0.2 seconds.
            let late = number as f64 - cycle.end;
            assert!((0.0..=30.0 + 6.0).contains(&late), "{number}: {cycle:?}");
            reported += 1;
        }
    }
    assert!(reported >= 18, "{reported}");
}

#[test]
fn frames_that_are_missing_or_full_of_holes_move_boundaries_little() {
    // Every 7th frame is blank, and once 6 in a row.
    let gaps = walk(30.0, 1.1, 12.0).enumerate().map(|(number, frame)| {
        let is_blank = number % 7 == 3 || (100..106).contains(&number);
        frame.filter(|_| !is_blank)
    });
    let (cycles, _) = found(30.0, gaps);
    assert_cycles(&cycles, 33.0, (9, 1.0));
    let noisy = walk(30.0, 1.1, 12.0).zip(0..).map(|(frame, number)| {
        frame.map(|legs| LowerBody {
            spread: legs.spread + (0.02 * noise(number)) as f32,
            sway: legs.sway + (0.02 * noise(number + 9_999)) as f32,
        })
    });
    let (cycles, _) = found(30.0, noisy);
    assert_cycles(&cycles, 33.0, (9, 1.5));
}

#[test]
fn somebody_who_stands_and_then_walks_has_cycles_from_the_first_step_on() {
    let standing = (0..120).map(|number| {
        Some(LowerBody {
            spread: 0.06 + 0.001 * noise(number) as f32,
            sway: 0.002 * noise(number + 9_999) as f32,
        })
    });
    let (cycles, end) = found(30.0, standing.clone());
    assert_eq!(cycles, []);
    assert!(matches!(end, Err(NoCycle::Standing { .. })), "{end:?}");
    let (cycles, _) = found(30.0, standing.chain(walk(30.0, 1.0, 6.0)));
    // The fit may lose the first steps, but finds none before them.
    assert_cycles(&cycles, 30.0, (4, 2.0));
    assert!(cycles[0].start > 110.0, "{cycles:?}");
}

#[test]
fn a_turn_breaks_the_row_of_cycles_and_no_cycle_has_it_within() {
    // From the side, then frontal with legs that swing at another phase, then from the other side.
    let turn = |number: u32| {
        let time_s = f64::from(number) / 30.0;
        match number {
            150..=239 => front(time_s - 0.2, 1.0),
            _ => side(time_s, 1.0),
        }
    };
    let (cycles, _) = found(30.0, (0..390).map(|number| Some(turn(number))));
    let side = |cycle: &&DetectedCycle| cycle.end < 150.0 || cycle.start >= 240.0;
    assert!(cycles.iter().filter(side).count() >= 6, "{cycles:?}");
    for cycle in &cycles {
        assert!((cycle.period_frames() - 30.0).abs() < 7.0, "{cycle:?}");
    }
}

#[test]
fn nobody_and_nothing_that_moves_says_so() {
    let reason = |frames: &mut dyn Iterator<Item = Option<LowerBody>>| {
        let (cycles, end) = found(30.0, frames);
        assert_eq!(cycles, []);
        end.expect_err("no walk")
    };
    let still = Some(spread(0.06));
    let seconds = |frame| core::iter::repeat_n(frame, 150);
    assert_eq!(reason(&mut seconds(None)), NoCycle::Absent);
    let NoCycle::Standing { swing } = reason(&mut seconds(still)) else {
        panic!("somebody stands");
    };
    assert!(swing < 1e-6, "{swing}");
    assert_eq!(
        reason(&mut core::iter::empty()),
        NoCycle::TooShort { frames: 0 }
    );
    assert_eq!(
        reason(&mut core::iter::once(still)),
        NoCycle::TooShort { frames: 1 }
    );
    let short = &mut walk(30.0, 1.0, 0.5);
    assert_eq!(reason(short), NoCycle::TooShort { frames: 15 });
    // A person in every third frame.
    let mostly_absent = &mut (0..150).map(|number| still.filter(|_| number % 3 == 0));
    assert_eq!(reason(mostly_absent), NoCycle::Absent);
    let growing = &mut (0..150_u8).map(|number| Some(spread(0.06 + 0.0002 * f64::from(number))));
    assert!(matches!(reason(growing), NoCycle::Standing { .. }));
}

#[test]
fn noise_is_no_walk() {
    let (mut cycles, mut seconds) = (0, 0);
    for seed in 0..40 {
        let random = (0..300).map(|number| {
            Some(LowerBody {
                spread: 0.08 + 0.03 * noise(1_000 * seed + number) as f32,
                sway: 0.02 * noise(77_777 + 1_000 * seed + number) as f32,
            })
        });
        cycles += found(30.0, random).0.len();
        seconds += 10;
    }
    // A walk would have about one a second.
    assert!(
        cycles * 20 <= seconds,
        "{cycles} cycles in {seconds} seconds"
    );
}

#[test]
fn numbers_that_are_none_count_as_nobody() {
    let legs = |spread, sway| Some(LowerBody { spread, sway });
    for bad in [
        legs(f32::NAN, 0.0),
        legs(0.1, f32::NAN),
        legs(f32::INFINITY, 0.0),
        legs(0.1, f32::NEG_INFINITY),
        legs(-0.1, 0.0),
        legs(0.0, 0.0),
        legs(f32::MAX, f32::MAX),
    ] {
        let (cycles, end) = found(30.0, core::iter::repeat_n(bad, 150));
        assert_eq!((cycles, end), (vec![], Err(NoCycle::Absent)), "{bad:?}");
        let every_ninth = walk(30.0, 1.0, 10.0).enumerate();
        let mixed = every_ninth.map(|(number, good)| if number % 9 == 0 { bad } else { good });
        assert_cycles(&found(30.0, mixed).0, 30.0, (8, 1.0));
    }
}

#[test]
fn frame_rates_that_are_too_low_or_too_high_are_refused() {
    for rate_hz in [0.0, -30.0, 9.99, 120.1, f32::NAN, f32::INFINITY] {
        let error = CycleDetector::new(rate_hz).expect_err("no frame rate");
        let text = error.to_string();
        assert!(
            text.starts_with("expected 10 to 120 frames a second, found "),
            "{text}"
        );
    }
}

#[test]
fn a_million_frames_have_as_many_cycles_as_steps_are_made() {
    // 2 hours 19 minutes at 120 frames a second; a cycle takes 1.0625 seconds, 127.5 frames.
    let mut detector = CycleDetector::new(120.0).expect("a frame rate");
    let mut last: Option<DetectedCycle> = None;
    let mut count = 0;
    for number in 0..1_000_000_u32 {
        // In whole cycles of 255 half frames, so that no wave's argument grows.
        let time_s = f64::from((2 * number) % 255) / 240.0;
        if let Some(cycle) = detector.push(Some(side(time_s, 1.0625))) {
            count += 1;
            assert!((cycle.period_frames() - 127.5).abs() < 1.0, "{cycle:?}");
            assert!(last.is_none_or(|last| last.end == cycle.start));
            last = Some(cycle);
        }
    }
    let end = last.expect("cycles").end;
    // 1,000,000 / 127.5 = 7,843.1, of which the last is not reported yet.
    assert!((7_840..=7_843).contains(&count), "{count}");
    assert!((1_000_000.0 - end) < 3.0 * 127.5, "{end}");
}

#[test]
fn legs_are_measured_by_the_definitions() {
    use crate::silhouette::{Silhouette, Size};
    // Twelve rows, from row 10 on: eight of the columns 4 to 7, then legs.
    let mut rows = [0_u64; 22];
    rows[10..19].fill(0b1111_0000);
    rows[19..21].fill(0b0110_0110_0000);
    rows[21] = 0b0010_0000_0100;
    let silhouette = Silhouette::from_rows(Size::S50x30, &rows);
    // The lowest third are four rows: columns 4 to 7, twice 5, 6, 9 and 10, then 2 and 9. Their sum
    // is 22 + 60 + 11 = 93 and the sum of their squares 126 + 484 + 85 = 695, of 14 pixels.
    let spread = (695.0_f64 / 14.0 - (93.0_f64 / 14.0).powi(2)).sqrt() / 12.0;
    // The lowest quarter are three rows, with 71 / 10; the mean of the upper half is 5.5.
    let sway = (7.1 - 5.5) / 12.0;
    let expected = LowerBody {
        spread: spread as f32,
        sway: sway as f32,
    };
    let found = LowerBody::measure(&silhouette).expect("a figure");
    assert!(
        (found.spread - expected.spread).abs() < 1e-7,
        "{found:?} {expected:?}"
    );
    assert!(
        (found.sway - expected.sway).abs() < 1e-7,
        "{found:?} {expected:?}"
    );
    let coverage = silhouette.to_coverage();
    assert_eq!(LowerBody::of_pixels(coverage.pixels(), 30), Some(found));
    assert_eq!(LowerBody::measure(&Silhouette::empty(Size::S64x64)), None);
    assert_eq!(LowerBody::of_pixels(&[127; 100], 10), None);
    assert_eq!(LowerBody::of_pixels(&[255; 100], 0), None);
    // One pixel is a figure of one row.
    assert_eq!(
        LowerBody::of_pixels(&[0, 0, 255, 0], 2),
        Some(LowerBody::default())
    );
}
