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
    /// Reduced frames, each with its number.
    frames: EvenlySpaced<(usize, RgbImage)>,
    pushed: usize,
}

impl Default for Sheet {
    fn default() -> Self {
        Self {
            frames: EvenlySpaced::new(MOST),
            pushed: 0,
        }
    }
}

impl Sheet {
    /// Adds the next frame.
    pub fn push(&mut self, frame: &RgbImage) {
        let number = self.pushed;
        self.frames.push(|| (number, reduced(frame)));
        self.pushed += 1;
    }

    /// Returns all frames as one picture, each with the outline of its figure, the mask of its
    /// number; none without frames.
    #[must_use]
    pub fn picture(&self, mask: impl Fn(usize) -> Mask) -> Option<RgbImage> {
        let frames = self.frames.kept();
        let (columns, rows) = frames.first()?.1.dimensions();
        let across = frames.len().min(ACROSS);
        let down = frames.len().div_ceil(across);
        let side = |count: usize, pixels: u32| count as u32 * (pixels + GAP) + GAP;
        let size = (side(across, columns), side(down, rows));
        let mut sheet = RgbImage::from_pixel(size.0, size.1, GROUND);
        for (at, (number, frame)) in frames.iter().enumerate() {
            let place = |at: usize, pixels| i64::from(GAP) + at as i64 * i64::from(pixels + GAP);
            let (x, y) = (place(at % across, columns), place(at / across, rows));
            imageops::replace(&mut sheet, &outlined(frame, &mask(*number)), x, y);
        }
        Some(sheet)
    }
}

/// Returns a frame, reduced by a whole number if it is wide.
fn reduced(frame: &RgbImage) -> RgbImage {
    match frame.width().div_ceil(WIDEST) {
        0 | 1 => frame.clone(),
        times => {
            let side = |pixels: u32| (pixels / times).max(1);
            imageops::thumbnail(frame, side(frame.width()), side(frame.height()))
        }
    }
}

/// Returns a reduced frame with the outline of its figure: pixels of the figure next to the
/// background.
fn outlined(small: &RgbImage, mask: &Mask) -> RgbImage {
    let mut small = small.clone();
    let (columns, rows) = small.dimensions();
    let times = mask.columns() / columns as usize;
    let at = |x: u32, y: u32| y as usize * times * mask.columns() + x as usize * times;
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
        let none = |_| Mask::new(1000, vec![false; 500_000]);
        assert!(sheet.picture(none).is_none());
        let frame = RgbImage::new(1000, 500);
        for _ in 0..40 {
            sheet.push(&frame);
        }
        // A third: 333 x 166. Every second one of 40 frames: 20, in five rows.
        let size = sheet.picture(none).map(|picture| picture.dimensions());
        assert_eq!(size, Some((4 * 335 + 2, 5 * 168 + 2)));
    }
}
