//! Follows the figures of a scene from frame to frame, so that one walker stays one walker.
//!
//! Parts of a mask that nearly touch are one figure. A figure goes on where its box, moved on by its
//! mean speed, overlaps that of a figure of the next frame most. It may be hidden for some frames.

use super::mask::Mask;

/// The distance of two boxes, of the taller one's height, up to which they are one figure: a head
/// without a neck, or a foot without a shank, whose clothes have the wall's colour. Our choice.
const NEAR: f64 = 0.06;
/// The least overlap (Jaccard index) of a figure's expected and found boxes. Our choice: a person
/// who walks at 1.5 m/s past a camera of 10 frames a second moves by half of their width.
const LEAST_OVERLAP: f64 = 0.2;
/// The maximum number of frames for which a walker may be hidden. Our choice: half a second.
const MOST_HIDDEN: usize = 15;
/// The weight of the last step in the mean speed.
const LATEST: f64 = 0.3;

/// The smallest upright rectangle around pixels: columns and rows, ends excluded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PixelBox {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl PixelBox {
    const EMPTY: Self = Self {
        left: f64::INFINITY,
        right: f64::NEG_INFINITY,
        top: f64::INFINITY,
        bottom: f64::NEG_INFINITY,
    };

    fn joined(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            right: self.right.max(other.right),
            top: self.top.min(other.top),
            bottom: self.bottom.max(other.bottom),
        }
    }

    fn moved(self, (x, y): (f64, f64)) -> Self {
        Self {
            left: self.left + x,
            right: self.right + x,
            top: self.top + y,
            bottom: self.bottom + y,
        }
    }

    fn width(self) -> f64 {
        self.right - self.left
    }

    fn height(self) -> f64 {
        self.bottom - self.top
    }

    fn centre(self) -> (f64, f64) {
        (
            (self.left + self.right) / 2.0,
            (self.top + self.bottom) / 2.0,
        )
    }

    /// Returns the shared area over that of both together.
    fn overlap(self, other: Self) -> f64 {
        let across = self.right.min(other.right) - self.left.max(other.left);
        let down = self.bottom.min(other.bottom) - self.top.max(other.top);
        let both = across.max(0.0) * down.max(0.0);
        both / (self.width() * self.height() + other.width() * other.height() - both)
    }

    /// Returns whether most of it lies in another box.
    fn is_within(self, other: Self) -> bool {
        let across = self.right.min(other.right) - self.left.max(other.left);
        let down = self.bottom.min(other.bottom) - self.top.max(other.top);
        across.max(0.0) * down.max(0.0) > 0.5 * self.width() * self.height()
    }

    /// Returns whether the boxes are one figure.
    fn is_near(self, other: Self) -> bool {
        let most = NEAR * self.height().max(other.height());
        let across = self.left.max(other.left) - self.right.min(other.right);
        let down = self.top.max(other.top) - self.bottom.min(other.bottom);
        across <= most && down <= most
    }
}

/// A figure in a frame, as runs of pixels: row, first column, and the column after the last.
#[derive(Clone, Debug)]
struct Figure {
    bounds: PixelBox,
    area: usize,
    runs: Vec<(u32, u32, u32)>,
}

impl Figure {
    fn join(&mut self, other: Self) {
        self.bounds = self.bounds.joined(other.bounds);
        self.area += other.area;
        self.runs.extend(other.runs);
    }

    /// Returns the figures of a mask, the first from above first.
    fn all(mask: &Mask, bridged: usize) -> Vec<Self> {
        let (part_of, parts) = mask.dilated(bridged).parts();
        let none = Self {
            bounds: PixelBox::EMPTY,
            area: 0,
            runs: Vec::new(),
        };
        let mut found = vec![none; parts];
        let columns = mask.columns();
        for (row, pixels) in mask.pixels().chunks_exact(columns).enumerate() {
            let mut column = 0;
            while column < columns {
                if !pixels[column] {
                    column += 1;
                    continue;
                }
                let start = column;
                while column < columns && pixels[column] {
                    column += 1;
                }
                // Pixels of a run are of one part, which their dilation keeps together.
                let part = part_of[row * columns + start] as usize - 1;
                let (row, start, end) = (row as u32, start as u32, column as u32);
                found[part].runs.push((row, start, end));
                found[part].area += (end - start) as usize;
                found[part].bounds = found[part].bounds.joined(PixelBox {
                    left: start.into(),
                    right: end.into(),
                    top: row.into(),
                    bottom: (row + 1).into(),
                });
            }
        }
        found.retain(|figure| figure.area > 0);
        joined(found)
    }

    fn mask(&self, (columns, rows): (usize, usize)) -> Mask {
        let mut on = vec![false; columns * rows];
        for &(row, start, end) in &self.runs {
            on[row as usize * columns..][start as usize..end as usize].fill(true);
        }
        Mask::new(columns, on)
    }
}

/// Joins parts that are near each other, until none are.
fn joined(parts: Vec<Figure>) -> Vec<Figure> {
    let mut figures: Vec<Figure> = Vec::new();
    for mut part in parts {
        // A part that grew may have come near to others.
        while let Some(at) = figures
            .iter()
            .position(|one| one.bounds.is_near(part.bounds))
        {
            let mut near = figures.remove(at);
            near.join(part);
            part = near;
        }
        figures.push(part);
    }
    figures
}

/// A figure that was followed.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    /// The number of its first frame.
    pub(crate) first: usize,
    /// The figure in each frame from the first on; none where it is hidden or meets another one.
    figures: Vec<Option<Figure>>,
    bounds: PixelBox,
    speed: (f64, f64),
    hidden: usize,
    /// The frames in which it met another figure.
    pub(crate) met: Vec<usize>,
}

impl Track {
    fn begin(frame: usize, figure: Figure) -> Self {
        Self {
            first: frame,
            bounds: figure.bounds,
            figures: vec![Some(figure)],
            speed: (0.0, 0.0),
            hidden: 0,
            met: Vec::new(),
        }
    }

    /// Returns where the figure is expected.
    fn expected(&self) -> PixelBox {
        let frames = (self.hidden + 1) as f64;
        self.bounds
            .moved((self.speed.0 * frames, self.speed.1 * frames))
    }

    fn go_on(&mut self, figure: Figure) {
        let steps = (self.hidden + 1) as f64;
        let (from, to) = (self.bounds.centre(), figure.bounds.centre());
        let mean = |mean: f64, step: f64| mean + LATEST * (step / steps - mean);
        self.speed = (
            mean(self.speed.0, to.0 - from.0),
            mean(self.speed.1, to.1 - from.1),
        );
        self.bounds = figure.bounds;
        self.hidden = 0;
        self.figures.push(Some(figure));
    }

    fn hide(&mut self) {
        self.hidden += 1;
        self.figures.push(None);
    }

    /// Returns the numbers of frames in which it is seen.
    pub(crate) fn frames(&self) -> usize {
        self.figures.iter().flatten().count()
    }

    /// Returns the number of the frame after the last in which it is seen.
    pub(crate) fn end(&self) -> usize {
        self.first + self.figures.len() - self.hidden.min(self.figures.len())
    }

    /// Returns the sum of its areas, pixels.
    pub(crate) fn total(&self) -> usize {
        self.figures
            .iter()
            .flatten()
            .map(|figure| figure.area)
            .sum()
    }

    /// Returns whether it moves by more than its width, or grows or shrinks by a third, as those do
    /// who walk towards the camera.
    pub(crate) fn moves(&self) -> bool {
        let seen = || self.figures.iter().flatten().map(|figure| figure.bounds);
        let centres = || seen().map(|bounds| bounds.centre().0);
        let most = centres().fold(f64::NEG_INFINITY, f64::max);
        let least = centres().fold(f64::INFINITY, f64::min);
        let width = seen().map(PixelBox::width).sum::<f64>() / seen().count().max(1) as f64;
        let tall = seen().map(PixelBox::height).fold(0.0, f64::max);
        let small = seen().map(PixelBox::height).fold(f64::INFINITY, f64::min);
        most - least > width || tall > small * 4.0 / 3.0
    }

    /// Returns warnings about frames in which it is not seen, though before and after.
    pub(crate) fn doubts(&self) -> Vec<String> {
        let hidden: Vec<usize> = { self.first..self.end() }
            .filter(|frame| self.figures[frame - self.first].is_none())
            .filter(|frame| !self.met.contains(frame))
            .collect();
        [
            ("in which the walker meets somebody", &self.met),
            ("in which the walker is not found", &hidden),
        ]
        .into_iter()
        .filter(|(_, frames)| !frames.is_empty())
        .map(|(what, frames)| {
            let ends = (frames[0], frames[frames.len() - 1]);
            let count = frames.len();
            format!(
                "{count} frames are empty {what}, from {} to {}",
                ends.0, ends.1
            )
        })
        .collect()
    }

    /// Returns its silhouette in a frame of these columns and rows; empty where it is not seen.
    pub(crate) fn mask(&self, frame: usize, size: (usize, usize)) -> Mask {
        let figure = frame
            .checked_sub(self.first)
            .and_then(|at| self.figures.get(at)?.as_ref());
        figure.map_or_else(
            || Mask::new(size.0, vec![false; size.0 * size.1]),
            |figure| figure.mask(size),
        )
    }
}

/// Follows the figures of a video. Keeps each figure of each frame as runs: about 10 kB a figure of
/// 1,000 rows.
#[derive(Debug, Default)]
pub(crate) struct Follower {
    tracks: Vec<Track>,
    frames: usize,
}

impl Follower {
    /// Adds the mask of the next frame. Gaps of up to twice `bridged` pixels do not split a part,
    /// and figures of fewer than `least` pixels are none.
    pub(crate) fn push(&mut self, mask: &Mask, bridged: usize, least: usize) {
        let frame = self.frames;
        self.frames += 1;
        let mut figures: Vec<Option<Figure>> = { Figure::all(mask, bridged).into_iter() }
            .filter(|figure| figure.area >= least)
            .map(Some)
            .collect();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        let active = self.tracks.iter().enumerate();
        let active: Vec<usize> = active
            .filter(|(_, track)| track.hidden <= MOST_HIDDEN)
            .map(|(at, _)| at)
            .collect();
        for &track in &active {
            let expected = self.tracks[track].expected();
            for (at, figure) in figures.iter().enumerate() {
                let overlap = figure
                    .as_ref()
                    .map_or(0.0, |one| one.bounds.overlap(expected));
                if overlap >= LEAST_OVERLAP {
                    pairs.push((overlap, track, at));
                }
            }
        }
        // Of equal overlaps the older track goes on.
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut found: Vec<Option<Figure>> = vec![None; self.tracks.len()];
        for (_, track, at) in pairs {
            if found[track].is_none() {
                found[track] = figures[at].take();
            }
        }
        // Who is expected within another one's figure, and found nowhere else, has met that one.
        let lost: Vec<PixelBox> = { active.iter() }
            .filter(|track| found[**track].is_none())
            .map(|track| self.tracks[*track].expected())
            .collect();
        for track in active {
            let followed = &mut self.tracks[track];
            match found[track].take() {
                Some(figure) if lost.iter().any(|other| other.is_within(figure.bounds)) => {
                    followed.met.push(frame);
                    followed.hide();
                }
                Some(figure) => followed.go_on(figure),
                None => followed.hide(),
            }
        }
        let new = figures.into_iter().flatten();
        self.tracks
            .extend(new.map(|figure| Track::begin(frame, figure)));
    }

    /// Adds the mask of the next frame as one figure, whatever is in it.
    pub(crate) fn push_whole(&mut self, mask: &Mask) {
        let frame = self.frames;
        self.frames += 1;
        let whole = Figure::all(mask, 0).into_iter().reduce(|mut all, more| {
            all.join(more);
            all
        });
        match (self.tracks.first_mut(), whole) {
            (Some(track), Some(figure)) => track.go_on(figure),
            (Some(track), None) => track.hide(),
            (None, Some(figure)) => self.tracks.push(Track::begin(frame, figure)),
            (None, None) => {}
        }
    }

    /// Returns the figures that were followed, the one with the largest sum of areas first; those
    /// that move before those that do not.
    pub(crate) fn finish(self) -> Vec<Track> {
        let mut tracks = self.tracks;
        tracks.sort_by_key(|track| (!track.moves(), std::cmp::Reverse(track.total())));
        tracks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (120, 60);

    /// Returns a mask of rectangles: left, top, width and height.
    fn mask(blocks: &[(usize, usize, usize, usize)]) -> Mask {
        let is_on = |x: usize, y: usize| {
            let is_in = |&(left, top, width, height): &(usize, usize, usize, usize)| {
                (left..left + width).contains(&x) && (top..top + height).contains(&y)
            };
            blocks.iter().any(is_in)
        };
        let pixels = (0..SIZE.0 * SIZE.1).map(|at| is_on(at % SIZE.0, at / SIZE.0));
        Mask::new(SIZE.0, pixels.collect())
    }

    fn followed(frames: &[Vec<(usize, usize, usize, usize)>]) -> Vec<Track> {
        let mut follower = Follower::default();
        for blocks in frames {
            follower.push(&mask(blocks), 1, 10);
        }
        follower.finish()
    }

    #[test]
    fn a_head_without_a_neck_stays_on_its_walker() {
        let frames: Vec<_> = (0..20)
            .map(|at| vec![(4 * at, 10, 8, 8), (4 * at, 20, 10, 30)])
            .collect();
        let tracks = followed(&frames);
        assert_eq!(tracks.len(), 1);
        assert_eq!(tracks[0].frames(), 20);
        assert_eq!(tracks[0].mask(7, SIZE), mask(&frames[7]));
    }

    #[test]
    fn the_walker_stays_the_walker_though_a_bystander_is_larger() {
        // The walker leaves after 20 frames; the bystander only sways.
        let frames: Vec<_> = (0..40)
            .map(|at| {
                let mut blocks = vec![(90 + at % 2, 5, 20, 50)];
                if at < 20 {
                    blocks.push((3 * at, 20, 8, 30));
                }
                blocks
            })
            .collect();
        let tracks = followed(&frames);
        assert_eq!(tracks.len(), 2);
        assert!(tracks[0].moves() && !tracks[1].moves());
        assert_eq!((tracks[0].frames(), tracks[0].end()), (20, 20));
        assert_eq!(tracks[0].mask(30, SIZE).area(), 0);
        assert_eq!(tracks[0].mask(5, SIZE), mask(&[(15, 20, 8, 30)]));
    }

    #[test]
    fn two_who_meet_go_on_as_before_and_are_left_out_while_they_meet() {
        // They cross in the middle, at opposite speeds.
        let frames: Vec<_> = (0..54)
            .map(|at| vec![(2 * at, 10, 10, 40), (110 - 2 * at, 12, 9, 36)])
            .collect();
        let tracks = followed(&frames);
        assert_eq!(tracks.len(), 2, "{:?}", tracks.len());
        for (track, left) in tracks.iter().zip([0, 110]) {
            let first = track.mask(0, SIZE);
            let is_left = first.pixels()[20 * SIZE.0 + left + 2];
            assert!(is_left);
            let last = track.mask(53, SIZE);
            let at = if left == 0 { 106 } else { 4 };
            assert!(last.pixels()[20 * SIZE.0 + at + 2], "{left}");
        }
        let met = tracks.iter().map(|track| track.met.len()).sum::<usize>();
        assert!((2..12).contains(&met), "{met}");
    }
}
