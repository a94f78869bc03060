//! Tests of uncut clips: written by hand, damaged, and ten hours long.

extern crate std;

use super::*;
use crate::format::{
    BLOCK_INTERVALS, CODEBOOK_BYTES, HEADING, INTEGER_WIDTH_BITS, SPACING_BITS, SPACING_CONSTANT,
    STEPS_AT, width_bits,
};
use std::vec::Vec;

/// A codebook without references, bases and groups, whose steps are those of the scale.
const CODEBOOK: [u8; CODEBOOK_BYTES + 45] = [0; CODEBOOK_BYTES + 45];
/// Steps of 0.125 rad or m.
const EIGHTH: u8 = 136;

fn codebook() -> Codebook<'static> {
    Codebook::parse(&CODEBOOK).unwrap()
}

#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    len: u32,
}

impl Bits {
    fn push(&mut self, value: i32, width: u32) {
        for bit in 0..width {
            if self.len.is_multiple_of(8) {
                self.bytes.push(0);
            }
            *self.bytes.last_mut().unwrap() |= ((value >> bit & 1) as u8) << (self.len % 8);
            self.len += 1;
        }
    }
}

/// Returns an uncut clip in which the channels of `moving` (channel, spacing, small knots) move,
/// and the channels of `still` have constant values.
fn take(
    duration_us: u64,
    interval_us: u32,
    moving: &[(usize, u32, &[i32])],
    still: &[(usize, i32)],
) -> Vec<u8> {
    const WIDEST: u32 = 9;
    let mut bytes = Vec::from([CLIP_UNCUT, EIGHTH]);
    bytes.extend(duration_us.to_le_bytes());
    bytes.extend(interval_us.to_le_bytes());
    bytes.extend([100, 0, 50, 0, 7, 0, 0, 0]);
    let (mut table, mut blocks) = (Bits::default(), Vec::<Bits>::new());
    for channel in 0..UNCUT_CHANNELS {
        let Some((_, spacing, knots)) = moving.iter().find(|(c, ..)| *c == channel) else {
            let value = still.iter().find(|(c, _)| *c == channel).map_or(0, |s| s.1);
            table.push(SPACING_CONSTANT as i32, SPACING_BITS);
            table.push(8, INTEGER_WIDTH_BITS);
            table.push(value, 8);
            continue;
        };
        let least = *knots.iter().min().unwrap();
        table.push(*spacing as i32, SPACING_BITS);
        table.push(8, INTEGER_WIDTH_BITS);
        table.push(least, 8);
        table.push(WIDEST as i32, INTEGER_WIDTH_BITS);
        table.push(WIDEST as i32, INTEGER_WIDTH_BITS);
        for (number, knots) in knots
            .chunks(BLOCK_INTERVALS as usize >> spacing)
            .enumerate()
        {
            if number == blocks.len() {
                blocks.push(Bits::default());
            }
            let base = *knots.iter().min().unwrap();
            // Blocks differ in their widths.
            let width = WIDEST - (number as u32 % 2);
            blocks[number].push(base - least, WIDEST);
            blocks[number].push(width as i32, width_bits(WIDEST));
            for knot in knots {
                blocks[number].push(knot - base, width);
            }
        }
    }
    bytes.extend(table.bytes);
    let mut end = 0;
    for block in &blocks {
        end += block.bytes.len() as u32;
        bytes.extend(end.to_le_bytes());
    }
    bytes.extend(blocks.into_iter().flat_map(|block| block.bytes));
    bytes
}

/// Returns a clip of 3 seconds: 1 m/s along Z, turning by 2 rad/s, a left elbow bent by 0.5 and a
/// root at a height of 1 m. Knots of a straight line are its values, from one interval before the
/// start.
fn turning_walk() -> Vec<u8> {
    let ahead = [-8, 0, 8, 16, 24, 32];
    let turned = [-32, 0, 32, 64, 96];
    let elbow = 3 * Joint::LeftForearm.index();
    take(
        3_000_000,
        1_000_000,
        &[(3 * JOINTS + 2, 0, &ahead), (HEADING, 1, &turned)],
        &[(elbow, 4), (3 * JOINTS + 1, 8)],
    )
}

fn parse<'a>(bytes: &'a [u8], codebook: &Codebook<'a>) -> Result<UncutClip<'a>, FormatError> {
    let take = UncutClip::over(bytes, codebook)?;
    take.check().map(|()| take)
}

#[test]
fn a_take_walks_and_turns_as_its_knots_say() {
    let (bytes, codebook) = (turning_walk(), codebook());
    let take = parse(&bytes, &codebook).unwrap();
    assert_eq!((take.duration_s(), take.frames()), (3.0, 7));
    assert_eq!((take.max_error_mm(), take.mean_error_mm()), (1.0, 0.5));
    assert_eq!(take.len_bytes(), bytes.len());
    for tenths in 0..=30u8 {
        let seconds = f32::from(tenths) * 0.1;
        let pose = take.sample(f64::from(seconds));
        assert!(
            pose.root.abs_diff_eq(Vec3::new(0.0, 1.0, seconds), 1e-5),
            "{}",
            pose.root
        );
        let pelvis = Quat::from_rotation_y(2.0 * seconds);
        let turned = pose.rotations[Joint::Pelvis.index()];
        assert!(turned.dot(pelvis).abs() > 1.0 - 1e-6, "{turned} {pelvis}");
        // 4 tan(a / 4) = 0.5.
        let elbow = pose.rotations[Joint::LeftForearm.index()];
        assert!((elbow.x - libm::sinf(2.0 * libm::atanf(0.125))).abs() < 1e-6);
    }
}

#[test]
fn any_time_is_taken() {
    let (bytes, codebook) = (turning_walk(), codebook());
    let take = parse(&bytes, &codebook).unwrap();
    let (first, last) = (take.sample(0.0), take.sample(3.0));
    for early in [-1.0, -1e300, f64::MIN_POSITIVE, f64::NAN, f64::INFINITY] {
        assert_eq!(take.sample(early), first, "{early}");
    }
    for late in [3.000_001, 1e9, f64::MAX] {
        assert_eq!(take.sample(late), last, "{late}");
    }
}

#[test]
fn four_knots_lie_in_two_blocks_for_every_spacing() {
    // A straight line again: 40 intervals of 0.1 s, and three more knots.
    for spacing in 0..SPACING_CONSTANT {
        let apart = 1 << spacing;
        let knots: Vec<i32> = (-1..40 / apart + 2).map(|k| k * apart).collect();
        let bytes = take(4_000_000, 100_000, &[(3 * JOINTS, spacing, &knots)], &[]);
        let codebook = codebook();
        let take = parse(&bytes, &codebook).unwrap();
        for moment in 0..=400u16 {
            let seconds = f64::from(moment) * 0.01;
            let x = f64::from(take.sample(seconds).root.x);
            // An eighth of a metre each interval.
            assert!(
                (x - seconds * 1.25).abs() < 1e-5,
                "{spacing} {seconds}: {x}"
            );
        }
    }
}

#[test]
fn the_tenth_hour_is_as_precise_as_the_first_second() {
    // A pattern of seven knots, 0.7 s; 51,430 of them take ten hours and a second.
    let intervals = 7 * 51_430;
    let knots: Vec<i32> = (0..intervals + 3)
        .map(|k| [0, 3, 1, 9, 4, 0, 7][k % 7])
        .collect();
    let moving: [(usize, u32, &[i32]); 1] = [(3 * JOINTS, 0, &knots)];
    let bytes = take(100_000 * intervals as u64, 100_000, &moving, &[]);
    let codebook = codebook();
    let take = parse(&bytes, &codebook).unwrap();
    for hundredths in 0..70u8 {
        let early = f64::from(hundredths) * 0.01;
        let late = 0.7 * 51_429.0 + early;
        let (a, b) = (take.sample(early).root.x, take.sample(late).root.x);
        assert!((a - b).abs() < 1e-6, "{early}: {a} {b}");
    }
}

#[test]
fn what_never_moves_has_no_blocks() {
    let hour = take(3_600_000_000, 1, &[], &[(3 * JOINTS + 1, 8)]);
    let codebook = codebook();
    let take = parse(&hour, &codebook).unwrap();
    // 61 channels of 15 bits.
    assert_eq!(take.len_bytes(), UNCUT_HEADER_BYTES + 115);
    assert_eq!(take.sample(1_800.0).root, Vec3::Y);
}

#[test]
fn every_truncation_and_every_longer_take_is_refused() {
    let (mut bytes, codebook) = (turning_walk(), codebook());
    for length in 1..bytes.len() {
        let refused = parse(&bytes[..length], &codebook);
        assert!(
            refused.is_err_and(|e| e.byte <= length),
            "{length}: {refused:?}"
        );
    }
    bytes.push(0);
    let error = parse(&bytes, &codebook).unwrap_err();
    assert_eq!(error.byte, bytes.len() - 1);
}

#[test]
fn fields_that_cannot_be_are_refused() {
    let (bytes, codebook) = (turning_walk(), codebook());
    let refusal = |at: usize, value: u8| {
        let mut bytes = bytes.clone();
        bytes[at] = value;
        let error = parse(&bytes, &codebook).unwrap_err();
        (error.byte, error.expected)
    };
    let mut still = bytes.clone();
    still[10..14].fill(0);
    assert_eq!(parse(&still, &codebook).unwrap_err().byte, 10);
    // A first channel of spacing 3 whose value is 26 bits wide.
    assert_eq!(
        refusal(UNCUT_HEADER_BYTES, 3 | 26 << 2),
        (UNCUT_HEADER_BYTES, "integers of at most 25 bits")
    );
    // 61 channels of 15 bits and 10 for each of two that move: 935 bits of 117 bytes;
    // the end of the one block; its 9 bits of base, then a width of 15.
    let ends_at = UNCUT_HEADER_BYTES + 117;
    assert_eq!(refusal(ends_at - 1, 0xff).0, ends_at - 1);
    assert_eq!(
        refusal(ends_at, 0xff),
        (ends_at, "block ends in rising order within the clip")
    );
    assert_eq!(
        refusal(ends_at + 5, 0x1e),
        (
            ends_at + 5,
            "differences no wider than the channel's widest"
        )
    );
    // Longer by 9 years: more blocks. By 63 microseconds: one more knot.
    assert!(refusal(8, 0x01).1.contains("blocks"));
    assert!(
        refusal(2, bytes[2] | 0x3f)
            .1
            .contains("ends with its last number")
    );
}

#[test]
fn forged_takes_are_refused_or_finite() {
    let mut wild = CODEBOOK;
    wild[STEPS_AT..STEPS_AT + 60].fill(255);
    let plain = turning_walk();
    let mut taken = 0;
    // From byte 1 on: `UncutClip` does not check the kind.
    for bit in 8..plain.len() * 8 {
        let mut bytes = plain.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        for codebook in [codebook(), Codebook::parse(&wild).unwrap()] {
            let Ok(take) = parse(&bytes, &codebook) else {
                continue;
            };
            taken += 1;
            for seconds in [0.0, 0.7, 2.2, 3.0, 1e12] {
                let pose = take.sample(seconds);
                assert!(pose.root.is_finite(), "bit {bit}");
                let finite = pose.rotations.iter().all(|r| r.is_finite());
                assert!(finite, "bit {bit}: {:?}", pose.rotations);
            }
        }
    }
    assert!(taken > 100, "{taken}");
}
