//! The median of frames as a picture of the empty scene, and a check whether it is valid.

use super::{SegmentSettings, Segmenter};
use crate::error::{Error, Remedy, Result};
use image::RgbImage;
use rayon::prelude::*;
use std::path::Path;

/// Fewest frames of a median of a video. Our choice: in fewer, a walker leaves no pixel free in
/// most.
pub(super) const MIN_FRAMES: usize = 10;
/// The maximum number of frames in a median. Our choice: the noise of their median is a fifth of a
/// frame's.
const MOST_FRAMES: usize = 32;
/// The maximum number of bytes in the frames of a median.
const MOST_BYTES: usize = 1 << 28;

/// Share of the frames above which a pixel that differs from the median is doubtful. A background
/// is rejected if more than [`MOST_DOUBTFUL`] of all differences are at doubtful pixels. Our
/// choice, from cuts of 15 to 140 frames of the six videos on which constants are chosen: with at
/// most 0.1 doubtful, all cuts reach a mean Jaccard index of 0.90 to the true masks; above it, none
/// reaches 0.83 (2026-11-24).
const DOUBTFUL: f64 = 0.45;
const MOST_DOUBTFUL: f64 = 0.1;

/// Returns the most frames of this size for a median: 32, or fewer if they would take more than
/// 256 MiB, but at least 10.
pub(super) fn sample((columns, rows): (u32, u32)) -> usize {
    let bytes = 3 * columns as usize * rows as usize;
    // An even number, as `EvenlySpaced` requires.
    (MOST_BYTES / bytes.max(1)).clamp(MIN_FRAMES, MOST_FRAMES) / 2 * 2
}

/// Returns the median of each byte of frames of one size; for an even number, the mean of the
/// middle two, rounded up. None without frames.
///
/// # Panics
/// If their sizes differ, or there are more than 255.
#[must_use]
pub fn median(frames: &[RgbImage]) -> Option<RgbImage> {
    let first = frames.first()?;
    let (columns, rows) = first.dimensions();
    assert!(frames.len() < 256, "as many as are counted");
    for frame in frames {
        assert_eq!(frame.dimensions(), (columns, rows), "one size");
    }
    let count = frames.len();
    let mut bytes = vec![0; first.len()];
    let width = 3 * columns as usize;
    let by_row = bytes.par_chunks_mut(width).enumerate();
    by_row.for_each(|(row, into)| {
        let mut values = [0; 256];
        for (at, into) in into.iter_mut().enumerate() {
            for (value, frame) in values.iter_mut().zip(frames) {
                *value = frame.as_raw()[row * width + at];
            }
            let values = &mut values[..count];
            values.sort_unstable();
            let sum = u16::from(values[(count - 1) / 2]) + u16::from(values[count / 2]);
            // A mean of two bytes.
            *into = sum.div_ceil(2) as u8;
        }
    });
    RgbImage::from_raw(columns, rows, bytes)
}

/// Rejects a median of frames that contains the figure: a person who walks towards the camera, or
/// stands.
///
/// If the figure covers a pixel in most frames, its colour is the median, and the other frames
/// differ there. In a correct background each pixel differs in few frames, since the figure moves
/// on.
///
/// # Errors
/// States the share of the differences that does not move.
pub(super) fn check_background(
    segmenter: &Segmenter,
    frames: &[RgbImage],
    path: &Path,
) -> Result<()> {
    let whole = Segmenter {
        settings: SegmentSettings::default(),
        ..segmenter.clone()
    };
    let masks: Vec<_> = frames
        .par_iter()
        .map(|frame| whole.segment(frame).mask)
        .collect();
    let pixels = frames
        .first()
        .map_or(0, |frame| frame.width() as usize * frame.height() as usize);
    let mut counts = vec![0_usize; pixels];
    for mask in &masks {
        for (count, on) in counts.iter_mut().zip(mask.pixels()) {
            *count += usize::from(*on);
        }
    }
    let all: usize = counts.iter().sum();
    if all == 0 {
        return Err(Error::input(
            path,
            "expected a person who moves before a static scene, found nothing that differs from the median of the frames",
        )
        .with_remedy(Remedy::GiveBackground));
    }
    let least = DOUBTFUL * frames.len() as f64;
    let doubtful: usize = counts.iter().filter(|count| **count as f64 > least).sum();
    let share = doubtful as f64 / all as f64;
    if share <= MOST_DOUBTFUL {
        return Ok(());
    }
    Err(Error::input(
        path,
        format!(
            "expected a figure that moves over the image, so that the median of the frames is the background, found {:.0} % of the differences at pixels that differ in nearly half of the frames: the figure stays there (a person who walks towards the camera, or a short video), or the camera moves",
            100.0 * share
        ),
    )
    .with_remedy(Remedy::GiveBackground))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    fn grey(byte: u8) -> RgbImage {
        RgbImage::from_pixel(2, 1, Rgb([byte, 255 - byte, 7]))
    }

    #[test]
    fn the_median_is_the_middle_one_or_the_mean_of_two() {
        let of = |bytes: &[u8]| {
            let frames: Vec<RgbImage> = bytes.iter().map(|byte| grey(*byte)).collect();
            median(&frames).map(|found| found.get_pixel(1, 0).0)
        };
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[9]), Some([9, 246, 7]));
        assert_eq!(of(&[200, 1, 50]), Some([50, 205, 7]));
        // 50 and 53 give 51.5, and 205 and 202 give 203.5.
        assert_eq!(of(&[200, 1, 50, 53]), Some([52, 204, 7]));
    }

    #[test]
    fn large_frames_are_fewer() {
        assert_eq!(sample((480, 240)), 32);
        // 25 million bytes each: ten of them fit.
        assert_eq!(sample((3840, 2160)), 10);
        assert_eq!(sample((4096, 4096)), MIN_FRAMES);
    }

    /// Returns a picture of a wall and a box of this width at a column.
    fn scene(at: u32, width: u32) -> RgbImage {
        RgbImage::from_fn(120, 60, |x, y| {
            if (at..at + width).contains(&x) && (10..50).contains(&y) {
                Rgb([40, 60, 160])
            } else {
                Rgb([150, 140 + (x % 7) as u8, 130])
            }
        })
    }

    #[test]
    fn who_crosses_the_image_is_trusted_and_who_grows_or_stands_is_not() {
        let check = |frames: &[RgbImage]| {
            let segmenter = Segmenter::new(median(frames).unwrap(), SegmentSettings::default());
            check_background(&segmenter, frames, Path::new("walk"))
        };
        let crossing: Vec<RgbImage> = (0..20).map(|at| scene(5 * at, 20)).collect();
        check(&crossing).unwrap();
        let growing: Vec<RgbImage> = (0..20).map(|at| scene(60 - at, 2 * at + 8)).collect();
        let error = check(&growing).unwrap_err().to_string();
        assert!(
            error.starts_with("walk: expected a figure that moves"),
            "{error}"
        );
        let standing = vec![scene(50, 20); 12];
        let error = check(&standing).unwrap_err().to_string();
        assert!(error.contains("nothing that differs"), "{error}");
    }
}
