//! Residuals of constant segment lengths: distances from the measured joints.

use glam::DVec3;

/// Distances between reached and measured joints.
#[derive(Default)]
pub(super) struct Residual {
    squares: f64,
    count: usize,
}

impl Residual {
    /// Adds one distance.
    pub(super) fn add(&mut self, distance_m: f64) {
        self.squares += distance_m * distance_m;
        self.count += 1;
    }

    /// Adds the distances between points and others.
    pub(super) fn add_all(&mut self, reached: &[DVec3], measured: &[DVec3]) {
        for (at, to) in reached.iter().zip(measured) {
            self.add(at.distance(*to));
        }
    }

    /// Returns the root mean square, mm.
    pub(super) fn rms_mm(&self) -> f64 {
        1e3 * libm::sqrt(self.squares / self.count.max(1) as f64)
    }
}
