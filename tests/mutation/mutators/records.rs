//! Changes of the records of a C3D: its header, its parameters and its frames.

use super::bytes::{float, set_number};
use crate::chance::Chance;

const BLOCK: usize = 512;

/// Changes a number of the header that readers use: places, counts, rates and scales.
pub fn c3d_header(bytes: &mut Vec<u8>, chance: &mut Chance) {
    // Words 1 to 12 of the header, and those of its events.
    let at = 2 * chance.one_of(&[0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 149, 150]);
    let width = chance.one_of(&[1, 2, 2, 4]);
    if let Some(field) = bytes.get_mut(at..at + width) {
        set_number(field, chance);
    }
}

/// Changes the length of a name, the place of the next record, a type, a dimension or a value.
pub fn c3d_parameter(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let records = records(bytes);
    if records.is_empty() {
        return;
    }
    let record = records[chance.below(records.len())];
    let name = usize::from(bytes[record].cast_signed().unsigned_abs());
    let after = record + 2 + name;
    match chance.below(9) {
        0 => bytes[record] = chance.byte(),
        1 => bytes[record + 1] = chance.byte(),
        2 => change(bytes, after..after + 2, chance),
        3 => change(bytes, after + 2..after + 3, chance),
        4 | 5 => {
            let at = after + 3 + chance.below(4);
            change(bytes, at..at + 1, chance);
        }
        _ => {
            let at = after + 4 + chance.below(40);
            let width = chance.one_of(&[1, 2, 4]);
            change(bytes, at..at + width, chance);
        }
    }
}

/// Changes coordinates and residuals.
pub fn c3d_frames(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let first = bytes
        .get(16..18)
        .map_or(0, |two| usize::from(u16::from_le_bytes([two[0], two[1]])));
    let start = (first.saturating_sub(1) * BLOCK).min(bytes.len());
    let mut frames = bytes.split_off(start);
    for _ in 0..chance.one_of(&[1, 4, 50, 1000]) {
        float(&mut frames, chance);
    }
    bytes.extend(frames);
}

fn change(bytes: &mut [u8], at: std::ops::Range<usize>, chance: &mut Chance) {
    if let Some(field) = bytes.get_mut(at) {
        set_number(field, chance);
    }
}

/// Where the records of groups and parameters begin.
fn records(bytes: &[u8]) -> Vec<usize> {
    let block = bytes.first().map_or(0, |first| usize::from(*first));
    let (mut at, mut found) = (block.saturating_sub(1) * BLOCK + 4, Vec::new());
    while let Some(&[name, _]) = bytes.get(at..at + 2) {
        let after = at + 2 + usize::from(name.cast_signed().unsigned_abs());
        let Some(&[low, high]) = bytes.get(after..after + 2) else {
            break;
        };
        let step = usize::from(u16::from_le_bytes([low, high]));
        if name == 0 || found.len() > 1000 {
            break;
        }
        found.push(at);
        if step == 0 {
            break;
        }
        at = after + step;
    }
    found
}
