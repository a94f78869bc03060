//! A test that gait cycles begin and end at the same bits on every target.

use edgegait_core::cycle::{CycleDetector, LowerBody};

/// Steps of six samples: a left one, and a right one of other widths.
const STEP: [[u8; 6]; 2] = [[33, 38, 47, 52, 45, 37], [34, 40, 50, 57, 48, 38]];

/// Returns the legs at a frame, in 512ths of the height.
fn legs(frame: usize) -> LowerBody {
    let width = f32::from(STEP[frame / 6 % 2][frame % 6]);
    LowerBody {
        spread: width / 512.0,
        sway: (width - 44.0) / 2048.0,
    }
}

#[test]
fn boundaries_are_the_same_bits_everywhere() {
    let mut detector = CycleDetector::new(12.5).expect("a frame rate");
    let mut found = Vec::new();
    for frame in 0..64 {
        found.extend(detector.push(Some(legs(frame))));
    }
    found.extend(detector.finish());
    let ends: Vec<f64> = found.iter().map(|cycle| cycle.end).collect();
    // The widest frame of a step is its fourth, and the third is wider than the fifth.
    for (end, expected) in ends.iter().zip([14.9, 26.9, 38.9, 50.9, 62.9]) {
        assert!((end - expected).abs() < 0.1, "{ends:?}");
    }
    let bits: Vec<u64> = ends.iter().map(|end| end.to_bits()).collect();
    let expected = [
        0x402d_d000_c000_0000,
        0x403a_e800_6000_0000,
        0x4043_7400_3000_0000,
        0x4049_7400_3000_0000,
        0x404f_70e7_6000_0000,
    ];
    assert_eq!(bits, expected, "{ends:?}");
}
