//! Frequency-domain features: the mean of each pixel, and how much it varies once and twice a
//! cycle.

use super::frame_sums::FrameSums;
use super::memory::Memory;
use super::{FrameError, TemplateKind};
use crate::budget::{FREQUENCIES, MAX_PIXELS};
use crate::raster::Simd;
use crate::silhouette::{AnySilhouette, Size};
use core::f64::consts::TAU;

/// Sums of waves for each pixel. 82 kB.
#[derive(Clone, Debug)]
pub struct Frequencies {
    /// The sums for frequency 0.
    sums: FrameSums,
    /// Frames of the cycle.
    period: u32,
    /// For each frequency from 1 on, the sums of the coverage (0..=255) times cosine and sine.
    waves: [[[f32; MAX_PIXELS]; 2]; FREQUENCIES - 1],
}

impl Frequencies {
    pub const fn new(size: Size, simd: Simd, period: u32) -> Self {
        Self {
            sums: FrameSums::new(size, simd),
            period,
            waves: [[[0.0; MAX_PIXELS]; 2]; FREQUENCIES - 1],
        }
    }
}

impl Memory for Frequencies {
    fn frames(&self) -> u32 {
        self.sums.frames()
    }

    fn clear(&mut self) {
        self.sums.clear();
        let waves = self.waves.as_flattened_mut();
        waves.as_flattened_mut().fill(0.0);
    }

    fn add(&mut self, frame: &AnySilhouette) -> Result<(), FrameError> {
        let (frame_number, period) = (self.frames(), self.period);
        self.sums.add(frame)?;
        let coverage = frame.to_coverage();
        for (waves, frequency) in self.waves.iter_mut().zip(1..) {
            let turns = f64::from(frequency * frame_number % period) / f64::from(period);
            let (sin, cos) = libm::sincos(TAU * turns);
            for (sums, wave) in waves.iter_mut().zip([cos, sin]) {
                #[expect(clippy::cast_possible_truncation, reason = "rounds")]
                let wave = wave as f32;
                for (sum, &pixel) in sums.iter_mut().zip(coverage.pixels()) {
                    *sum += f32::from(pixel) * wave;
                }
            }
        }
        Ok(())
    }

    /// Writes the amplitudes of one frequency after the other (Makihara et al. 2006), rounded half
    /// up: A_k(x, y) = |sum over n of g(x, y, n) e^(-2 pi i k n / N)| / N.
    fn write(&mut self, _: TemplateKind, _: u32, bytes: &mut [u8]) {
        let pixels = self.sums.size().pixels();
        let mut planes = bytes.chunks_mut(pixels);
        if let Some(plane) = planes.next() {
            for (byte, mean) in plane.iter_mut().zip(self.sums.means()) {
                *byte = mean;
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "at most 7,281")]
        let frames = self.period as f32;
        for (plane, [cosines, sines]) in planes.zip(&self.waves) {
            for ((byte, cosine), sine) in plane.iter_mut().zip(cosines).zip(sines) {
                let amplitude = libm::sqrtf(cosine * cosine + sine * sine) / frames;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "0 to 255.5"
                )]
                {
                    *byte = (amplitude + 0.5) as u8;
                }
            }
        }
    }
}
