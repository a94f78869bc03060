//! What is done to the bytes of a seed. A mutator that finds nothing of its format changes nothing.

pub mod bytes;
pub mod checksums;
pub mod onnx;
pub mod records;
pub mod structure;
pub mod text;

use crate::chance::Chance;

pub type Mutator = fn(&mut Vec<u8>, &mut Chance);

/// No mutated file is longer.
pub const MAX_BYTES: usize = 4 << 20;

/// Returns a mutated seed: one to four mutations, most of them of the format's `own`, sometimes after
/// a splice with another seed.
pub fn mutated(
    seeds: &[Vec<u8>],
    own: &[Mutator],
    any: &[Mutator],
    chance: &mut Chance,
) -> Vec<u8> {
    let mut bytes = seeds[chance.below(seeds.len())].clone();
    if chance.is(5) {
        let other = &seeds[chance.below(seeds.len())];
        let (keep, from) = (chance.below(bytes.len()), chance.below(other.len()));
        bytes.truncate(keep);
        bytes.extend(&other[from..]);
    }
    // A few are read as they are: seeds that are no longer accepted show in the table.
    if chance.is(2) {
        return bytes;
    }
    for _ in 0..chance.one_of(&[1, 1, 1, 1, 2, 2, 4]) {
        let mutators = if any.is_empty() || chance.is(65) {
            own
        } else {
            any
        };
        chance.one_of(mutators)(&mut bytes, chance);
        bytes.truncate(MAX_BYTES);
    }
    bytes
}
