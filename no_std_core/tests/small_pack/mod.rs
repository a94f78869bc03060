//! A pack of two people and three walks, written by hand from the layout that
//! `format.rs` states, not by the host's encoder.

use crate::random::Random;
use edgegait_core::format::crc32;

/// Corrects the length and CRC-32 of the header after a change.
pub fn fix_header(bytes: &mut [u8]) {
    if bytes.len() >= 16 {
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[8..12].copy_from_slice(&length);
        let crc = crc32(&bytes[16..]).to_le_bytes();
        bytes[12..16].copy_from_slice(&crc);
    }
}

/// Returns the pack: names, two subjects, three walks (one a run), two avatars, two clips.
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
        // Bob walks with Ann's body.
        let worn = u16::from(subject == 1);
        for field in [subject, cycle, 1_400, clip, worn] {
            walks.extend(field.to_le_bytes());
        }
    }
    let avatars = table(&[avatar(&mut random, 12), avatar(&mut random, 9)]);
    let channels: Vec<Channel> = (0..60).map(|_| Channel::random(&mut random)).collect();
    let codebook = codebook(&mut random, &channels);
    let templates = table(&[template(&mut random, &channels)]);
    let clips = table(&[
        cycle(&mut random, &channels, 0),
        cycle(&mut random, &channels, 1),
    ]);

    let sections = [
        (b"NAME", names),
        (b"SUBJ", subjects),
        (b"WALK", walks),
        (b"AVAT", avatars),
        (b"CODE", codebook),
        (b"TMPL", templates),
        (b"CLIP", clips),
    ];
    let mut bytes = b"EGPK\x01\x00\x07\x00".to_vec();
    bytes.extend([0; 8]);
    let mut at = 16 + 7 * 12;
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

/// Returns a table: the number of entries, their ends, the entries.
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

/// Returns an avatar with joint offsets of up to 30 cm, half of the time symmetric, and this many
/// stored hulls of 1 to 30 points, 5 to 30 cm large. With four or more, the last three are parts of
/// one or two draped hulls.
pub fn avatar(random: &mut Random, hulls: usize) -> Vec<u8> {
    let is_symmetric = random.below(2) == 1;
    let mut bits = Vec::new();
    bits.push_bits(13, 5);
    let coordinates = if is_symmetric { 4 * 2 + 7 * 3 } else { 18 * 3 };
    for _ in 0..coordinates {
        let is_stored = random.below(4) > 0;
        bits.push_bits(u32::from(is_stored), 1);
        if is_stored {
            bits.push_bits(random.between(-3_000.0, 3_000.0) as i32 as u32, 13);
        }
    }
    let parts = if hulls < 4 { 0 } else { 3 };
    for _ in parts..hulls {
        hull(&mut bits, random, 3);
    }
    let first = 1 + random.below(3);
    for part in 0..parts {
        if part == 0 || part == first {
            let of_this = if part == 0 { first } else { parts - first };
            bits.push_bits(31, 5);
            bits.push_bits(of_this as u32 - 1, 3);
        }
        hull(&mut bits, random, 1);
    }
    let mut bytes = vec![150, 0];
    bytes.extend((random.between(2_000.0, 5_000.0) as u16).to_le_bytes());
    bytes.push(hulls as u8 | if is_symmetric { 0x40 } else { 0 });
    bytes.extend(packed(&bits));
    bytes
}

/// Writes joint, flags, axis, rows and widths, then up to `most_rows` rows of up to five points,
/// or, if `most_rows` is 1, of up to two points, which stand for at most eight.
fn hull(bits: &mut Vec<bool>, random: &mut Random, most_rows: usize) {
    let joint = random.below(19);
    let is_symmetric = random.below(2) == 1;
    let is_left = (5..9).contains(&joint) || (13..16).contains(&joint);
    let shared = random.below(4);
    let rows = 1 + random.below(most_rows);
    bits.push_bits(joint as u32, 5);
    bits.push_bits(u32::from(is_symmetric), 1);
    bits.push_bits(u32::from(is_left && random.below(2) == 1), 1);
    bits.push_bits(shared as u32, 2);
    bits.push_bits(rows as u32 - 1, 5);
    let widths = [0; 3].map(|_| 4 + random.below(3) as u32);
    for width in widths {
        bits.push_bits(width, 4);
    }
    for _ in 0..rows {
        let points = 1 + random.below(if most_rows == 1 { 2 } else { 5 });
        bits.push_bits(points as u32 - 1, 3);
        let middle = if is_symmetric {
            random.below(4).min(points)
        } else {
            0
        };
        if is_symmetric {
            bits.push_bits(middle as u32, 2);
        }
        let mut push = |axis: usize| {
            let width = widths[axis - 1];
            bits.push_bits(random.below(1 << width) as u32, width);
        };
        if shared > 0 {
            push(shared);
        }
        for point in 0..points {
            let first = if point < middle { 2 } else { 1 };
            (first..=3)
                .filter(|&axis| axis != shared)
                .for_each(&mut push);
        }
    }
}

/// The parameters by which one channel's numbers are written.
pub struct Channel {
    usual_groups: i32,
    groups_rice: u32,
    rice: Vec<u32>,
}

impl Channel {
    /// Returns a channel of up to five groups.
    fn random(random: &mut Random) -> Self {
        let groups = random.below(6);
        Self {
            usual_groups: random.below(4) as i32,
            groups_rice: random.below(4) as u32,
            rice: (0..groups).map(|_| random.below(6) as u32).collect(),
        }
    }

    /// Writes this many groups of numbers below `most`.
    fn push_numbers(
        &self,
        bits: &mut Vec<bool>,
        random: &mut Random,
        groups: usize,
        (larger, most): (u32, i32),
    ) {
        for (group, &rice) in self.rice.iter().enumerate().take(groups) {
            for _ in 0..if group == 0 { 1 } else { 2 } {
                let number = random.below(2 * most as usize - 1) as i32 - (most - 1);
                bits.push_rice(number, rice + larger);
            }
        }
    }
}

/// Returns a codebook, a table of templates and a clip at the limits of the format: the coarsest
/// steps, 32 groups in each channel and numbers of 24 bits.
pub fn wild_clip(random: &mut Random) -> [Vec<u8>; 3] {
    const MOST: i32 = 1 << 23;
    let channels: Vec<Channel> = (0..60)
        .map(|_| Channel {
            usual_groups: random.below(64) as i32,
            groups_rice: 3,
            rice: (0..32).map(|_| random.below(16) as u32).collect(),
        })
        .collect();
    let mut code = codebook(random, &channels);
    code[19 * 12..19 * 12 + 60].fill(255);
    let (mut mean, mut own) = (Vec::new(), Vec::new());
    for channel in &channels {
        mean.push_bits(32, 6);
        mean.push_bits(0, 4);
        channel.push_numbers(&mut mean, random, 32, (0, MOST));
        let groups = random.below(33);
        own.push_rice(groups as i32 - channel.usual_groups, 3);
        channel.push_numbers(&mut own, random, groups, (0, MOST));
    }
    let mut clip = vec![1, 1, 255];
    clip.extend([0xff; 16]);
    clip.extend(packed(&own));
    let templates = table(&[[vec![255], packed(&mean)].concat()]);
    [code, templates, clip]
}

/// Returns a codebook of random references and bases, steps of up to 5 octaves, no errors, and
/// these channels.
fn codebook(random: &mut Random, channels: &[Channel]) -> Vec<u8> {
    let mut bytes: Vec<u8> = (0..19 * 12).map(|_| random.bits() as u8).collect();
    bytes.extend((0..60).map(|_| random.below(40) as u8));
    bytes.extend([0; 19 * 4]);
    let mut bits = Vec::new();
    for channel in channels {
        bits.push_bits(channel.rice.len() as u32, 6);
        if channel.rice.is_empty() {
            continue;
        }
        bits.push_bits(channel.usual_groups as u32, 6);
        bits.push_bits(channel.groups_rice, 2);
        for (group, &rice) in channel.rice.iter().enumerate() {
            match group {
                0 | 1 => bits.push_bits(rice, 4),
                _ => bits.push_rice(channel.rice[group - 1] as i32 - rice as i32, 0),
            }
        }
    }
    bytes.extend(packed(&bits));
    bytes
}

/// Returns a template with a scale of 2^-8 and random groups.
fn template(random: &mut Random, channels: &[Channel]) -> Vec<u8> {
    let mut bits = Vec::new();
    for channel in channels.iter().filter(|channel| !channel.rice.is_empty()) {
        let groups = random.below(channel.rice.len() + 1);
        let larger = random.below(4) as u32;
        bits.push_bits(groups as u32, 6);
        bits.push_bits(larger, 4);
        channel.push_numbers(&mut bits, random, groups, (larger, 21));
    }
    [vec![96], packed(&bits)].concat()
}

/// Returns a loop of 1.1 s and 1.5 m with random groups.
fn cycle(random: &mut Random, channels: &[Channel], template: u8) -> Vec<u8> {
    let mut bits = Vec::new();
    for channel in channels.iter().filter(|channel| !channel.rice.is_empty()) {
        let groups = random.below(channel.rice.len() + 1);
        bits.push_rice(groups as i32 - channel.usual_groups, channel.groups_rice);
        channel.push_numbers(&mut bits, random, groups, (0, 21));
    }
    let mut bytes = vec![1, template, 92];
    bytes.extend(1_100_000u32.to_le_bytes());
    bytes.extend(1_500_000i32.to_le_bytes());
    for field in [480u16, 120, 250, 96] {
        bytes.extend(field.to_le_bytes());
    }
    bytes.extend(packed(&bits));
    bytes
}

/// Packs bits into bytes, padded with zeros.
fn packed(bits: &[bool]) -> Vec<u8> {
    let byte = |bits: &[bool]| {
        let ones = bits.iter().enumerate().filter(|(_, bit)| **bit);
        ones.fold(0, |byte, (at, _)| byte | 1 << at)
    };
    bits.chunks(8).map(byte).collect()
}

/// A writer of packed integers, least significant bit first.
trait PushBits {
    fn push_bits(&mut self, value: u32, width: u32);
    fn push_rice(&mut self, value: i32, parameter: u32);
}

impl PushBits for Vec<bool> {
    fn push_bits(&mut self, value: u32, width: u32) {
        self.extend((0..width).map(|bit| value >> bit & 1 == 1));
    }

    fn push_rice(&mut self, value: i32, parameter: u32) {
        let zigzag = if value > 0 { 2 * value - 1 } else { -2 * value } as u32;
        if zigzag >> parameter > 15 {
            self.extend([true; 16]);
            return self.push_bits(value as u32, 24);
        }
        self.extend(vec![true; (zigzag >> parameter) as usize]);
        self.push(false);
        self.push_bits(zigzag, parameter);
    }
}
