//! Draws a contact sheet: frames of the whole video with the outlines of the figures in them.

use super::evenly_spaced::EvenlySpaced;
use super::mask::Mask;
use image::{Rgb, RgbImage, imageops};

/// The maximum number of frames in a sheet; a long video shows 16 to 32.
const MOST: usize = 32;
/// Frames in a row.
const ACROSS: usize = 4;
/// The maximum number of columns in a frame on the sheet; wider frames are reduced by a whole
/// number.
const WIDEST: u32 = 480;
/// Pixels between frames, and their grey.
const GAP: u32 = 2;
const GROUND: Rgb<u8> = Rgb([96; 3]);
/// The colour of outlines: magenta, which is rare in clothes and walls.
const OUTLINE: Rgb<u8> = Rgb([255, 0, 255]);

/// A contact sheet of frames with outlines, evenly spaced over a video of any length.
#[derive(Clone, Debug)]
pub struct Sheet {
    frames: EvenlySpaced<RgbImage>,
}

impl Default for Sheet {
    fn default() -> Self {
        Self {
            frames: EvenlySpaced::new(MOST),
        }
    }
}

impl Sheet {
    /// Adds the next frame and its figure.
    pub fn push(&mut self, frame: &RgbImage, mask: &Mask) {
        self.frames.push(|| outlined(frame, mask));
    }

    /// Returns all frames as one picture; none without frames.
    #[must_use]
    pub fn picture(&self) -> Option<RgbImage> {
        let frames = self.frames.kept();
        let (columns, rows) = frames.first()?.dimensions();
        let across = frames.len().min(ACROSS);
        let down = frames.len().div_ceil(across);
        let side = |count: usize, pixels: u32| count as u32 * (pixels + GAP) + GAP;
        let size = (side(across, columns), side(down, rows));
        let mut sheet = RgbImage::from_pixel(size.0, size.1, GROUND);
        for (at, frame) in frames.iter().enumerate() {
            let place = |at: usize, pixels| i64::from(GAP) + at as i64 * i64::from(pixels + GAP);
            let (x, y) = (place(at % across, columns), place(at / across, rows));
            imageops::replace(&mut sheet, frame, x, y);
        }
        Some(sheet)
    }
}

/// Returns a frame, reduced if necessary, with the outline of its figure: pixels of the figure next
/// to the background.
fn outlined(frame: &RgbImage, mask: &Mask) -> RgbImage {
    let times = frame.width().div_ceil(WIDEST);
    let (columns, rows) = (
        (frame.width() / times).max(1),
        (frame.height() / times).max(1),
    );
    let mut small = if times == 1 {
        frame.clone()
    } else {
        imageops::thumbnail(frame, columns, rows)
    };
    let at = |x: u32, y: u32| (y * times) as usize * mask.columns() + (x * times) as usize;
    let on = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let on = Mask::new(
        columns as usize,
        on.map(|(x, y)| mask.pixels()[at(x, y)]).collect(),
    );
    let inner = on.eroded(1);
    let pixels = on.pixels().iter().zip(inner.pixels());
    for (pixel, (on, inner)) in small.pixels_mut().zip(pixels) {
        if *on && !inner {
            *pixel = OUTLINE;
        }
    }
    small
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_is_outlined_within() {
        let frame = RgbImage::from_pixel(6, 5, Rgb([9; 3]));
        let on = (0..30).map(|at| (1..5).contains(&(at % 6)) && (1..4).contains(&(at / 6)));
        let found = outlined(&frame, &Mask::new(6, on.collect()));
        let row =
            |y: u32| -> Vec<bool> { (0..6).map(|x| *found.get_pixel(x, y) == OUTLINE).collect() };
        assert_eq!(row(0), [false; 6]);
        assert_eq!(row(1), [false, true, true, true, true, false]);
        assert_eq!(row(2), [false, true, false, false, true, false]);
    }

    #[test]
    fn long_and_large_videos_have_sheets_that_can_be_looked_at() {
        let mut sheet = Sheet::default();
        assert!(sheet.picture().is_none());
        let frame = RgbImage::new(1000, 500);
        let mask = Mask::new(1000, vec![false; 500_000]);
        for _ in 0..40 {
            sheet.push(&frame, &mask);
        }
        // A third: 333 x 166. Every second one of 40 frames: 20, in five rows.
        let size = sheet.picture().map(|picture| picture.dimensions());
        assert_eq!(size, Some((4 * 335 + 2, 5 * 168 + 2)));
    }
}
