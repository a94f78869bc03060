//! A gait cycle of silhouettes, whoever drew them.

use edgegait_core::silhouette::{Silhouette, Size};

/// Rows and columns of everything in a study: the paper's.
pub(crate) const SIZE: Size = Size::S50x30;

/// One gait cycle of one person, seen from one viewpoint.
#[derive(Clone, Debug)]
pub(crate) struct Example {
    /// Number of the person.
    pub person: usize,
    /// Number of the take among those of all people.
    pub take: usize,
    /// Which cycle of the take, from 0.
    pub position: usize,
    /// When it begins and ends, seconds of the recording.
    pub span_s: (f64, f64),
    /// Its silhouettes, and at which phase of a gait cycle each is, 0 at the left contact, 0..1.
    pub frames: Vec<(f64, Silhouette)>,
    /// Its Gait Energy Image (GEI), 0..=255.
    pub gei: Vec<u8>,
}

impl Example {
    /// The middle of its span, seconds.
    pub(crate) fn middle_s(&self) -> f64 {
        f64::midpoint(self.span_s.0, self.span_s.1)
    }

    /// The same with other silhouettes, and the GEI of these.
    pub(crate) fn with_frames(&self, of: impl Fn(&Silhouette) -> Silhouette) -> Self {
        let frames = self.frames.iter();
        let frames: Vec<_> = frames.map(|(phase, frame)| (*phase, of(frame))).collect();
        Self {
            gei: gei(frames.iter().map(|(_, frame)| frame)),
            frames,
            ..self.clone()
        }
    }

    /// Its silhouettes at so many phases, evenly: at each the nearest one.
    pub(crate) fn at_phases(&self, count: usize) -> Vec<Silhouette> {
        let nearest = |at: usize| {
            let phase = at as f64 / count as f64;
            let apart = |other: f64| {
                let apart = (phase - other).rem_euclid(1.0);
                apart.min(1.0 - apart)
            };
            let frames = self.frames.iter();
            let found = frames.min_by(|a, b| apart(a.0).total_cmp(&apart(b.0)));
            found.map_or(Silhouette::empty(SIZE), |(_, silhouette)| *silhouette)
        };
        (0..count).map(nearest).collect()
    }
}

/// The mean of silhouettes, 0..=255, rounded; nothing of none.
pub(crate) fn gei<'a>(frames: impl Iterator<Item = &'a Silhouette> + Clone) -> Vec<u8> {
    let count = frames.clone().count() as u32;
    let mut sums = vec![0_u32; SIZE.pixels()];
    for frame in frames {
        for (sums, bits) in sums.chunks_exact_mut(SIZE.columns()).zip(frame.rows()) {
            for (column, sum) in sums.iter_mut().enumerate() {
                *sum += u32::from(bits >> column & 1 == 1);
            }
        }
    }
    let byte = |sum: u32| (255 * sum + count / 2).checked_div(count).unwrap_or(0);
    #[expect(clippy::cast_possible_truncation, reason = "at most 255")]
    sums.into_iter().map(|sum| byte(sum) as u8).collect()
}

/// The gait cycles of real people and those of their synthetic twins, from one viewpoint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RealAndSynthetic<'a> {
    /// Cycles of recorded silhouettes.
    pub real: &'a [Example],
    /// Cycles of the twins.
    pub synthetic: &'a [Example],
}

/// What one result of a study was measured with, by name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StudySetting<'a> {
    /// The viewpoint.
    pub view: &'a str,
    /// How masks were made.
    pub masks: &'static str,
    /// How figures were fitted into the image.
    pub framing: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(row: usize, column: usize) -> Silhouette {
        let mut rows = vec![0; SIZE.rows()];
        rows[row] = 1 << column;
        Silhouette::from_rows(SIZE, &rows)
    }

    #[test]
    fn a_gei_is_the_mean_of_its_frames_rounded() {
        let frames = [dot(3, 4), dot(3, 4), dot(49, 29)];
        let gei = gei(frames.iter());
        assert_eq!((gei[3 * 30 + 4], gei[1499], gei[0]), (170, 85, 0));
        assert_eq!(super::gei([].iter()), vec![0; 1500]);
    }

    #[test]
    fn phases_take_the_nearest_frame_round_the_cycle() {
        let frames = vec![(0.2, dot(1, 1)), (0.6, dot(2, 2)), (0.95, dot(3, 3))];
        let example = Example {
            person: 0,
            take: 0,
            position: 0,
            span_s: (1.0, 2.0),
            gei: Vec::new(),
            frames,
        };
        let found = example.at_phases(4);
        assert_eq!(found, [dot(3, 3), dot(1, 1), dot(2, 2), dot(2, 2)]);
        assert_eq!(example.middle_s(), 1.5);
    }
}
