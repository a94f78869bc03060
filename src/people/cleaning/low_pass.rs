//! A zero-lag low-pass for joint tracks. Above 10 Hz, gait recordings hold only marker noise.
//!
//! It is a second-order Butterworth filter run forwards and backwards, as in Winter (2009),
//! "Biomechanics and Motor Control of Human Movement", section 3.4.4. The two passes together have
//! their -3 dB point at the stated cut-off.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};

/// Two passes lower the (pre-warped) cut-off by this factor: (2^(1/2) - 1)^(1/4) (Winter 2009).
const TWO_PASSES: f64 = 0.802;

/// A low-pass for one sample rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LowPass {
    /// The outer feed-forward coefficients; the middle one is twice this.
    b0: f64,
    a1: f64,
    a2: f64,
    /// Samples added at either end.
    pad: usize,
}

impl LowPass {
    /// Returns a filter with its -3 dB point at `cut_off_hz`; `None` if the sample rate is too low
    /// for it.
    #[must_use]
    pub(crate) fn new(cut_off_hz: f64, sample_rate_hz: f64) -> Option<Self> {
        if !(cut_off_hz > 0.0 && cut_off_hz < 0.4 * sample_rate_hz) {
            return None;
        }
        // Bilinear transform of 1 / (s^2 + sqrt(2) s + 1), pre-warped.
        let k = libm::tan(PI * cut_off_hz / sample_rate_hz) / TWO_PASSES;
        let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * k + k * k);
        Some(Self {
            b0: k * k * norm,
            a1: 2.0 * (k * k - 1.0) * norm,
            a2: (1.0 - std::f64::consts::SQRT_2 * k + k * k) * norm,
            // Three time constants, until the start-up has died away.
            pad: (3.0 * sample_rate_hz / (2.0 * PI * cut_off_hz)).ceil() as usize + 3,
        })
    }

    /// Filters one channel in place. The ends are extended by reflection about the end points, so
    /// a straight line passes unchanged.
    pub(crate) fn scalars(&self, values: &mut [f64]) {
        let n = values.len();
        if n < 2 {
            return;
        }
        let pad = self.pad.min(n - 1);
        let (first, last) = (values[0], values[n - 1]);
        let mut padded = Vec::with_capacity(n + 2 * pad);
        padded.extend((1..=pad).rev().map(|i| 2.0 * first - values[i]));
        padded.extend_from_slice(values);
        padded.extend((1..=pad).map(|i| 2.0 * last - values[n - 1 - i]));
        self.pass(&mut padded);
        padded.reverse();
        self.pass(&mut padded);
        padded.reverse();
        values.copy_from_slice(&padded[pad..pad + n]);
    }

    /// Filters positions in place.
    pub(crate) fn positions(&self, values: &mut [DVec3]) {
        for axis in 0..3 {
            let mut channel: Vec<f64> = values.iter().map(|v| v[axis]).collect();
            self.scalars(&mut channel);
            for (value, filtered) in values.iter_mut().zip(channel) {
                value[axis] = filtered;
            }
        }
    }

    /// Filters rotations in place: their components in one hemisphere, renormalised. This is valid
    /// for steps well below 90 degrees, which [`crate::people::retarget`] ensures.
    pub(crate) fn rotations(&self, values: &mut [DQuat]) {
        for i in 1..values.len() {
            if values[i].dot(values[i - 1]) < 0.0 {
                values[i] = -values[i];
            }
        }
        let mut channels: [Vec<f64>; 4] =
            std::array::from_fn(|c| values.iter().map(|q| q.to_array()[c]).collect());
        for channel in &mut channels {
            self.scalars(channel);
        }
        for (i, value) in values.iter_mut().enumerate() {
            let filtered = DQuat::from_array(std::array::from_fn(|c| channels[c][i]));
            if filtered.length_squared() > 1e-12 {
                *value = filtered.normalize();
            }
        }
    }

    /// Filters once, started as if the first value had been there for ever.
    fn pass(&self, values: &mut [f64]) {
        let Some(&start) = values.first() else { return };
        let (mut x1, mut x2, mut y1, mut y2) = (start, start, start, start);
        for value in values {
            let x = *value;
            let y = self.b0 * (x + 2.0 * x1 + x2) - self.a1 * y1 - self.a2 * y2;
            (x2, x1, y2, y1) = (x1, x, y1, y);
            *value = y;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gain(frequency_hz: f64) -> f64 {
        let filter = LowPass::new(10.0, 120.0).unwrap();
        let tone = |i: usize| libm::sin(2.0 * PI * frequency_hz * i as f64 / 120.0);
        let mut values: Vec<f64> = (0..960).map(tone).collect();
        filter.scalars(&mut values);
        let (mut dot, mut energy) = (0.0, 0.0);
        for (i, value) in values.iter().enumerate().take(840).skip(120) {
            dot += value * tone(i);
            energy += tone(i) * tone(i);
        }
        dot / energy
    }

    #[test]
    fn the_gain_is_one_at_2_hz_and_half_the_power_at_10_hz() {
        assert!((gain(2.0) - 1.0).abs() < 0.003, "{}", gain(2.0));
        assert!((gain(10.0) - 0.5f64.sqrt()).abs() < 0.01, "{}", gain(10.0));
        assert!(gain(30.0) < 0.03, "{}", gain(30.0));
    }

    #[test]
    fn a_straight_line_passes_unchanged_to_its_ends() {
        let filter = LowPass::new(10.0, 60.0).unwrap();
        let mut line: Vec<f64> = (0..50).map(|i| 3.0 + 0.25 * f64::from(i)).collect();
        let before = line.clone();
        filter.scalars(&mut line);
        for (a, b) in before.iter().zip(&line) {
            assert!((a - b).abs() < 0.02, "{a} {b}");
        }
    }

    #[test]
    fn rotations_of_either_sign_give_the_same_and_stay_unit() {
        let filter = LowPass::new(10.0, 120.0).unwrap();
        let mut plain: Vec<DQuat> = (0..90)
            .map(|i| DQuat::from_rotation_y(libm::sin(f64::from(i) * 0.1)))
            .collect();
        let mut flipped: Vec<DQuat> = plain
            .iter()
            .enumerate()
            .map(|(i, q)| if i % 2 == 1 { -*q } else { *q })
            .collect();
        filter.rotations(&mut plain);
        filter.rotations(&mut flipped);
        for (a, b) in plain.iter().zip(&flipped) {
            assert!((a.dot(*b).abs() - 1.0).abs() < 1e-12 && (a.length() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_rate_too_low_for_the_cut_off_has_no_filter() {
        assert!(LowPass::new(10.0, 25.0).is_none());
        assert!(LowPass::new(10.0, 30.0).is_some());
    }
}
