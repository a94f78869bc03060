//! Area and first moment of a figure.

/// Area and first moment of a figure over columns.
#[derive(Clone, Copy, Default)]
pub struct AreaMoments {
    /// The sum of all pixels, in a unit that the window chooses.
    pub area: u64,
    /// The sum of pixels times (2 * column + 1): twice the pixel centres, in integers.
    pub doubled: u64,
}

impl AreaMoments {
    /// Returns the moments of rows from how many are on in each column; a pixel counts `on`.
    #[inline(always)]
    pub fn from_counts(digits: impl Iterator<Item = u64>, on: u64) -> Self {
        /// Columns whose number has bit 0, 1, 2, 3, 4 or 5.
        const COLUMNS: [u64; 6] = [
            0xaaaa_aaaa_aaaa_aaaa,
            0xcccc_cccc_cccc_cccc,
            0xf0f0_f0f0_f0f0_f0f0,
            0xff00_ff00_ff00_ff00,
            0xffff_0000_ffff_0000,
            0xffff_ffff_0000_0000,
        ];
        let (mut area, mut columns) = (0, 0);
        for (worth, digit) in digits.enumerate() {
            area += u64::from(digit.count_ones()) << worth;
            for (bit, those) in COLUMNS.into_iter().enumerate() {
                columns += u64::from((digit & those).count_ones()) << (worth + bit);
            }
        }
        Self {
            area: on * area,
            doubled: on * (2 * columns + area),
        }
    }

    /// Adds the moments of a window whose first column is column `left` of the row of windows.
    pub fn add(&mut self, window: Self, left: usize) {
        self.area += window.area;
        self.doubled += window.doubled + 2 * left as u64 * window.area;
    }

    /// Returns the x of the centroid of sampled points, `jitter` right of the pixel centres,
    /// rounded half up.
    pub fn centroid_column(&self, jitter: f32) -> isize {
        // Both are whole numbers below 2^40, so that ties are exact and nothing else becomes a tie.
        #[expect(clippy::cast_precision_loss, reason = "exact below 2^53")]
        let (area, doubled) = (self.area as f64, self.doubled as f64);
        let rounded =
            libm::floor((doubled + area * (1.0 + 2.0 * f64::from(jitter))) / (2.0 * area));
        #[expect(clippy::cast_possible_truncation, reason = "a few thousand columns")]
        let column = rounded as isize;
        column
    }
}
