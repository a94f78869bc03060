//! Segments video into silhouettes by the difference from the empty scene.
//!
//! The method follows Charalambous & Bharath (BMVC 2016, section 3.3). The colours of a frame in
//! CIE LAB less those of the background give grey differences, which are split into two clusters.
//! Pixels above the middle of the clusters' means are the figure. Details that the paper leaves
//! open are ours:
//!
//! 1. The light of each frame is estimated in red, green and blue, and removed. Differences are
//!    smoothed over three by three pixels, lose what varies slowly over the picture, and are
//!    measured in units of the frame's noise.
//! 2. A darkening that keeps the background's colour, up to a fifth of lightness, counts as shadow
//!    and is ignored. Grey levels are logarithms of the remaining difference, since a figure whose
//!    shirt differs from the wall by ten times the noise has trousers that differ by fifty.
//!    Parts with such a pixel are the figure down to the least difference of a figure.
//! 3. Pixels that were ignored as shadow, or as noise, but lie between other pixels of the figure
//!    are added.
//! 4. Pixels at the rim whose difference is less than 0.45 of the greatest within two pixels are
//!    mixed with the background, or a shadow at a foot. They are removed.
//! 5. The largest part is kept, narrow gaps in it are closed, and small holes are filled. The
//!    command keeps all parts instead, and follows one walker among them from frame to frame.
//!
//! A figure differs by at least six times the noise. Where more than noise exceeds that beside the
//! figure, as in compressed video, the least difference rises to at most 8 of LAB.
//!
//! ```
//! use edgegait::segment::{Segmenter, SegmentSettings};
//! use image::{Rgb, RgbImage};
//!
//! // A red rectangle of 20 by 30 pixels before a grey wall.
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
mod follow;
mod frames;
mod mask;
mod painted;
mod part;
mod sheet;
mod slow_light;
mod stream;
mod writer;
mod y4m;

pub use background::median;
pub(crate) use follow::{FollowedFigure, Follower, warning};
pub use frames::Video;
pub use mask::Mask;
pub(crate) use painted::Painted;
#[cfg(all(feature = "import", feature = "train", feature = "plots"))]
pub(crate) use painted::softened;
pub(crate) use part::Part;
pub use sheet::Sheet;
pub use writer::{SequenceNames, SequenceWriter, check_replaceable};

use crate::draw::grey_threshold::threshold;
use crate::error::{Error, Result};
use crate::files::InputFile;
use difference::{EmptyScene, SceneDifference, over_noise};
use image::RgbImage;
use std::path::Path;

/// The minimum difference of a figure over the noise, and of a pixel between others of the figure.
/// Our choice: noise in three components exceeds six standard deviations in one of 10^7 pixels, and
/// two clusters of noise alone lie lower; it exceeds three in 3 %.
const LEAST_OVER_NOISE: f32 = 6.0;
const LEAST_BETWEEN: f32 = 3.0;
/// Half-width of the square that closes the gaps in which pixels are added, over the square root of
/// the figure's area. Our choice: 11 pixels for a figure of 4,000 pixels (150 rows), less than the
/// width of a thigh.
const TAKEN_BACK: f64 = 0.18;
/// The maximum number of pixels by which the rim is peeled, and the share of the greatest
/// difference within two pixels below which a pixel is removed. Our choice: a half-covered pixel
/// has half of that difference, a little less where smoothing spreads dark colours.
const PEELS: usize = 2;
const PEELED: f32 = 0.45;
/// The maximum area of a hole that is filled, as a share of the figure's. Our choice: clothes of the
/// background's colour have holes of up to 1.5 %, and what an arm leaves open is larger.
const HOLE: f64 = 0.015;
/// Gaps of up to twice this many pixels do not split a figure. Our choice.
const BRIDGED: usize = 2;
/// The largest least difference of a figure in LAB, and the share of the pixels beside it that may
/// exceed the least one. Compressed video has almost no noise (a standard deviation of 0.3 to 0.8),
/// but walls that breathe and change with the exposure. Our choice, from ten rendered videos as they
/// are and as H.264 at three rates.
const LEAST_LAB: f32 = 8.0;
const FALSE_ALARMS: f64 = 0.0002;
/// The median difference at the edges of the scene, in LAB, above which a frame shows another place.
/// Our choice: it is up to 4.3 in compressed video and in light that jumps, and reaches 23 to 32 where
/// a camera shakes by some pixels, moves on, or the video is cut.
const ELSEWHERE: f32 = 6.0;
/// The minimum area of a figure as a share of the picture. Our choice: smaller areas are JPEG
/// blocks in dark, saturated colours (up to 0.14 % of our empty frames), or a figure too small for
/// 50 rows.
const LEAST_SHARE: f64 = 0.002;

/// The settings of the steps after the threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SegmentSettings {
    /// Whether only the largest connected part is the figure.
    pub largest_part: bool,
    /// Half-width of the square by which the figure is closed at the end, pixels; 0 closes nothing.
    pub closing_px: usize,
}

impl Default for SegmentSettings {
    /// Keeps the largest part and closes it by three by three pixels.
    fn default() -> Self {
        Self {
            largest_part: true,
            closing_px: 1,
        }
    }
}

/// The result of the segmentation of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmented {
    /// The figure; empty if it would cover less than 0.2 % of the picture.
    pub mask: Mask,
    /// The difference in LAB above which a pixel belongs to the figure.
    pub threshold: f64,
    /// The noise of a difference in LAB.
    pub noise: f32,
    /// The frame's light over the background's, in red, green and blue.
    pub gain: [f32; 3],
    /// Whether the frame shows another place than the background: the camera has moved, or the video
    /// was cut.
    pub is_elsewhere: bool,
}

/// A segmenter, which compares frames with an empty scene.
#[derive(Clone, Debug)]
pub struct Segmenter {
    scene: EmptyScene,
    settings: SegmentSettings,
}

impl Segmenter {
    /// Makes a segmenter from a picture of the empty scene.
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

    /// Makes a segmenter for a video with frames of this size, and returns it with the files that
    /// were read for the background.
    ///
    /// The background is a picture, the median of the pictures in a folder, or, without either, the
    /// median of at most 32 evenly spaced frames of the video. Memory therefore does not grow with
    /// the video's length, but a file is read twice.
    ///
    /// # Errors
    /// If the background is missing, not a picture or of another size, or if the video has fewer
    /// than 10 frames, cannot be read twice, or has a figure that stays in one place and so is part
    /// of the median.
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

    /// Returns the picture of the empty scene.
    pub(crate) const fn background(&self) -> &RgbImage {
        self.scene.picture()
    }

    /// Returns the minimum area of a figure, pixels.
    pub(crate) fn least_area(&self) -> usize {
        let (columns, rows) = self.scene.size();
        (LEAST_SHARE * f64::from(columns) * f64::from(rows)).ceil() as usize
    }

    /// Returns the parts of a frame's mask, which narrow gaps do not split.
    pub(crate) fn parts(found: &Segmented) -> Vec<Part> {
        Part::all(&found.mask, BRIDGED)
    }

    /// Finds the figure in a frame. Needs about 50 bytes a pixel.
    ///
    /// # Panics
    /// If the frame's size is not the background's.
    #[must_use]
    pub fn segment(&self, frame: &RgbImage) -> Segmented {
        let found = self.scene.difference(frame);
        let columns = frame.width() as usize;
        let clusters = clusters(&found);
        let least = least_level(&found, clusters, columns);
        let level = clusters.max(f64::from(least));
        let above = |level: f64| found.levels.iter().map(move |of| f64::from(*of) > level);
        let most = most_least(&found);
        let lower = level.min(f64::from(most));
        let (mut mask, figure) = Mask::new(columns, above(lower).collect()).with(above(level));
        let between = LEAST_BETWEEN.max(LEAST_LAB / found.noise);
        let between = between.min(over_noise(f64::from(least)) as f32);
        take_back(&mut mask, figure as f64, &found.raw, between);
        for _ in 0..PEELS {
            peel(&mut mask, &found.raw);
        }
        if self.settings.largest_part {
            mask = mask.largest(BRIDGED);
        }
        mask = mask.closed(self.settings.closing_px);
        mask = mask.filled((HOLE * figure as f64) as usize);
        if mask.area() < self.least_area() {
            mask = Mask::new(columns, vec![false; mask.pixels().len()]);
        }
        Segmented {
            mask,
            threshold: over_noise(level) * f64::from(found.noise),
            noise: found.noise,
            gain: found.gain,
            is_elsewhere: found.at_edges > ELSEWHERE,
        }
    }
}

/// Returns the level midway between the two clusters of a frame's levels.
fn clusters(found: &SceneDifference) -> f64 {
    let mut counts = [0; 256];
    for level in &found.levels {
        counts[usize::from(*level)] += 1;
    }
    threshold(&counts)
}

/// Returns the largest least level of a figure.
fn most_least(found: &SceneDifference) -> u8 {
    difference::level(LEAST_OVER_NOISE.max(LEAST_LAB / found.noise))
}

/// Returns the least level of a figure: six times the noise, or up to [`LEAST_LAB`] if more pixels
/// than noise explains exceed that in columns without a figure.
fn least_level(found: &SceneDifference, clusters: f64, columns: usize) -> u8 {
    let least = difference::level(LEAST_OVER_NOISE);
    let most = most_least(found);
    let sure = clusters.max(f64::from(most));
    let mut has_figure = vec![false; columns];
    for row in found.levels.chunks_exact(columns) {
        for (has, level) in has_figure.iter_mut().zip(row) {
            *has |= f64::from(*level) > sure;
        }
    }
    let mut counts = [0_usize; 256];
    for row in found.levels.chunks_exact(columns) {
        for (level, _) in row.iter().zip(&has_figure).filter(|(_, has)| !**has) {
            counts[usize::from(*level)] += 1;
        }
    }
    let all: usize = counts.iter().sum();
    let mut rest = (FALSE_ALARMS * all as f64) as usize;
    let mut level = 255;
    while level > least && counts[usize::from(level)] <= rest {
        rest -= counts[usize::from(level)];
        level -= 1;
    }
    level.clamp(least, most)
}

/// Adds pixels in gaps of the figure of this area that differ from the scene by more than `least`
/// times the noise, even if a shadow would explain them.
fn take_back(mask: &mut Mask, area: f64, raw: &[f32], least: f32) {
    // Rounded; at least a pixel.
    let reach = ((TAKEN_BACK * area.sqrt() + 0.5) as usize).max(1);
    let closed = mask.closed(reach);
    let differs = raw.iter().map(|raw| *raw > least);
    mask.join(
        closed
            .pixels()
            .iter()
            .zip(differs)
            .map(|(on, differs)| *on && differs),
    );
}

/// Removes pixels of the rim whose difference is much less than the greatest within two pixels.
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
