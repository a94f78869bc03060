//! Video to silhouettes: who is in a picture that is not in the empty scene.
//!
//! As Charalambous & Bharath segment video (BMVC 2016, section 3.3): colours in CIE LAB, less those
//! of the background, as grey differences, which are parted into two clusters; what is above the
//! middle of the clusters' means is the figure. What their page leaves open is ours:
//!
//! 1. The light of each frame is estimated in red, green and blue, and taken out; differences
//!    are smoothed over three by three pixels and measured in units of the frame's noise.
//! 2. A darkening that keeps the background's colour, up to a fifth of lightness, is forgiven: a
//!    shadow does that. Grey is the logarithm of what is left, since a figure whose shirt differs
//!    from the wall by ten times the noise has trousers that differ by fifty.
//! 3. Pixels that were forgiven, but lie between others of the figure, are taken back.
//! 4. Pixels at the rim whose difference is less than half of what lies further in are mixed with
//!    the background, or a shadow at a foot: they go.
//! 5. The largest part is kept, and small gaps in it are closed.
//!
//! ```
//! use edgegait::segment::{Segmenter, SegmentSettings};
//! use image::{Rgb, RgbImage};
//!
//! // A red square of 20 by 30 pixels before a grey wall.
//! let wall = RgbImage::from_pixel(80, 60, Rgb([150, 150, 140]));
//! let mut frame = wall.clone();
//! for (x, y) in (0..20).flat_map(|x| (0..30).map(move |y| (30 + x, 15 + y))) {
//!     frame.put_pixel(x, y, Rgb([160, 40, 40]));
//! }
//! let segmenter = Segmenter::new(wall, SegmentSettings::default());
//! assert_eq!(segmenter.segment(&frame).mask.area(), 20 * 30);
//! ```

mod background;
mod cie_lab;
mod difference;
mod evenly_spaced;
mod frames;
mod mask;
mod painted;
mod sheet;
mod stream;
mod writer;
mod y4m;

pub use background::median;
pub use frames::Video;
pub use mask::Mask;
pub(crate) use painted::Painted;
#[cfg(all(feature = "import", feature = "train", feature = "plots"))]
pub(crate) use painted::softened;
pub use sheet::Sheet;
pub use writer::{SequenceNames, SequenceWriter, check_replaceable};

use crate::dataset::InputFile;
use crate::error::{Error, Result};
use crate::grey_threshold::threshold;
use difference::{EmptyScene, SceneDifference, over_noise};
use image::RgbImage;
use std::path::Path;

/// Least difference of a figure, of the noise. Ours: of a normal deviate in three parts six times its
/// deviation is left to one of 10^7 pixels, and two clusters of noise alone lie lower.
const LEAST_OVER_NOISE: f32 = 6.0;
/// Side of the square whose gaps pixels are taken back in, to each side, of the root of the figure's
/// area. Ours: of a figure of 4,000 pixels (150 rows) 11 pixels, less than a thigh is wide.
const TAKEN_BACK: f64 = 0.18;
/// How many pixels the rim is peeled at most, and below which share of the greatest difference two
/// pixels further in. Ours: a pixel half covered has half of it, a little less where smoothing
/// spreads what is dark.
const PEELS: usize = 2;
const PEELED: f32 = 0.45;
/// Gaps of up to twice as many pixels do not part a figure. Ours.
const BRIDGED: usize = 2;
/// Least area of a figure, of the picture. Ours: less is blocks of JPEG in dark, saturated colours (up
/// to 0.14 % of our empty frames), or a figure too small for 50 rows.
const LEAST_SHARE: f64 = 0.002;

/// What is done beyond the threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SegmentSettings {
    /// Whether only the largest connected part is the figure.
    pub largest_part: bool,
    /// Half the side of the square by which it is closed at the end, pixels; 0 closes nothing.
    pub closing_px: usize,
}

impl Default for SegmentSettings {
    /// The largest part, closed by three by three pixels.
    fn default() -> Self {
        Self {
            largest_part: true,
            closing_px: 1,
        }
    }
}

/// A frame in parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmented {
    /// Where the figure is; nowhere, if it would cover less than 0.2 % of the picture.
    pub mask: Mask,
    /// The difference in LAB above which a pixel is the figure.
    pub threshold: f64,
    /// The noise of a difference in LAB.
    pub noise: f32,
    /// How much stronger the light is than in the background, in red, green and blue.
    pub gain: [f32; 3],
}

/// An empty scene that frames are compared with.
#[derive(Clone, Debug)]
pub struct Segmenter {
    scene: EmptyScene,
    settings: SegmentSettings,
}

impl Segmenter {
    /// Of a picture of the empty scene.
    ///
    /// # Panics
    /// If it has no pixels.
    #[must_use]
    pub fn new(background: RgbImage, settings: SegmentSettings) -> Self {
        assert!(!background.is_empty(), "pixels");
        Self {
            scene: EmptyScene::new(background),
            settings,
        }
    }

    /// Of the empty scene of a video with frames of this size: a picture, the median of the pictures in
    /// a folder, or, without either, of frames of the video itself; with the files that were read for it.
    ///
    /// The median of a video is of at most 32 frames, evenly spaced, so that memory does not grow with
    /// its length; a file is read twice.
    ///
    /// # Errors
    /// If the background is of another size, no picture or not there; if the video has fewer than 10
    /// frames, cannot be read twice, or has a figure that stays where it is, so that it is part of the
    /// median.
    pub fn open(
        video: &Path,
        size: (u32, u32),
        background: Option<&Path>,
        settings: SegmentSettings,
    ) -> Result<(Self, Vec<InputFile>)> {
        if let Some(path) = background {
            let (picture, inputs) = frames::given_background(path, size)?;
            return Ok((Self::new(picture, settings), inputs));
        }
        let frames = frames::background_of(video)?;
        let picture = median(&frames).ok_or(Error::Missing("frames"))?;
        let segmenter = Self::new(picture, settings);
        background::check_background(&segmenter, &frames, video)?;
        Ok((segmenter, Vec::new()))
    }

    /// Columns and rows of the background, and so of frames.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        self.scene.size()
    }

    /// The picture of the empty scene.
    pub(crate) const fn background(&self) -> &RgbImage {
        self.scene.picture()
    }

    /// Where the figure is in a frame. Takes about 60 bytes a pixel while it works.
    ///
    /// # Panics
    /// If its size is not the background's.
    #[must_use]
    pub fn segment(&self, frame: &RgbImage) -> Segmented {
        let found = self.scene.difference(frame);
        let least = f64::from(difference::level(LEAST_OVER_NOISE));
        let level = clusters(&found).max(least);
        let columns = frame.width() as usize;
        let above = found.levels.iter().map(|of| f64::from(*of) > level);
        let mut mask = Mask::new(columns, above.collect());
        take_back(&mut mask, &found.raw);
        for _ in 0..PEELS {
            peel(&mut mask, &found.raw);
        }
        if self.settings.largest_part {
            mask = mask.largest(BRIDGED);
        }
        mask = mask.closed(self.settings.closing_px);
        if (mask.area() as f64) < LEAST_SHARE * mask.pixels().len() as f64 {
            mask = Mask::new(columns, vec![false; mask.pixels().len()]);
        }
        Segmented {
            mask,
            threshold: over_noise(level) * f64::from(found.noise),
            noise: found.noise,
            gain: found.gain,
        }
    }
}

/// The level midway between the two clusters of a frame's levels.
fn clusters(found: &SceneDifference) -> f64 {
    let mut counts = [0; 256];
    for level in &found.levels {
        counts[usize::from(*level)] += 1;
    }
    threshold(&counts)
}

/// Adds pixels that differ and lie in gaps of the figure, though a shadow would explain them.
fn take_back(mask: &mut Mask, raw: &[f32]) {
    let area = mask.largest(0).area() as f64;
    // Rounded; at least a pixel.
    let reach = ((TAKEN_BACK * area.sqrt() + 0.5) as usize).max(1);
    let closed = mask.closed(reach);
    let differs = raw.iter().map(|raw| *raw > LEAST_OVER_NOISE);
    mask.join(
        closed
            .pixels()
            .iter()
            .zip(differs)
            .map(|(on, differs)| *on && differs),
    );
}

/// Takes off pixels of the rim that differ by much less than what lies two pixels further in.
fn peel(mask: &mut Mask, raw: &[f32]) {
    let inner = mask.eroded(1);
    let columns = mask.columns();
    let last = (mask.rows() - 1, columns - 1);
    let on = mask.pixels();
    let greatest = |at: usize| {
        let (row, column) = (at / columns, at % columns);
        let near = |at: usize, last: usize| at.saturating_sub(2)..=(at + 2).min(last);
        let mut most = 0.0_f32;
        for row in near(row, last.0) {
            for column in near(column, last.1) {
                let at = row * columns + column;
                if on[at] {
                    most = most.max(raw[at]);
                }
            }
        }
        most
    };
    let stays = |at: usize| !on[at] || inner.pixels()[at] || raw[at] >= PEELED * greatest(at);
    let stays: Vec<bool> = (0..raw.len()).map(stays).collect();
    mask.keep(stays);
}

#[cfg(test)]
mod tests;
