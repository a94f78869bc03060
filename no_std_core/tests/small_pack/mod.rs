//! A pack of two people and three walks, written by hand from the layout that
//! `format.rs` states, not by the host's encoder.

use crate::random::Random;
use edgegait_core::format::crc32;

/// Length and CRC-32 of the header made true again after a change.
pub fn fix_header(bytes: &mut [u8]) {
    if bytes.len() >= 16 {
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[8..12].copy_from_slice(&length);
        let crc = crc32(&bytes[16..]).to_le_bytes();
        bytes[12..16].copy_from_slice(&crc);
    }
}

/// The pack. Names, two subjects, three walks (one a run), two avatars, two clips.
pub fn small_pack() -> Vec<u8> {
    let mut random = Random(7);
    let names = b"AnnBobslowfast".to_vec();
    let mut subjects = Vec::new();
    for (at, sex, avatar) in [(0u32, 1u8, 0u16), (3, 2, 1)] {
        subjects.extend(at.to_le_bytes());
        subjects.extend([3, sex]);
        subjects.extend(1_750u16.to_le_bytes());
        subjects.extend(700u16.to_le_bytes());
        subjects.extend(avatar.to_le_bytes());
    }
    let mut walks = Vec::new();
    for (at, gait, subject, cycle, clip) in [
        (6u32, 0u8, 0u16, 0u16, 0u16),
        (10, 1, 0, 0, 1),
        (6, 0, 1, 3, 0),
    ] {
        walks.extend(at.to_le_bytes());
        walks.extend([4, gait]);
        for field in [subject, cycle, 1_400, clip, 0] {
            walks.extend(field.to_le_bytes());
        }
    }
    let avatars = table(&[avatar(&mut random, 12), avatar(&mut random, 9)]);
    let clips = table(&[clip(&mut random), clip(&mut random)]);

    let sections = [
        (b"NAME", names),
        (b"SUBJ", subjects),
        (b"WALK", walks),
        (b"AVAT", avatars),
        (b"CLIP", clips),
    ];
    let mut bytes = b"EGPK\x01\x00\x05\x00".to_vec();
    bytes.extend([0; 8]);
    let mut at = 16 + 5 * 12;
    for (kind, section) in &sections {
        bytes.extend(*kind);
        bytes.extend((at as u32).to_le_bytes());
        bytes.extend((section.len() as u32).to_le_bytes());
        at += section.len();
    }
    for (_, section) in sections {
        bytes.extend(section);
    }
    fix_header(&mut bytes);
    bytes
}

/// Number of entries, their ends, the entries.
fn table(entries: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = (entries.len() as u32).to_le_bytes().to_vec();
    let mut end = 0;
    for entry in entries {
        end += entry.len();
        bytes.extend((end as u32).to_le_bytes());
    }
    bytes.extend(entries.concat());
    bytes
}

/// 19 joint offsets of up to 30 cm and hulls of 4 to 12 points, 5 to 30 cm large.
fn avatar(random: &mut Random, hulls: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    for _ in 0..3 * 19 {
        bytes.extend((random.between(-3_000.0, 3_000.0) as i16).to_le_bytes());
    }
    for _ in 0..hulls {
        let points = 4 + random.below(9);
        bytes.extend([random.below(19) as u8, points as u8]);
        for _ in 0..3 {
            bytes.extend((random.between(-1_000.0, 0.0) as i16).to_le_bytes());
        }
        for _ in 0..3 {
            bytes.extend((random.between(200.0, 1_200.0) as u16).to_le_bytes());
        }
        for _ in 0..3 * points {
            bytes.push(random.below(256) as u8);
        }
    }
    bytes
}

/// A clip whose 60 channels have 0 to 9 coefficients of up to 8 bits.
fn clip(random: &mut Random) -> Vec<u8> {
    let mut bits = Vec::new();
    for _ in 0..19 {
        bits.push_bits(3, 2); // the largest component is w
        for _ in 0..3 {
            bits.push_bits(random.below(1 << 12) as u32, 15);
        }
        for _ in 0..3 {
            channel(&mut bits, random);
        }
    }
    for _ in 0..3 {
        channel(&mut bits, random);
    }
    let stream: Vec<u8> = bits
        .chunks(8)
        .map(|byte| {
            byte.iter()
                .rev()
                .fold(0, |all, &bit| all << 1 | u8::from(bit))
        })
        .collect();
    let mut bytes = vec![1, 0];
    bytes.extend(1_100_000u32.to_le_bytes());
    bytes.extend(1_500_000i32.to_le_bytes());
    for field in [480, 120, stream.len() as u16] {
        bytes.extend(field.to_le_bytes());
    }
    bytes.extend(stream);
    bytes
}

/// Count, step, then bands of 1, 2, 4 and 8 coefficients behind their width.
fn channel(bits: &mut Vec<bool>, random: &mut Random) {
    let count = random.below(10);
    bits.push_bits(count as u32, 6);
    if count == 0 {
        return;
    }
    bits.push_bits(32, 6); // a step of 2^-8
    let mut left = count;
    for band in [1, 2, 4, 8] {
        let length = left.min(band);
        if length > 0 {
            let width = random.below(9) as u32;
            bits.push_bits(width, 4);
            for _ in 0..length {
                bits.push_bits(random.below(1 << width) as u32, width);
            }
        }
        left -= length;
    }
}

/// Packed integers, least significant bit first.
trait PushBits {
    fn push_bits(&mut self, value: u32, width: u32);
}

impl PushBits for Vec<bool> {
    fn push_bits(&mut self, value: u32, width: u32) {
        self.extend((0..width).map(|bit| value >> bit & 1 == 1));
    }
}
