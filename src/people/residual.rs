//! Residuals of constant segment lengths: distances from the measured joints.

use glam::DVec3;

/// Distances between reached and measured joints.
#[derive(Default)]
pub(super) struct Residual {
    squares: f64,
    count: usize,
    largest_m: f64,
}

impl Residual {
    /// Adds one distance.
    pub(super) fn add(&mut self, distance_m: f64) {
        self.squares += distance_m * distance_m;
        self.count += 1;
        self.largest_m = self.largest_m.max(distance_m);
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

    /// Returns the largest distance, mm.
    pub(super) fn largest_mm(&self) -> f64 {
        1e3 * self.largest_m
    }
}
