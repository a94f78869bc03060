//! The Gait Energy Image: the mean silhouette of a gait cycle.

use crate::budget::PIXELS;
use crate::silhouette::Frame;

/// A Gait Energy Image (Han & Bhanu 2006, equation 1): the share of frames in
/// which each pixel is on, 0..=255.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gei {
    /// Row by row from the top.
    pub pixels: [u8; PIXELS],
}

/// Sums frames into a [`Gei`]. 6 kB.
#[derive(Clone, Debug)]
pub struct GeiBuilder {
    sums: [u32; PIXELS],
    frames: u32,
}

impl Default for GeiBuilder {
    fn default() -> Self {
        Self::new()
    }
}

impl GeiBuilder {
    /// Most frames of one GEI: what the sums hold, and the frames of a day at 194 Hz.
    pub const MAX_FRAMES: u32 = u32::MAX / 256;

    /// No frame yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            sums: [0; PIXELS],
            frames: 0,
        }
    }

    /// Adds a frame; frames beyond [`Self::MAX_FRAMES`] are not taken.
    pub fn add(&mut self, frame: &Frame) {
        if self.frames == Self::MAX_FRAMES {
            return;
        }
        self.frames += 1;
        for (sum, pixel) in self.sums.iter_mut().zip(frame.to_pixels()) {
            *sum += u32::from(pixel);
        }
    }

    /// How many frames were added.
    #[must_use]
    pub const fn frames(&self) -> u32 {
        self.frames
    }

    /// The mean of the frames so far, rounded half up; black without any.
    #[must_use]
    pub fn finish(&self) -> Gei {
        let frames = self.frames.max(1);
        let mut pixels = [0; PIXELS];
        for (pixel, sum) in pixels.iter_mut().zip(self.sums) {
            #[expect(clippy::cast_possible_truncation, reason = "a mean of bytes")]
            let mean = ((sum + frames / 2) / frames) as u8;
            *pixel = mean;
        }
        Gei { pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::ROWS;
    use crate::silhouette::Silhouette;

    fn frame(first: u32, second: u32) -> Frame {
        let mut rows = [0; ROWS];
        rows[0] = first;
        rows[1] = second;
        Frame::Binary(Silhouette::from_rows(rows))
    }

    #[test]
    fn a_gei_is_the_mean_of_its_frames() {
        // The four frames [[1,0],[0,1]], [[1,1],[0,0]], [[1,0],[0,1]], [[1,1],[0,1]]
        // have the mean [[1, 0.5], [0, 0.75]]; bit 0 is the left column.
        let mut builder = GeiBuilder::new();
        for (first, second) in [(0b01, 0b10), (0b11, 0b00), (0b01, 0b10), (0b11, 0b10)] {
            builder.add(&frame(first, second));
        }
        let pixels = builder.finish().pixels;
        assert_eq!(builder.frames(), 4);
        assert_eq!(pixels[..3], [255, 128, 0]); // 127.5 rounds up
        assert_eq!(pixels[30..33], [0, 191, 0]); // 191.25
    }

    #[test]
    fn without_frames_a_gei_is_black() {
        assert_eq!(GeiBuilder::new().finish().pixels, [0; PIXELS]);
    }
}
