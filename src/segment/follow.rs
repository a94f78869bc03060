//! Follows the figures of a scene from frame to frame, so that one walker stays one walker.
//!
//! A figure goes on in the part of the next mask whose box overlaps its own, moved on by its mean
//! speed, most. Other parts inside that box are the figure's too: a head without a neck, or a foot
//! without a shank, whose clothes have the wall's colour. A figure may be hidden for some frames.

use super::mask::Mask;
use super::part::{Part, PixelBox, joined};
use std::ops::Range;

/// The least overlap (Jaccard index) of a figure's expected and found boxes. Our choice: a person
/// who walks at 1.5 m/s past a camera of 10 frames a second moves by half of their width.
const LEAST_OVERLAP: f64 = 0.2;
/// The least area of a part that is added, as a share of the figure's last one: a wall that
/// flickers has smaller parts. Our choice: a head has a tenth of a figure, a leg more.
const LEAST_PIECE: f64 = 0.1;
/// The least area of all parts together of a figure that has fallen apart, as a share of its last
/// one, and of a figure that may hide another one. Our choice.
const LEAST_LEFT: f64 = 0.3;
/// The maximum number of frames for which a walker may be hidden. Our choice: half a second.
const MOST_HIDDEN: usize = 15;
/// The least number of frames in which a figure is seen before it may meet another one. Our choice:
/// a third of a second.
const ESTABLISHED: usize = 10;
/// The number of frames until a figure's speed is known. Until then the next one may be beside it.
const YOUNG: usize = 3;
/// The weight of the last step in the mean speed; more at the beginning. Our choice.
const LATEST: f64 = 0.3;

/// The number of times of a video whose median boxes show whether a figure moves. Our choice.
const TIMES: usize = 6;

/// The maximum number of spans of frames that a warning lists.
const MOST_SPANS: usize = 5;

/// Returns the median of a measure of boxes; 0 without boxes.
fn middle(boxes: &[PixelBox], of: impl Fn(PixelBox) -> f64) -> f64 {
    let mut values: Vec<f64> = boxes.iter().map(|bounds| of(*bounds)).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Says that frames are so; none without frames. Frame 0 has the number `from`.
pub(crate) fn warning(frames: &[usize], from: usize, what: &str) -> Option<String> {
    let count = frames.len();
    (count > 0).then(|| format!("{count} frames {what}: {}", spans(frames, from)))
}

/// Lists ascending numbers plus `from` as the first and last of each span, at most five of them.
fn spans(numbers: &[usize], from: usize) -> String {
    let mut spans = numbers.chunk_by(|a, b| a + 1 == *b);
    let show = |span: &[usize]| match (span.first(), span.last()) {
        (Some(first), Some(last)) if first < last => format!("{} to {}", first + from, last + from),
        (first, _) => first.map_or_else(String::new, |only| (only + from).to_string()),
    };
    let mut shown: Vec<String> = spans.by_ref().take(MOST_SPANS).map(show).collect();
    let more = spans.count();
    if more > 0 {
        shown.push(format!("and {more} more"));
    }
    shown.join(", ")
}

/// A figure that was followed.
#[derive(Clone, Debug)]
pub(crate) struct FollowedFigure {
    /// The number of its first frame.
    pub(crate) first: usize,
    /// The figure in each frame from the first on; none where it is hidden or meets another one.
    figures: Vec<Option<Part>>,
    bounds: PixelBox,
    area: usize,
    speed: (f64, f64),
    hidden: usize,
    /// The frames in which it met another figure.
    met: Vec<usize>,
    /// The frames in which a side of the picture cuts it.
    cut: Vec<usize>,
}

impl FollowedFigure {
    fn begin(frame: usize, figure: Part) -> Self {
        Self {
            first: frame,
            bounds: figure.bounds,
            area: figure.area,
            figures: vec![Some(figure)],
            speed: (0.0, 0.0),
            hidden: 0,
            met: Vec::new(),
            cut: Vec::new(),
        }
    }

    /// Returns where the figure is expected.
    fn expected(&self) -> PixelBox {
        let frames = (self.hidden + 1) as f64;
        self.bounds
            .moved((self.speed.0 * frames, self.speed.1 * frames))
    }

    fn go_on(&mut self, figure: Part) {
        let steps = (self.hidden + 1) as f64;
        let (from, to) = (self.bounds.centre(), figure.bounds.centre());
        let weight = LATEST.max(1.0 / self.frames() as f64);
        let mean = |mean: f64, step: f64| mean + weight * (step / steps - mean);
        self.speed = (
            mean(self.speed.0, to.0 - from.0),
            mean(self.speed.1, to.1 - from.1),
        );
        self.bounds = figure.bounds;
        self.area = figure.area;
        self.hidden = 0;
        self.figures.push(Some(figure));
    }

    fn hide(&mut self) {
        self.hidden += 1;
        self.figures.push(None);
    }

    /// Returns the number of frames in which it is seen.
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

    /// Returns its boxes where it is seen.
    fn seen(&self) -> Vec<PixelBox> {
        let figures = self.figures.iter().flatten();
        figures.map(|figure| figure.bounds).collect()
    }

    /// Returns whether it moves by more than its width, or grows or shrinks by a third, as those do
    /// who walk towards the camera. The parts of a wall that flicker do not.
    pub(crate) fn moves(&self) -> bool {
        let seen = self.seen();
        let times = seen.chunks(seen.len().div_ceil(TIMES).max(1));
        let (mut centres, mut heights) = (Vec::new(), Vec::new());
        for boxes in times {
            centres.push(middle(boxes, |bounds| bounds.centre().0));
            heights.push(middle(boxes, PixelBox::height));
        }
        let least = |of: &[f64]| of.iter().copied().fold(f64::INFINITY, f64::min);
        let most = |of: &[f64]| of.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most(&centres) - least(&centres) > middle(&seen, PixelBox::width)
            || most(&heights) > least(&heights) * 4.0 / 3.0
    }

    /// Leaves out frames in which it reaches the first or the last of these columns, beyond which the
    /// rest of it may lie.
    pub(crate) fn leave_out_cut(&mut self, columns: &Range<usize>) {
        let (left, right) = (columns.start as f64, columns.end as f64);
        for (frame, figure) in { self.first.. }.zip(&mut self.figures) {
            let is_cut = |part: &mut Part| part.bounds.left <= left || part.bounds.right >= right;
            if figure.take_if(is_cut).is_some() {
                self.cut.push(frame);
            }
        }
    }

    /// Returns whether it can hide a figure of this area.
    fn can_hide(&self, area: usize) -> bool {
        let least = LEAST_LEFT * area as f64;
        self.frames() >= ESTABLISHED && self.area as f64 >= least && self.moves()
    }

    /// Returns warnings about frames in which it is not seen, though before and after, or cut.
    /// Frame 0 has the number `from`.
    pub(crate) fn doubts(&self, from: usize) -> Vec<String> {
        let is_known = |frame: &usize| self.met.contains(frame) || self.cut.contains(frame);
        let hidden: Vec<usize> = { self.first..self.end() }
            .filter(|frame| self.figures[frame - self.first].is_none() && !is_known(frame))
            .collect();
        let mut met = self.met.clone();
        met.retain(|frame| *frame < self.end());
        let seen = self.seen();
        let is_wide = middle(&seen, PixelBox::width) > middle(&seen, PixelBox::height);
        let turned = "the walker is wider than tall (is the video turned by 90 degrees?)";
        [
            ("the walker meets somebody", &met),
            ("the walker is not found", &hidden),
            ("a side of the picture cuts the walker", &self.cut),
        ]
        .into_iter()
        .filter_map(|(what, frames)| warning(frames, from, &format!("are empty, in which {what}")))
        .chain(is_wide.then(|| turned.to_owned()))
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
    tracks: Vec<FollowedFigure>,
    frames: usize,
}

impl Follower {
    /// Adds the parts of the next frame's mask. Figures of fewer than `least` pixels are none.
    pub(crate) fn push(&mut self, parts: Vec<Part>, least: usize) {
        let frame = self.frames;
        self.frames += 1;
        let mut parts: Vec<Option<Part>> = parts.into_iter().map(Some).collect();
        let active: Vec<usize> = (0..self.tracks.len())
            .filter(|at| self.tracks[*at].hidden <= MOST_HIDDEN)
            .collect();
        let mut found = self.nearest(&active, &mut parts, least);
        for &track in &active {
            let place = self.tracks[track].expected().widened();
            let large = LEAST_PIECE * self.tracks[track].area as f64;
            let is_piece =
                |part: &mut Part| part.area as f64 >= large && part.bounds.is_within(place);
            let inside: Vec<Part> = { parts.iter_mut() }
                .filter_map(|part| part.take_if(is_piece))
                .collect();
            let all = joined(found[track].take().into_iter().chain(inside));
            let enough = least.max((LEAST_LEFT * self.tracks[track].area as f64) as usize);
            found[track] = all.filter(|figure| figure.area >= enough);
        }
        // Who is expected within another one's figure, and found nowhere else, has met that one.
        let lost: Vec<usize> = { active.iter().copied() }
            .filter(|track| found[*track].is_none())
            .collect();
        let meets = |tracks: &[FollowedFigure], figure: &Part| {
            let hides = |track: &usize| {
                let other = &tracks[*track];
                other.expected().is_within(figure.bounds) && other.can_hide(figure.area)
            };
            lost.iter().any(hides)
        };
        for track in active {
            match found[track].take() {
                Some(figure) if meets(&self.tracks, &figure) => {
                    self.tracks[track].met.push(frame);
                    self.tracks[track].hide();
                }
                Some(figure) => self.tracks[track].go_on(figure),
                None => self.tracks[track].hide(),
            }
        }
        let new = parts
            .into_iter()
            .flatten()
            .filter(|part| part.area >= least);
        self.tracks
            .extend(new.map(|figure| FollowedFigure::begin(frame, figure)));
    }

    /// Takes the part of each active track that is most where the track is expected.
    fn nearest(
        &self,
        active: &[usize],
        parts: &mut [Option<Part>],
        least: usize,
    ) -> Vec<Option<Part>> {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for &track in active {
            let expected = self.tracks[track].expected();
            for (at, part) in parts.iter().enumerate() {
                let Some(part) = part.as_ref().filter(|part| part.area >= least) else {
                    continue;
                };
                let overlap = part.bounds.overlap(expected);
                let is_young = self.tracks[track].figures.len() < YOUNG;
                if overlap >= LEAST_OVERLAP || is_young && part.bounds.is_beside(expected) {
                    pairs.push((overlap, track, at));
                }
            }
        }
        // Of equal overlaps the older track goes on.
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut found: Vec<Option<Part>> = vec![None; self.tracks.len()];
        for (_, track, at) in pairs {
            if found[track].is_none() {
                found[track] = parts[at].take();
            }
        }
        found
    }

    /// Adds the parts of the next frame's mask as one figure, whatever they are.
    pub(crate) fn push_whole(&mut self, parts: Vec<Part>) {
        let frame = self.frames;
        self.frames += 1;
        match (self.tracks.first_mut(), joined(parts)) {
            (Some(track), Some(figure)) => track.go_on(figure),
            (Some(track), None) => track.hide(),
            (None, Some(figure)) => self.tracks.push(FollowedFigure::begin(frame, figure)),
            (None, None) => {}
        }
    }

    /// Returns the figures that were followed, the one with the largest sum of areas first; those
    /// that move before those that do not.
    pub(crate) fn finish(self) -> Vec<FollowedFigure> {
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

    fn followed(frames: &[Vec<(usize, usize, usize, usize)>]) -> Vec<FollowedFigure> {
        let mut follower = Follower::default();
        for blocks in frames {
            follower.push(Part::all(&mask(blocks), 1), 10);
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
    fn who_is_cut_by_a_side_is_left_out_and_said() {
        let frames: Vec<_> = (0..28).map(|at| vec![(4 * at, 10, 12, 40)]).collect();
        let mut track = followed(&frames).remove(0);
        assert_eq!(track.frames(), 28);
        track.leave_out_cut(&(0..SIZE.0));
        assert_eq!(track.frames(), 26);
        let cut = "2 frames are empty, in which a side of the picture cuts the walker: 100, 127";
        assert_eq!(track.doubts(100), [cut]);
        track.leave_out_cut(&(30..60));
        assert_eq!(
            [7, 8, 11, 12].map(|at| track.mask(at, SIZE).area()),
            [0, 480, 480, 0]
        );
    }

    #[test]
    fn spans_are_short() {
        assert_eq!(spans(&[1, 2, 3, 7, 9, 10], 1), "2 to 4, 8, 10 to 11");
        assert_eq!(
            spans(&[0, 2, 4, 6, 8, 10, 12], 0),
            "0, 2, 4, 6, 8, and 2 more"
        );
    }

    #[test]
    fn who_moves_by_more_than_their_width_a_frame_stays_one_walker() {
        let frames: Vec<_> = (0..8).map(|at| vec![(14 * at, 10, 8, 40)]).collect();
        let tracks = followed(&frames);
        assert_eq!((tracks.len(), tracks[0].frames()), (1, 8));
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
