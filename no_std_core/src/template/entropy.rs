//! The Gait Entropy Image, from the same sums as the Gait Energy Image.

use super::frame_sums::FrameSums;
use crate::budget::MAX_PIXELS;

/// For each pixel Shannon's entropy of whether it is on, bits (Bashir, Xiang & Gong 2009), spread
/// from the image's least (0) to its largest (255) and rounded half up. Black if all are the same.
pub(super) fn entropies(sums: &mut FrameSums) -> [u8; MAX_PIXELS] {
    let table = EntropyTable::new(sums.whole());
    let (mut least, mut largest) = (f64::INFINITY, f64::NEG_INFINITY);
    sums.map((), |sum| {
        let bits = table.entropy(sum);
        least = least.min(bits);
        largest = largest.max(bits);
    });
    let range = largest - least;
    sums.map(0, |sum| {
        if range > 0.0 {
            let byte = (table.entropy(sum) - least) * 255.0 / range;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "0 to 255.5"
            )]
            {
                (byte + 0.5) as u8
            }
        } else {
            0
        }
    })
}

/// Entropies of sums, the more usual ones by table.
struct EntropyTable {
    whole: u32,
    known: [f64; Self::KNOWN],
}

impl EntropyTable {
    /// Sums of 28 frames of ninths, or 255 of bits.
    const KNOWN: usize = 256;

    fn new(whole: u32) -> Self {
        let mut known = [0.0; Self::KNOWN];
        for (sum, known) in (0..=whole).zip(&mut known) {
            *known = entropy(sum, whole);
        }
        Self { whole, known }
    }

    fn entropy(&self, sum: u32) -> f64 {
        let known = self.known.get(sum as usize).copied();
        known.unwrap_or_else(|| entropy(sum, self.whole))
    }
}

/// The entropy of a pixel that is on in `sum` of `whole`, bits: 0..=1.
fn entropy(sum: u32, whole: u32) -> f64 {
    let term = |part: u32| {
        let share = f64::from(part) / f64::from(whole);
        if part == 0 {
            0.0
        } else {
            -share * libm::log2(share)
        }
    };
    term(sum) + term(whole - sum)
}
