//! The Gait Entropy Image, from the same sums as the Gait Energy Image.

/// The entropies of sums, with a table for the usual sums.
pub(super) struct EntropyTable {
    whole: u32,
    known: [f64; Self::KNOWN],
}

impl EntropyTable {
    /// Sums of 28 frames of ninths, or 255 of bits.
    const KNOWN: usize = 256;

    pub fn new(whole: u32) -> Self {
        let mut known = [0.0; Self::KNOWN];
        for (sum, known) in (0..=whole).zip(&mut known) {
            *known = entropy(sum, whole);
        }
        Self { whole, known }
    }

    pub fn entropy(&self, sum: u32) -> f64 {
        let known = self.known.get(sum as usize).copied();
        known.unwrap_or_else(|| entropy(sum, self.whole))
    }
}

/// Returns the entropy of a pixel that is on in `sum` of `whole` samples, bits: 0..=1.
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
