//! Changes of any bytes.

use super::{MAX_BYTES, Mutator};
use crate::chance::Chance;

pub const ALL: [Mutator; 11] = [
    flip, flip, number, number, number, float, delete, repeat, move_part, insert, cut,
];

/// Numbers at which lengths, counts and offsets go wrong.
pub const EDGES: [u64; 30] = [
    0,
    1,
    2,
    3,
    4,
    7,
    8,
    16,
    63,
    64,
    127,
    128,
    255,
    256,
    1000,
    32_767,
    32_768,
    65_535,
    65_536,
    0x00ff_ffff,
    0x7fff_fffe,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
    1 << 32,
    1 << 40,
    i64::MAX as u64,
    1 << 63,
    u64::MAX,
];

pub fn flip(bytes: &mut Vec<u8>, chance: &mut Chance) {
    for _ in 0..chance.one_of(&[1, 1, 2, 4, 16]) {
        let at = chance.below(bytes.len());
        let bit = chance.below(8);
        if let Some(byte) = bytes.get_mut(at) {
            *byte ^= 1 << bit;
        }
    }
}

/// Sets a number of 1 to 8 bytes to an edge, or moves it by a little.
pub fn number(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let width = chance.one_of(&[1, 2, 2, 4, 4, 8]).min(bytes.len());
    let at = chance.early(bytes.len() - width + 1);
    set_number(&mut bytes[at..at + width], chance);
}

pub fn set_number(field: &mut [u8], chance: &mut Chance) {
    let width = field.len().min(8);
    let mut old = [0; 8];
    old[..width].copy_from_slice(&field[..width]);
    let value = if chance.is(70) {
        chance.one_of(&EDGES)
    } else {
        let step = chance.one_of(&[1_i64, -1, 2, -2, 16]);
        u64::from_le_bytes(old).wrapping_add_signed(step)
    };
    let mut new = value.to_le_bytes();
    if chance.is(25) {
        new[..width].reverse();
    }
    field[..width].copy_from_slice(&new[..width]);
}

pub fn float(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let value = chance.one_of(&[
        0.0,
        -0.0,
        1.0,
        -1.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e30,
        -1e30,
        1e-40,
        1e300,
    ]);
    let short = (value as f32).to_le_bytes();
    let long = value.to_le_bytes();
    let new: &[u8] = if chance.is(60) { &short } else { &long };
    if bytes.len() >= new.len() {
        // Numbers are mostly aligned.
        let mut at = chance.below(bytes.len() - new.len() + 1);
        if chance.is(80) {
            at -= at % 4;
        }
        bytes[at..at + new.len()].copy_from_slice(new);
    }
}

pub fn delete(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let span = chance.span(bytes.len());
    bytes.drain(span);
}

pub fn repeat(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let span = chance.span(bytes.len());
    let times = chance.one_of(&[1, 1, 2, 10, 100]);
    let room = MAX_BYTES.saturating_sub(bytes.len()) / span.len().max(1);
    let copies = bytes[span.clone()].repeat(times.min(room));
    bytes.splice(span.end..span.end, copies);
}

pub fn move_part(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let span = chance.span(bytes.len());
    let part: Vec<u8> = bytes.drain(span).collect();
    let at = chance.below(bytes.len() + 1);
    bytes.splice(at..at, part);
}

pub fn insert(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let many = chance.one_of(&[1, 2, 4, 8, 64, 512, 65_536]);
    let new = match chance.below(3) {
        0 => vec![0; many],
        1 => vec![0xff; many.min(512)],
        _ => (0..many.min(64)).map(|_| chance.byte()).collect(),
    };
    let at = chance.below(bytes.len() + 1);
    bytes.splice(at..at, new);
}

pub fn cut(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let length = bytes.len();
    let anywhere = chance.below(length + 1);
    let keep = [
        0,
        1,
        2,
        4,
        8,
        length / 2,
        length.saturating_sub(1),
        anywhere,
    ];
    bytes.truncate(chance.one_of(&keep));
}
