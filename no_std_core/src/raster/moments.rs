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
